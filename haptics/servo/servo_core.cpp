#include "haptics/servo/servo_core.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <xmmintrin.h>

#include "haptics/depth/depth_source.h"
#include "haptics/force/limited.h"
#include "volume/traversal.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_farthest_mm = 1e6;  // a pose beyond this is a broken device, not a place

bool is_place(const dvec3& p) noexcept {
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(p[a]) <= k_farthest_mm)) return false;
  return true;
}

/// Numbers all over, whatever they say.
bool is_finite(const Pose& pose) noexcept {
  const glm::dquat& q = pose.orientation;
  bool is_good = std::abs(q.w) + std::abs(q.x) + std::abs(q.y) + std::abs(q.z) <= k_farthest_mm;
  for (const float axis : pose.axes) is_good = is_good && std::abs(axis) <= Pose::k_farthest_axis;
  return is_good;
}

/// Largest coordinate at which voxels can still be counted, however small they are.
bool is_in_reach(const volume::Frame& frame, const dvec3& p) noexcept {
  const dvec3 v = frame.volume_from_world(p);
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(v[a]) < 0.25 * volume::k_traversal_limit)) return false;
  return true;
}
bool is_in_reach(const TouchScene& scene, const dvec3& p) noexcept {
  for (const auto& other : scene.others)
    if (!is_in_reach(other->frame, p)) return false;
  return is_in_reach(scene.base->frame, p);
}

}  // namespace

ServoCore::ServoCore(const ForceOptions& options, double dt, std::size_t hand, std::uint64_t first_tick)
    : force_(options, dt),
      guard_(options, dt),
      dt_(dt),
      force_limit_(options.force_limit),
      hand_(hand),
      tick_(first_tick),
      cap_(options.force_limit),
      passivity_(0, options.delay_ticks, options.device_damping / dt),
      is_passive_(options.is_passive) {}

const char* event_name(TouchEvent::Kind kind) noexcept {
  constexpr const char* k_names[] = {"touched",   "untouched", "popped",         "rearmed",
                                     "not ready", "ready",     "lost resistance"};
  return k_names[kind];
}

namespace {
void add_event(ServoRecord& record, TouchEvent::Kind kind, int shape) noexcept {
  if (record.event_count < ServoRecord::k_most_events)
    record.events[record.event_count++] = {kind, static_cast<std::int16_t>(shape)};
}
}  // namespace

void ServoCore::let_through_what_is_off(const ServoHand& mine) noexcept {
  ShapeSet& off = state_.around.let_through;
  off = mine.untouchable | not_ready_;
  if (popped_shape_ >= 0) off.set(popped_shape_, true);
}

/// Items that cannot hold yet. One of which a part is ready holds where that is: around hand and proxy, with
/// what is read around them.
void ServoCore::find_ready(const ServoHand& mine, const dvec3& hip) noexcept {
  not_ready_ = mine.not_ready;
  const volume::Volume& base = *mine.scene->base;
  if (mine.part_count == 0 && mine.state.depths.empty()) return;
  double farthest = mine.scene->tool_radius;
  for (const dvec3& at : mine.scene->tool_balls)
    farthest = std::max(farthest, mine.scene->tool_radius + glm::length(at));
  if (!mine.state.depths.empty()) find_depths_ready(mine, hip, farthest);
  for (std::size_t i = 0; i < mine.part_count; ++i) {
    const auto& [index, voxels] = mine.parts[i];
    const TouchItem& item = item_of(*mine.scene, index);
    const volume::Volume& of = item.is_mesh() ? base : item.field.volume();
    const dvec3 at = of.frame.volume_from_world(hip);
    const dvec3 proxy =
        state_.has_proxy ? of.frame.volume_from_world(base.frame.world_from_volume(state_.proxy_volume)) : at;
    bool is_within = true, is_beside = false;
    for (int a = 0; a < 3; ++a) {
      constexpr double k_beside = 3;  // voxels
      dvec3 along(0);
      along[a] = 1;
      const double reach = k_beside + farthest * glm::length(of.frame.gradient_world_from_volume(along));
      const double low = std::max(0.0, std::min(at[a], proxy[a]) - reach),
                   high = std::min(of.size[a] - 1.0, std::max(at[a], proxy[a]) + reach);
      is_beside = is_beside || low > high;
      is_within = is_within && low >= voxels.low[a] && high <= voxels.high[a];
    }
    // Beyond the volume's border there is nothing to wait for.
    not_ready_.set(index, !is_within && !is_beside);
  }
}

