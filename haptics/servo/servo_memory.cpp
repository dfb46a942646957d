#include "haptics/servo/servo_memory.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "volume/base/bytes.h"
#include "volume/scan/traversal.h"

namespace trephine::haptics {

namespace {

// If an assertion fails because a struct has a new field, add the field to the list of its fields.
static_assert(sizeof(ServoCore) == 7456 && sizeof(ProxyState) == 816 && sizeof(ServoRecord) == 384);

template <class Fields>
void fields_of(PlaneMemory& p, Fields& fields) {
  fields(p.point_world, p.normal_world, p.recovery, p.shape, p.age, p.recovery_left);
}
template <class Fields>
void fields_of(Placement& p, Fields& fields) {
  fields(p.position_world, p.rotation);
}
template <class Fields>
void fields_of(Surroundings& s, Fields& fields) {
  fields(s.passable, s.new_models, s.nearby, s.near_middle_world, s.near_radius, s.has_placements);
  if (s.has_placements) fields(s.placements, s.time);
  bool has_sets = s.sets != decltype(s.sets){};
  fields(has_sets);
  if (has_sets) fields(s.sets);
}
template <class Fields>
void fields_of(ProxyState& s, Fields& fields) {
  fields(s.has_proxy, s.proxy_volume, s.inside, s.had_contact, s.is_sticking, s.touched_mover, s.version,
         s.plane, s.has_turn, s.tool_turn, s.balls_inside, s.has_mesh_proxy, s.mesh_proxy_world, s.around);
}
/// Leaves out path, contacts and counters, which belong to one tick only.
template <class Fields>
void fields_of(ProxyStep& s, Fields& fields) {
  fields(s.proxy_world, s.normal_world, s.has_contact, s.shape, s.side, s.is_buried, s.object_motion_world,
         s.turn_world);
}
template <class Fields>
void fields_of(EscapePath& w, Fields& fields) {
  fields(w.serial, w.count);
  w.count = w.count <= EscapePath::k_max_positions ? w.count : 0;  // may come from an invalid file
  for (std::uint32_t i = 0; i < w.count; ++i) fields(w.positions_volume[i]);
}
template <class Fields>
void fields_of(EnergyLedger& e, Fields& fields) {
  fields(e.contact, e.friction, e.active, e.turning, e.growth, e.discarded);
}
template <class Fields>
void fields_of(Pose& p, Fields& fields) {
  fields(p.position_world, p.orientation, p.buttons, p.axes);
}
template <class Fields>
void fields_of(TouchEvent& e, Fields& fields) {
  fields(e.kind, e.shape);
}
template <class Fields>
void fields_of(ServoRecord& r, Fields& fields) {
  fields(r.tick, r.t, r.version, r.pose, r.proxy_world, r.normal_world, r.force_world, r.torque_world,
         r.contact_force_world, r.turn_world, r.has_contact, r.is_buried, r.is_escaping, r.shape, r.side,
         r.faults, r.raised, r.is_reset, r.is_restarted, r.restart_volume, r.hand, r.energy, r.event_count);
  r.event_count = r.event_count <= ServoRecord::k_max_events ? r.event_count : 0;
  for (std::uint8_t i = 0; i < r.event_count; ++i) fields(r.events[i]);
}

template <class T, class Fields>
concept HasFields = requires(T& value, Fields& fields) {
  value.each_field(fields);
};

constexpr double k_max = 1e12;  // in any unit

/// Writes or reads every field; booleans other than 0 and 1, and numbers that are not finite or beyond k_max,
/// are refused.
template <bool k_is_saving>
struct Fields {
  std::string* out = nullptr;
  std::string_view in = {};
  bool is_good = true;

  template <class... T>
  void operator()(T&... values) {
    (visit(values), ...);
  }

 private:
  template <class T>
  void raw(T& value) {
    if constexpr (k_is_saving)
      put(*out, value);
    else
      is_good = is_good && get(in, value);
  }
  template <class T>
  void visit(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      auto byte = static_cast<std::uint8_t>(value);
      raw(byte);
      value = byte != 0;
      is_good = is_good && byte <= 1;
    } else if constexpr (std::is_floating_point_v<T>) {
      raw(value);
      is_good = is_good && std::abs(value) <= k_max;
    } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::byte>) {
      raw(value);
    } else if constexpr (std::is_same_v<T, glm::dvec3>) {
      (*this)(value.x, value.y, value.z);
    } else if constexpr (std::is_same_v<T, glm::dquat>) {
      (*this)(value.w, value.x, value.y, value.z);
    } else if constexpr (std::is_same_v<T, ShapeSet>) {
      raw(value);
    } else if constexpr (HasFields<T, Fields>) {
      value.each_field(*this);
    } else {
      fields_of(value, *this);
    }
  }
  /// The memory of a law has an unknown layout and is mostly zeros, so it is stored in runs of words.
  void visit(std::array<std::byte, ServoLaw::k_memory>& memory) {
    std::array<std::uint64_t, ServoLaw::k_memory / sizeof(std::uint64_t)> words;
    static_assert(sizeof words == ServoLaw::k_memory);
    std::memcpy(words.data(), memory.data(), sizeof words);
    if constexpr (k_is_saving)
      put_runs(*out, words.data(), words.size());
    else
      is_good = is_good && get_runs(in, words.data(), words.size());
    std::memcpy(memory.data(), words.data(), sizeof words);
  }
  template <class T, std::size_t N>
  void visit(std::array<T, N>& values) {
    for (T& value : values) visit(value);
  }
};

