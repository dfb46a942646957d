#include "haptics/servo/servo_memory.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "volume/bytes.h"
#include "volume/traversal.h"

namespace trephine::haptics {

namespace {

// A struct that grows belongs here with its new field.
static_assert(sizeof(ServoCore) == 7248 && sizeof(ProxyState) == 816 && sizeof(ServoRecord) == 384);

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
  fields(s.let_through, s.fresh, s.near, s.near_middle_world, s.near_radius, s.has_placements);
  if (s.has_placements) fields(s.placements, s.time);
  bool has_sets = s.sets != decltype(s.sets){};
  fields(has_sets);
  if (has_sets) fields(s.sets);
}
template <class Fields>
void fields_of(ProxyState& s, Fields& fields) {
  fields(s.has_proxy, s.proxy_volume, s.inside, s.had_contact, s.is_sticking, s.touched, s.version, s.plane,
         s.has_turn, s.tool_turn, s.balls_inside, s.has_on_meshes, s.on_meshes_world, s.around);
}
/// Its path and counters are of one tick alone.
template <class Fields>
void fields_of(ProxyStep& s, Fields& fields) {
  fields(s.proxy_world, s.normal_world, s.has_contact, s.shape, s.side, s.is_buried, s.carried_world,
         s.turn_world);
}
template <class Fields>
void fields_of(WayOut& w, Fields& fields) {
  fields(w.serial, w.count);
  w.count = w.count <= WayOut::k_most_places ? w.count : 0;  // as a file says
  for (std::uint32_t i = 0; i < w.count; ++i) fields(w.places_volume[i]);
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
         r.press_world, r.turn_world, r.has_contact, r.is_buried, r.is_led, r.shape, r.side, r.faults,
         r.raised, r.is_reset, r.is_restarted, r.restart_volume, r.hand, r.energy, r.event_count);
  r.event_count = r.event_count <= ServoRecord::k_most_events ? r.event_count : 0;
  for (std::uint8_t i = 0; i < r.event_count; ++i) fields(r.events[i]);
}

template <class T, class Fields>
concept HasFields = requires(T& value, Fields& fields) {
  value.each_field(fields);
};

constexpr double k_most = 1e12;  // whatever unit

/// Puts every field, or gets it; invalid places and numbers are refused.
template <bool k_is_saving>
struct Fields {
  std::string* out = nullptr;
  std::string_view in = {};
  bool is_good = true;

  template <class... T>
  void operator()(T&... values) {
    (one(values), ...);
  }

 private:
  template <class T>
  void raw(T& value) {
    if constexpr (k_is_saving)
      volume::put(*out, value);
    else
      is_good = is_good && volume::get(in, value);
  }
  template <class T>
  void one(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      auto byte = static_cast<std::uint8_t>(value);
      raw(byte);
      value = byte != 0;
      is_good = is_good && byte <= 1;
    } else if constexpr (std::is_floating_point_v<T>) {
      raw(value);
      is_good = is_good && std::abs(value) <= k_most;
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
  /// Memory of a law is its own, and mostly zeros.
  void one(std::array<std::byte, ServoLaw::k_memory>& memory) {
    std::array<std::uint64_t, ServoLaw::k_memory / sizeof(std::uint64_t)> words;
    static_assert(sizeof words == ServoLaw::k_memory);
    std::memcpy(words.data(), memory.data(), sizeof words);
    if constexpr (k_is_saving)
      volume::put_runs(*out, words.data(), words.size());
    else
      is_good = is_good && volume::get_runs(in, words.data(), words.size());
    std::memcpy(memory.data(), words.data(), sizeof words);
  }
  template <class T, std::size_t N>
  void one(std::array<T, N>& values) {
    for (T& value : values) one(value);
  }
};

bool is_item(int index, const TouchScene& scene) noexcept { return index >= -1 && index < item_count(scene); }

bool is_side(Side side) noexcept { return side <= Side::both; }

/// Range in which voxels can be counted.
bool is_near(const glm::dvec3& p_volume) noexcept {
  const glm::dvec3 a = glm::abs(p_volume);
  return std::max({a.x, a.y, a.z}) < 0.25 * volume::k_traversal_limit;
}

}  // namespace

std::string ServoMemory::save(const ServoCore& core, const ServoHand& mine) {
  ServoCore copy = core;
  // As the next step does first, so that nothing refers to what is gone.
  if (copy.layout_ != mine.layout) copy.adopt(mine);
  // Numbers of this run: whether they are the newest is what counts.
  copy.layout_ = 1;
  copy.state_.version = mine.state.version && core.state_.version == mine.state.version->serial();
  std::string out;
  Fields<true> fields{&out};
  copy.each_field(fields);
  return out;
}

bool ServoMemory::load(std::string_view bytes, const ServoHand& mine, ServoCore& core) {
  ServoCore made = core;
  Fields<false> fields{nullptr, bytes};
  made.each_field(fields);
  const TouchScene& scene = *mine.scene;
  const ProxyState& state = made.state_;
  bool is_good = fields.is_good && fields.in.empty() && is_near(state.proxy_volume) &&
                 is_near(made.anchor_volume_) && (!made.is_led_ || made.next_place_ <= made.way_.count);
  for (const int item : {made.touched_, made.last_shape_, made.popped_shape_, made.step_.shape, state.touched,
                         state.plane.shape})
    is_good = is_good && is_item(item, scene);
  is_good = is_good && std::abs(glm::length(state.tool_turn) - 1) < 1e-6 &&
            (state.balls_inside >> TouchScene::k_most_balls) == 0;
  for (const ServoCore::Place& place : made.places_)
    is_good = is_good && std::abs(glm::length(place.where.rotation) - 1) < 1e-6;
  for (const Side side : {made.step_.side, made.popped_side_}) is_good = is_good && is_side(side);
  for (std::uint32_t i = 0; i < made.way_.count; ++i)
    is_good = is_good && is_near(made.way_.places_volume[i]);
  for (const ShapeSet& some : {state.inside, state.around.near, state.around.let_through, state.around.fresh,
                               made.not_ready_, made.told_not_ready_})
    is_good = is_good && some.next(item_count(scene)) == ShapeSet::k_most;
  for (int s = state.inside.next(0); is_good && s < ShapeSet::k_most; s = state.inside.next(s + 1))
    is_good = !item_of(scene, s).is_mesh();
  const auto is_share = [](double share) { return share >= 0 && share <= 1; };
  is_good = is_good && is_share(made.guard_.fade()) && is_share(made.passivity_.softness());
  // A device would feel it at once.
  for (const glm::dvec3& force : {made.guard_.last(), made.last_force_})
    is_good = is_good && glm::length(force) <= 1.001 * made.force_limit_;
  for (const glm::dvec3& torque : {made.guard_.last_torque(), made.last_torque_})
    is_good = is_good && glm::length(torque) <= made.guard_.torque_limit() * 1.001;
  if (!is_good || made.touched_ < 0) return false;
  made.layout_ = made.layout_ == 1 ? mine.layout : ~std::uint64_t{0};
  made.state_.version =
      made.state_.version == 1 && mine.state.version ? mine.state.version->serial() : ~std::uint64_t{0};
  if (mine.laws) made.laws_.belong_to(*mine.laws);
  core = made;
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
  return fields.is_good && is_side(record.side) && record.hand < ServoScene::k_most_hands;
}

}  // namespace trephine::haptics