/// Items touched by depth images hold where these look, and fade where new ones are long due.
void ServoCore::find_depths_ready(const ServoHand& mine, const dvec3& hip, double farthest) noexcept {
  const dvec3 proxy = state_.has_proxy ? mine.scene->base->frame.world_from_volume(state_.proxy_volume) : hip;
  int d = 0;
  for (int s = 0; s < item_count(*mine.scene); ++s) {
    const TouchItem& item = item_of(*mine.scene, s);
    if (!item.depth) continue;
    const depth::DepthSet* set = depth::set_in(mine.state, d++);
    Placement place = item.placement;
    if (item.mover >= 0 && static_cast<std::size_t>(item.mover) < mine.placement_count)
      place = mine.placements[static_cast<std::size_t>(item.mover)];
    // The box of all its motion does not go on with it.
    const dvec3 hip_there = place.local_from_world(hip), proxy_there = place.local_from_world(proxy);
    if (set) place = place * set->place_at(time());
    const dvec3 here = place.local_from_world(hip), there = place.local_from_world(proxy);
    const double late = set && set->goes_on ? time() - set->view.time - set->view.interval : 0;
    const bool is_known = set && set->knows(here, farthest) && set->knows(there, farthest) &&
                          late < depth::k_foretold + depth::k_fading;
    dvec3 low, high;
    item.depth->bounds(low, high);
    const auto is_far = [&](const dvec3& p) {
      const dvec3 off = p - glm::clamp(p, low, high);
      return glm::length(off) > farthest + depth::k_beside;
    };
    if (!is_known && !(is_far(hip_there) && is_far(proxy_there))) not_ready_.set(s, true);
    if (late > depth::k_foretold && step_.has_contact && step_.shape == s)
      cap_ = std::min(cap_, std::max(0.0, 1 - (late - depth::k_foretold) / depth::k_fading) * force_limit_);
  }
}

/// Another scene or method: what was known of its surroundings is out of date, and items may be gone.
void ServoCore::adopt(const ServoHand& mine) noexcept {
  const int count = item_count(*mine.scene);
  for (int s = 0; s < count; ++s)
    if (const TouchItem& item = item_of(*mine.scene, s); item.is_mesh() && item.since > layout_)
      state_.around.fresh.set(s, true);
  for (ShapeSet* some : {&state_.around.fresh, &state_.around.let_through, &not_ready_})
    for (int s = some->next(count); s < ShapeSet::k_most; s = some->next(s + 1)) some->set(s, false);
  if (step_.shape >= count) step_.shape = -1;
  layout_ = mine.layout;
  popped_shape_ = last_shape_ = -1;
  if (touched_ >= count) touched_ = 0;
  if (!mine.scene->tool_balls.empty() ||
      state_.has_turn) {  // another tool: it may lie in what the last one did not
    state_.version = ~std::uint64_t{0};
    state_.has_turn = false;
    state_.balls_inside = 0;
    force_.forget_turn();
  }
  told_not_ready_ = ShapeSet{};
  state_.touched = -1;
  state_.around.near = ShapeSet{};
  state_.around.near_radius = 0;
  state_.around.has_placements = false;
  state_.plane = PlaneMemory{};
  state_.has_on_meshes = false;
}

/// A surface that is pressed harder than it bears gives way; one that gave way holds again when the tool is
/// some way from there.
void ServoCore::pop_through(const ServoHand& mine, const dvec3& hip, ServoRecord& record) noexcept {
  const TouchScene& scene = *mine.scene;
  if (popped_shape_ >= 0) {
    const Material& material = material_of(scene, popped_shape_, popped_side_);
    if (glm::length(hip - popped_at_world_) < material.pop_rearm) return;
    add_event(record, TouchEvent::rearmed, std::exchange(popped_shape_, -1));
    return;
  }
  if (!step_.has_contact || is_led_) return;
  const Material& material = material_of(scene, step_.shape, step_.side);
  const double pressed = glm::dot(step_.proxy_world - hip, step_.normal_world) *
                         stiffness_at(scene, step_.shape, step_.side, step_.proxy_world, step_.normal_world);
  if (!(material.pop_force > 0) || pressed <= material.pop_force) return;
  popped_shape_ = step_.shape;
  popped_side_ = step_.side;
  popped_at_world_ = hip;
  add_event(record, TouchEvent::popped, popped_shape_);  // from the next tick on
}