bool is_item(int index, const TouchScene& scene) noexcept { return index >= -1 && index < item_count(scene); }

bool is_side(Side side) noexcept { return side <= Side::both; }

/// Returns true if a voxel index is within the range of the voxel traversal.
bool is_in_traversal_range(const glm::dvec3& p_volume) noexcept {
  const glm::dvec3 a = glm::abs(p_volume);
  return std::max({a.x, a.y, a.z}) < 0.25 * volume::k_traversal_limit;
}

}  // namespace

std::string ServoMemory::save(const ServoCore& core, const ServoHand& hand) {
  ServoCore copy = core;
  // Adopts the scene as the next step would, so that no index refers to a removed item.
  if (copy.layout_ != hand.layout) copy.adopt(hand);
  // An instrument may make all item numbers passable, also numbers without an item in the scene.
  ShapeSet& passable = copy.state_.around.passable;
  for (int s = passable.next(item_count(*hand.scene)); s < ShapeSet::k_max; s = passable.next(s + 1))
    passable.set(s, false);
  // Serial numbers are valid only in this run of the program. 1 stands for the current one; for the version,
  // 0 stands for any other.
  copy.layout_ = 1;
  copy.state_.version = hand.state.version && core.state_.version == hand.state.version->serial();
  std::string out;
  Fields<true> fields{&out};
  copy.each_field(fields);
  return out;
}

bool ServoMemory::load(std::string_view bytes, const ServoHand& hand, ServoCore& core) {
  ServoCore result = core;
  Fields<false> fields{nullptr, bytes};
  result.each_field(fields);
  const TouchScene& scene = *hand.scene;
  const ProxyState& state = result.state_;
  bool is_good = fields.is_good && fields.in.empty() && is_in_traversal_range(state.proxy_volume) &&
                 is_in_traversal_range(result.anchor_volume_) &&
                 (!result.is_escaping_ || result.next_position_ <= result.escape_path_.count);
  for (const int item : {result.touched_item_, result.last_shape_, result.popped_shape_, result.step_.shape,
                         state.touched_mover, state.plane.shape})
    is_good = is_good && is_item(item, scene);
  is_good = is_good && std::abs(glm::length(state.tool_turn) - 1) < 1e-6 &&
            (scene.tool->shell() || (state.balls_inside >> ToolShape::k_max_balls) == 0);
  for (const ServoCore::RecentPose& recent : result.recent_poses_)
    is_good = is_good && std::abs(glm::length(recent.pose.rotation) - 1) < 1e-6;
  for (const Side side : {result.step_.side, result.popped_side_}) is_good = is_good && is_side(side);
  for (std::uint32_t i = 0; i < result.escape_path_.count; ++i)
    is_good = is_good && is_in_traversal_range(result.escape_path_.positions_volume[i]);
  for (const ShapeSet& items : {state.inside, state.around.nearby, state.around.passable,
                                state.around.new_models, result.not_ready_, result.reported_not_ready_})
    is_good = is_good && items.next(item_count(scene)) == ShapeSet::k_max;
  for (int s = state.inside.next(0); is_good && s < ShapeSet::k_max; s = state.inside.next(s + 1))
    is_good = !item_of(scene, s).is_mesh();
  const auto is_share = [](double share) { return share >= 0 && share <= 1; };
  is_good = is_good && is_share(result.guard_.fade()) && is_share(result.passivity_.force_scale());
  // A device would render a wrench beyond the limits at once.
  for (const Wrench& wrench : {result.guard_.last(), result.last_})
    is_good = is_good && glm::length(wrench.force_world) <= 1.001 * result.force_limit_ &&
              glm::length(wrench.torque_world) <= 1.001 * result.guard_.torque_limit();
  if (!is_good || result.touched_item_ < 0) return false;
  result.layout_ = result.layout_ == 1 ? hand.layout : ~std::uint64_t{0};
  result.state_.version =
      result.state_.version == 1 && hand.state.version ? hand.state.version->serial() : ~std::uint64_t{0};
  if (hand.laws) result.laws_.bind_loaded(*hand.laws);
  core = result;
  return true;
}

void put_record(std::string& out, const ServoRecord& record) {
  ServoRecord copy = record;
  Fields<true> fields{&out};
  fields_of(copy, fields);
}

bool get_record(std::string_view& in, ServoRecord& record) {
  Fields<false> fields{nullptr, in};
  fields_of(record, fields);
  in = fields.in;
  return fields.is_good && is_side(record.side) && record.hand < ServoScene::k_max_hands;
}

}  // namespace trephine::haptics