/// Changes since the last tick.
void ServoCore::emit_events(ServoRecord& record) noexcept {
  const int shape = record.has_contact ? record.shape : -1;
  if (shape != last_shape_) {
    if (last_shape_ >= 0) add_event(record, TouchEvent::untouched, last_shape_);
    if (shape >= 0) add_event(record, TouchEvent::touched, shape);
    last_shape_ = shape;
  }
  if (not_ready_ == told_not_ready_) return;
  for (int s = 0; s < ShapeSet::k_most; ++s) {
    if (not_ready_.contains(s) == told_not_ready_.contains(s)) continue;
    add_event(record, not_ready_.contains(s) ? TouchEvent::not_ready : TouchEvent::ready, s);
  }
  told_not_ready_ = not_ready_;
}

ServoRecord ServoCore::step(const ServoScene& seen, const ServoInput& input) noexcept {
  if (hand_ >= seen.hands.size()) return without_scene(seen, input);
  const ServoHand& mine = seen.hands[hand_];
  const TouchScene& scene = *mine.scene;
  if (mine.layout != layout_) adopt(mine);
  if (input.is_reset) reset();
  if (input.is_restarted) {
    // Invalid positions can only come from a file.
    const dvec3 place = scene.base->frame.world_from_volume(input.restart_volume);
    if (is_place(place) && is_in_reach(scene, place)) restart_at(input.restart_volume);
  }
  ServoRecord record;
  record.tick = tick_++;
  record.t = static_cast<double>(record.tick) * dt_;
  record.version = seen.serial;
  record.pose = input.pose;
  record.hand = static_cast<std::uint8_t>(hand_);
  record.is_reset = input.is_reset;
  record.is_restarted = input.is_restarted;
  record.restart_volume = input.restart_volume;
  std::uint32_t faults = input.faults;
  wanted_ = dvec3(0);
  if (is_turning_) torque_ = dvec3(0);
  const dvec3& hip = input.pose.position_world;
  if (is_place(hip) && is_finite(input.pose) && is_in_reach(scene, hip) && (faults & fault_not_finite) == 0) {
    // Growth before the first tick buries no proxy.
    if (is_fresh_ && mine.way) way_.serial = mine.way->serial;
    is_fresh_ = false;
    const bool has_grown = mine.way && mine.way->serial > way_.serial;
    if (has_grown) {
      way_ = *mine.way;
      if (is_led_ && way_.count > 0)
        begin_lead(mine, hip);
      else if (is_led_)
        let_go();
    }
    find_ready(mine, hip);
    let_through_what_is_off(mine);
    if (!is_led_) {
      step_ = mine.held_count > 0
                  ? step_with_held(mine, input)
                  : mine.method->step(scene, mine.state, state_,
                                      {hip, std::span(mine.placements.data(), mine.placement_count),
                                       input.pose.orientation, time()});
      if (step_.has_contact) touched_ = step_.shape;
      if (step_.is_buried && has_grown && way_.count > 0) begin_lead(mine, hip);
    }
    if (is_led_) lead(mine, hip);
    cap_ = is_led_ ? k_lead_force : std::min(force_limit_, cap_ + k_lead_recovery * dt_);
    wanted_ = limited(force_.step(step_, hip, scene), cap_);
    record.press_world = wanted_;
    dvec3 torque(0);
    if (!scene.tool_balls.empty())
      torque = (cap_ < force_limit_ ? cap_ / force_limit_ : 1) * force_.turn(step_, scene);
    active_ = dvec3(0);
    if (mine.laws) {
      // As the record will say it: what is played again hears the same.
      const bool is_working =
          input.pose.is_pressed() && !is_led_ && ((guard_.faults() | faults) & k_latched_faults) == 0;
      const LawForces forces =
          laws_.step(*mine.laws, {scene, mine.state.version.get(), step_, wanted_, hip,
                                  input.pose.orientation, dvec3(0), dvec3(0), dt_, is_working});
      wanted_ += forces.rendered_world;
      active_ = forces.active_world;
      torque += forces.torque_world;
      if (forces.has_lost_resistance) add_event(record, TouchEvent::lost_resistance, forces.lost_shape);
    } else if (!laws_.is_empty()) {
      laws_.reset();
    }
    if (torque != dvec3(0)) torque_ = torque, is_turning_ = true;
    // Force and torque of tools of several balls come of one potential, and it would see the force alone.
    if (is_passive_ && scene.tool_balls.empty())
      wanted_ = passivity_.step(wanted_, hip, step_.has_contact ? step_.proxy_world : hip);
    wanted_ += active_;
    if (mine.has_pops) pop_through(mine, hip, record);
    record.proxy_world = step_.proxy_world;
    record.turn_world = step_.turn_world;
    record.normal_world = step_.normal_world;
    record.has_contact = step_.has_contact;
    record.is_buried = step_.is_buried;
    record.is_led = is_led_;
    record.shape = step_.shape;
    record.side = step_.side;
  } else {
    record.pose = Pose{dvec3(0), {1, 0, 0, 0}, input.pose.buttons};
    faults |= fault_not_finite;
  }
  record.raised = faults;
  record.force_world = guard_.step(wanted_, faults);
  if (is_turning_) record.torque_world = guard_.turn(torque_);
  record.faults = guard_.faults();
  if (is_passive_) {
    passivity_.set_rendered(passive_part(record.force_world));
    if (faults & fault_not_finite) passivity_.lose_sight();
  }
  // Without a force there is no hand on the tool, and a tool on its way out rests: nothing is cut.
  if ((record.faults & k_latched_faults) || is_led_) record.pose.buttons = 0, record.pose.axes = {};
  emit_events(record);
  account(record);
  record.energy = energy_;
  if (seen.has_held || knows_place_) remember_place(seen, record);
  if (is_led_ && next_place_ == way_.count) {
    is_led_ = false;  // arrived: from here on the method holds it
    state_.begin_at(anchor_volume_);
    state_.around.has_placements = false;  // what moved meanwhile moved past it
  }
  return record;
}

/// Held bodies go to the hands of the previous tick.
ProxyStep ServoCore::step_with_held(const ServoHand& mine, const ServoInput& input) noexcept {
  std::array<Placement, TouchScene::k_max_movers> placements = mine.placements;
  for (std::size_t i = 0; i < mine.held_count; ++i) {
    const ServoHand::Held& held = mine.held[i];
    if (input.places && (*input.places)[held.by])
      placements[static_cast<std::size_t>(held.mover)] = *(*input.places)[held.by] * held.grip;
  }
  return mine.method->step(*mine.scene, mine.state, state_,
                           {input.pose.position_world, std::span(placements.data(), mine.placement_count),
                            input.pose.orientation, time()});
}

/// Position while its device is seen.
void ServoCore::remember_place(const ServoScene& seen, const ServoRecord& record) noexcept {
  if (!seen.has_held) {
    places_ = {};
    knows_place_ = false;
  } else if ((record.raised & fault_not_finite) == 0) {
    places_[1] = places_[0];
    places_[0] = {place_of(record.pose), record.tick, true};
    knows_place_ = true;
  }
}

Placement place_of(const Pose& pose) noexcept { return {pose.position_world, unit_of(pose.orientation)}; }

std::optional<Placement> ServoCore::place_before(std::uint64_t tick) const noexcept {
  for (const Place& place : places_)
    if (place.is_known && place.tick < tick) return place.where;
  return std::nullopt;
}

/// A scene without this hand: no contact.
ServoRecord ServoCore::without_scene(const ServoScene& seen, const ServoInput& input) noexcept {
  ServoRecord record;
  record.tick = tick_;
  record.t = time();
  record.version = seen.serial;
  record.pose = Pose{dvec3(0), {1, 0, 0, 0}, 0};
  record.hand = static_cast<std::uint8_t>(hand_);
  record.raised = input.faults | fault_stale_scene;
  const Wrench rendered = skip(record.raised);
  record.force_world = rendered.force_world;
  record.torque_world = rendered.torque_world;
  record.faults = guard_.faults();
  record.energy = energy_;
  return record;
}

/// Part of a guarded force that effects did not make: the guard limits all parts alike.
dvec3 ServoCore::passive_part(const dvec3& rendered) const noexcept {
  const double wanted = glm::dot(wanted_, wanted_);
  if (active_ == dvec3(0) || !(wanted > 0)) return rendered;
  return rendered - active_ * std::min(1.0, std::sqrt(glm::dot(rendered, rendered) / wanted));
}

Wrench ServoCore::skip(std::uint32_t faults, std::uint64_t count) noexcept {
  had_position_ = false;
  if (is_passive_) passivity_.lose_sight();
  tick_ += count;
  for (; count > 0; --count) {
    last_force_ = guard_.step(wanted_, faults);
    if (is_turning_) last_torque_ = guard_.turn(torque_);
    if (guard_.is_faded()) break;
  }
  return {last_force_, last_torque_};
}

/// Matter grew with no way out of it: set free where the hand is, without force.
void ServoCore::let_go() noexcept {
  is_led_ = false;
  state_.forget();
  force_.reset();
}

void ServoCore::begin_lead(const ServoHand& mine, const dvec3& hip_world) noexcept {
  const volume::Frame& frame = mine.scene->base->frame;
  const dvec3 out = frame.world_from_volume(way_.places_volume[way_.count - 1]);
  if (!is_led_) {
    // The spring starts unstretched at the hand, wherever that is.
    anchor_volume_ = frame.volume_from_world(hip_world);
    force_.let_go();
    const double reach = glm::length(out - hip_world);
    energy_.discarded += 0.5 * material_of(*mine.scene, touched_, Side::front).stiffness * reach * reach;
  }
  next_place_ = 0;
  is_led_ = true;
}

void ServoCore::lead(const ServoHand& mine, const dvec3& hip_world) noexcept {
  const volume::Frame& frame = mine.scene->base->frame;
  double left = k_lead_speed * dt_;
  while (next_place_ < way_.count && left > 0) {
    const dvec3 way = way_.places_volume[next_place_] - anchor_volume_;
    const double length = glm::length(frame.vector_world_from_volume(way));
    if (length <= left) {
      anchor_volume_ = way_.places_volume[next_place_++];
      left -= length;
    } else {
      anchor_volume_ += (left / length) * way;
      left = 0;
    }
  }
  step_.proxy_world = frame.world_from_volume(anchor_volume_);
  const dvec3 out = step_.proxy_world - hip_world;
  const double length = glm::length(out);
  step_.normal_world = length > 0 ? out / length : dvec3(0);
  step_.has_contact = true;
  step_.shape = touched_;
  step_.is_buried = false;
  step_.side = Side::front;
  step_.carried_world = step_.turn_world = dvec3(0);
  step_.waypoint_count = 0;
  step_.contacts.clear();
}

void ServoCore::account(const ServoRecord& record) noexcept {
  const dvec3& position = record.pose.position_world;
  const bool has_position = (record.raised & fault_not_finite) == 0;
  if (had_position_ && has_position) account_motion(position - last_position_);
  if (is_turning_) account_turn(record, had_position_ && has_position);
  had_position_ = has_position;
  was_led_ = record.is_led;
  last_force_ = record.force_world;
  last_active_ = active_ == dvec3(0) ? dvec3(0) : last_force_ - passive_part(last_force_);
  last_normal_ = record.normal_world;
  last_position_ = position;
}

/// Until nothing is left of a torque.
void ServoCore::account_turn(const ServoRecord& record, bool goes_on) noexcept {
  if (goes_on) energy_.turning += glm::dot(last_torque_, turn_between(last_turn_, record.pose.orientation));
  last_torque_ = record.torque_world;
  last_turn_ = record.pose.orientation;
  is_turning_ = last_torque_ != dvec3(0) || torque_ != dvec3(0);
}

void ServoCore::account_motion(const dvec3& moved) noexcept {
  const double work = glm::dot(last_force_, moved);
  if (was_led_) {
    energy_.growth += work;
    return;
  }
  const double active = last_active_ == dvec3(0) ? 0 : glm::dot(last_active_, moved);
  energy_.active += active;
  energy_.contact += active == 0 ? work : work - active;
  if (last_normal_ != dvec3(0))
    energy_.friction +=
        work - active - glm::dot(last_force_ - last_active_, last_normal_) * glm::dot(moved, last_normal_);
}

void ServoCore::restart_at(const dvec3& free_point_volume) noexcept {
  state_.begin_at(free_point_volume);
  state_.around.has_placements = false;
  is_led_ = false;
  force_.reset();
  passivity_.reset();
}

void ServoCore::reset() noexcept {
  state_.forget();
  is_led_ = false;
  cap_ = force_limit_;
  force_.reset();
  guard_.reset();
  passivity_.reset();
  laws_.reset();
  popped_shape_ = -1;
}

DenormalsFlushed::DenormalsFlushed() noexcept : before_(_mm_getcsr()) {
  _mm_setcsr(before_ | 0x8040u);  // flush to zero, denormals are zero
}

DenormalsFlushed::~DenormalsFlushed() { _mm_setcsr((_mm_getcsr() & ~0x8040u) | (before_ & 0x8040u)); }

}  // namespace trephine::haptics
