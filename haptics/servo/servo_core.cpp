// ServoCore: one tick of a hand. It is one file, because all parts of a tick share the state of the core.
#include "haptics/servo/servo_core.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <xmmintrin.h>

#include "haptics/force/limited.h"
#include "haptics/servo/readiness.h"
#include "volume/scan/traversal.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_farthest_mm = 1e6;  // mm; a pose beyond this comes from a broken device

bool is_valid_position(const dvec3& p) noexcept {
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(p[a]) <= k_farthest_mm)) return false;
  return true;
}

/// Returns true if orientation and axes are finite and within range.
bool is_finite(const Pose& pose) noexcept {
  const glm::dquat& q = pose.orientation;
  bool is_good = std::abs(q.w) + std::abs(q.x) + std::abs(q.y) + std::abs(q.z) <= k_farthest_mm;
  for (const float axis : pose.axes) is_good = is_good && std::abs(axis) <= Pose::k_farthest_axis;
  return is_good;
}

/// Returns true if the voxel index at p is within the range of the voxel traversal.
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
      force_cap_(options.force_limit),
      passivity_(0, options.delay_ticks, options.device_damping / dt),
      is_passive_(options.is_passive) {}

namespace {
void add_event(ServoRecord& record, TouchEvent::Kind kind, int shape) noexcept {
  if (record.event_count < ServoRecord::k_max_events)
    record.events[record.event_count++] = {kind, static_cast<std::int16_t>(shape)};
}
}  // namespace

void ServoCore::update_passable_items(const ServoHand& hand) noexcept {
  ShapeSet& passable = state_.around.passable;
  passable = hand.untouchable | hand.passable_items | not_ready_;
  if (popped_shape_ >= 0) passable.set(popped_shape_, true);
}

/// Adopts another scene or method: cached surroundings are outdated, and items may have been removed.
void ServoCore::adopt(const ServoHand& hand) noexcept {
  const int count = item_count(*hand.scene);
  for (int s = 0; s < count; ++s)
    if (const TouchItem& item = item_of(*hand.scene, s); item.is_mesh() && item.first_layout > layout_)
      state_.around.new_models.set(s, true);
  for (ShapeSet* items : {&state_.around.new_models, &state_.around.passable, &not_ready_})
    for (int s = items->next(count); s < ShapeSet::k_max; s = items->next(s + 1)) items->set(s, false);
  if (step_.shape >= count) step_.shape = -1;
  layout_ = hand.layout;
  popped_shape_ = last_shape_ = -1;
  if (touched_item_ >= count) touched_item_ = 0;
  if (hand.method->info().is_six_dof() || state_.has_turn) {
    // The tool may be another one, in matter that did not contain the previous tool. The next step tests for
    // this, as after restored matter.
    state_.version = ~std::uint64_t{0};
    state_.has_turn = false;
    state_.balls_inside = 0;
    force_.reset_torque();
  }
  reported_not_ready_ = ShapeSet{};
  state_.touched_mover = -1;
  state_.around.nearby = ShapeSet{};
  state_.around.near_radius = 0;
  state_.around.has_placements = false;
  state_.plane = PlaneMemory{};
  state_.has_mesh_proxy = false;
}

/// Lets the tool through a surface pressed harder than its pop force, and rearms the surface when the tool
/// has moved away.
void ServoCore::pop_through(const ServoHand& hand, const dvec3& hip, ServoRecord& record) noexcept {
  const TouchScene& scene = *hand.scene;
  if (popped_shape_ >= 0) {
    const Material& material = material_of(scene, popped_shape_, popped_side_);
    if (glm::length(hip - popped_at_world_) < material.pop_rearm) return;
    add_event(record, TouchEvent::rearmed, std::exchange(popped_shape_, -1));
    return;
  }
  if (!step_.has_contact || is_escaping_) return;
  const Material& material = material_of(scene, step_.shape, step_.side);
  const double press = glm::dot(step_.proxy_world - hip, step_.normal_world) *
                       stiffness_at(scene, step_.shape, step_.side, step_.proxy_world, step_.normal_world);
  if (!(material.pop_force > 0) || press <= material.pop_force) return;
  popped_shape_ = step_.shape;
  popped_side_ = step_.side;
  popped_at_world_ = hip;
  add_event(record, TouchEvent::popped, popped_shape_);  // takes effect in the next tick
}

/// Adds events for changes since the previous tick to the record.
void ServoCore::emit_events(ServoRecord& record) noexcept {
  const int shape = record.has_contact ? record.shape : -1;
  if (shape != last_shape_) {
    if (last_shape_ >= 0) add_event(record, TouchEvent::untouched, last_shape_);
    if (shape >= 0) add_event(record, TouchEvent::touched, shape);
    last_shape_ = shape;
  }
  if (not_ready_ == reported_not_ready_) return;
  for (int s = 0; s < ShapeSet::k_max; ++s) {
    if (not_ready_.contains(s) == reported_not_ready_.contains(s)) continue;
    add_event(record, not_ready_.contains(s) ? TouchEvent::not_ready : TouchEvent::ready, s);
  }
  reported_not_ready_ = not_ready_;
}

ServoRecord ServoCore::step(const ServoScene& servo_scene, const ServoInput& input) noexcept {
  if (hand_ >= servo_scene.hands.size()) return step_without_hand(servo_scene, input);
  const ServoHand& hand = servo_scene.hands[hand_];
  const TouchScene& scene = *hand.scene;
  if (hand.layout != layout_) adopt(hand);
  if (input.is_reset) reset();
  if (input.is_restarted) {
    // Invalid positions can only come from a file.
    const dvec3 position = scene.base->frame.world_from_volume(input.restart_volume);
    if (is_valid_position(position) && is_in_reach(scene, position)) restart_at(input.restart_volume);
  }
  ServoRecord record;
  record.tick = tick_++;
  record.t = static_cast<double>(record.tick) * dt_;
  record.version = servo_scene.serial;
  record.pose = input.pose;
  record.hand = static_cast<std::uint8_t>(hand_);
  record.is_reset = input.is_reset;
  record.is_restarted = input.is_restarted;
  record.restart_volume = input.restart_volume;
  std::uint32_t faults = input.faults;
  requested_ = Wrench();
  const dvec3& hip = input.pose.position_world;
  if (is_valid_position(hip) && is_finite(input.pose) && is_in_reach(scene, hip) &&
      (faults & fault_not_finite) == 0) {
    // Matter restored before the first tick cannot bury the proxy, because no proxy exists yet.
    if (is_fresh_ && hand.escape_path) escape_path_.serial = hand.escape_path->serial;
    is_fresh_ = false;
    const bool has_restored_matter = hand.escape_path && hand.escape_path->serial > escape_path_.serial;
    if (has_restored_matter) {
      escape_path_ = *hand.escape_path;
      if (is_escaping_ && escape_path_.count > 0)
        begin_escape(hand, hip);
      else if (is_escaping_)
        release_proxy();
    }
    const dvec3 proxy = state_.has_proxy ? scene.base->frame.world_from_volume(state_.proxy_volume) : hip;
    const Readiness readiness =
        readiness_of(hand, {hip, proxy, time(), step_.has_contact ? step_.shape : -1});
    not_ready_ = readiness.not_ready;
    if (readiness.fade) force_cap_ = std::min(force_cap_, *readiness.fade * force_limit_);
    update_passable_items(hand);
    if (!is_escaping_) {
      step_ = hand.held_count > 0
                  ? step_with_held(hand, input)
                  : hand.method->step(scene, hand.state, state_,
                                      {hip, std::span(hand.placements.data(), hand.placement_count),
                                       input.pose.orientation, time()});
      if (step_.has_contact) touched_item_ = step_.shape;
      if (step_.is_buried && has_restored_matter && escape_path_.count > 0) begin_escape(hand, hip);
    }
    if (is_escaping_) escape(hand, hip);
    force_cap_ = is_escaping_ ? k_escape_force : std::min(force_limit_, force_cap_ + k_escape_recovery * dt_);
    const bool is_six_dof = hand.method->info().is_six_dof();
    requested_ = force_.step(step_, hip, scene);
    requested_.force_world = limited(requested_.force_world, force_cap_);
    if (is_six_dof && force_cap_ < force_limit_) requested_.torque_world *= force_cap_ / force_limit_;
    record.contact_force_world = requested_.force_world;
    active_force_ = dvec3(0);
    std::optional<dvec3> held_tip;
    if (hand.laws) {
      // The record below keeps its buttons only under this condition. A replay reads the buttons from the
      // record, so that effects get the same input as in the live tick.
      const bool is_working =
          input.pose.is_pressed() && !is_escaping_ && ((guard_.faults() | faults) & k_latched_faults) == 0;
      const LawForces forces =
          laws_.step(*hand.laws,
                     {scene, hand.state.version.get(), step_, requested_.force_world, requested_.torque_world,
                      hip, input.pose.orientation, dvec3(0), dvec3(0), dt_, is_working});
      requested_.force_world += forces.passive_world;
      requested_.torque_world += forces.torque_world;
      active_force_ = forces.active_world;
      if (forces.has_lost_resistance) add_event(record, TouchEvent::lost_resistance, forces.exited_shape);
      if (forces.has_met_resistance) add_event(record, TouchEvent::met_resistance, forces.entered_shape);
      if (forces.has_tip) held_tip = forces.tip_world;
    } else if (!laws_.is_empty()) {
      laws_.reset();
    }
    if (requested_.torque_world != dvec3(0)) is_turning_ = true;
    if (is_passive_) limit_energy(hip, input.pose.orientation, is_six_dof);
    requested_.force_world += active_force_;
    if (hand.has_pops) pop_through(hand, hip, record);
    record.proxy_world = held_tip.value_or(step_.proxy_world);
    record.turn_world = step_.turn_world;
    record.normal_world = step_.normal_world;
    record.has_contact = step_.has_contact;
    record.is_buried = step_.is_buried;
    record.is_escaping = is_escaping_;
    record.shape = step_.shape;
    record.side = step_.side;
  } else {
    record.pose = Pose{dvec3(0), {1, 0, 0, 0}, input.pose.buttons};
    faults |= fault_not_finite;
  }
  record.raised = faults;
  const Wrench rendered = guard_.step(requested_, faults);
  record.force_world = rendered.force_world;
  record.torque_world = rendered.torque_world;
  record.faults = guard_.faults();
  if (is_passive_) {
    passivity_.set_rendered(passive_part(rendered));
    if (faults & fault_not_finite) passivity_.on_lost_ticks();
  }
  // A tool cuts nothing while a fault is latched or its proxy follows an escape path.
  if ((record.faults & k_latched_faults) || is_escaping_) record.pose.buttons = 0, record.pose.axes = {};
  emit_events(record);
  account(record);
  record.energy = energy_;
  if (servo_scene.has_held || has_recent_poses_) remember_pose(servo_scene, record);
  if (is_escaping_ && next_position_ == escape_path_.count) {
    is_escaping_ = false;  // the proxy is at the end of the path: the method controls it in later ticks
    state_.begin_at(anchor_volume_);
    state_.around.has_placements = false;  // meshes that moved during the escape must not push the proxy
  }
  return record;
}

/// Limits the energy that the passive part of the requested wrench returns to the hand.
void ServoCore::limit_energy(const dvec3& hip, const glm::dquat& orientation, bool is_six_dof) noexcept {
  const dvec3 proxy = step_.has_contact ? step_.proxy_world : hip;
  if (!is_six_dof) {
    requested_.force_world = passivity_.step(requested_.force_world, hip, proxy).force_world;
    return;
  }
  const glm::dquat hand = unit_of(orientation);
  requested_ = passivity_.step(requested_, hip, proxy, hand,
                               step_.has_contact && state_.has_turn ? state_.tool_turn : hand);
}

/// Runs the method with held meshes moved by the placements of the hands in the previous tick.
ProxyStep ServoCore::step_with_held(const ServoHand& hand, const ServoInput& input) noexcept {
  std::array<Placement, TouchScene::k_max_movers> placements = hand.placements;
  for (std::size_t i = 0; i < hand.held_count; ++i) {
    const ServoHand::Held& held = hand.held[i];
    if (input.hand_placements && (*input.hand_placements)[held.hand])
      placements[static_cast<std::size_t>(held.mover)] = *(*input.hand_placements)[held.hand] * held.grip;
  }
  return hand.method->step(*hand.scene, hand.state, state_,
                           {input.pose.position_world, std::span(placements.data(), hand.placement_count),
                            input.pose.orientation, time()});
}

/// Records the placement of the hand if its pose is valid; clears the placements if no mesh is held.
void ServoCore::remember_pose(const ServoScene& servo_scene, const ServoRecord& record) noexcept {
  if (!servo_scene.has_held) {
    recent_poses_ = {};
    has_recent_poses_ = false;
  } else if ((record.raised & fault_not_finite) == 0) {
    recent_poses_[1] = recent_poses_[0];
    recent_poses_[0] = {placement_of(record.pose), record.tick, true};
    has_recent_poses_ = true;
  }
}

Placement placement_of(const Pose& pose) noexcept { return {pose.position_world, unit_of(pose.orientation)}; }

std::optional<Placement> ServoCore::pose_before(std::uint64_t tick) const noexcept {
  for (const RecentPose& recent : recent_poses_)
    if (recent.is_known && recent.tick < tick) return recent.pose;
  return std::nullopt;
}

/// Handles a scene without this hand: no contact.
ServoRecord ServoCore::step_without_hand(const ServoScene& servo_scene, const ServoInput& input) noexcept {
  ServoRecord record;
  record.tick = tick_;
  record.t = time();
  record.version = servo_scene.serial;
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

/// Estimates the part of a rendered wrench that does not come from active laws, assuming that the guard only
/// scaled the force. Active laws return no torque.
Wrench ServoCore::passive_part(const Wrench& rendered) const noexcept {
  const dvec3 &force = rendered.force_world, &requested = requested_.force_world;
  const double requested_square = glm::dot(requested, requested);
  if (active_force_ == dvec3(0) || !(requested_square > 0)) return rendered;
  return {force - active_force_ * std::min(1.0, std::sqrt(glm::dot(force, force) / requested_square)),
          rendered.torque_world};
}

Wrench ServoCore::skip(std::uint32_t faults, std::uint64_t count) noexcept {
  if (count == 0) return last_;
  had_position_ = false;
  if (is_passive_) passivity_.on_lost_ticks();
  tick_ += count;
  for (; count > 0; --count) {
    last_ = guard_.step(requested_, faults);
    if (guard_.is_faded()) break;
  }
  return last_;
}

/// Releases a proxy that follows an escape path, if a newer escape path has no positions: the proxy restarts
/// at the hand, without force.
void ServoCore::release_proxy() noexcept {
  is_escaping_ = false;
  state_.reset_except_surroundings();
  force_.reset();
}

void ServoCore::begin_escape(const ServoHand& hand, const dvec3& hip_world) noexcept {
  const volume::Frame& frame = hand.scene->base->frame;
  const dvec3 out = frame.world_from_volume(escape_path_.positions_volume[escape_path_.count - 1]);
  if (!is_escaping_) {
    // The proxy starts at the hand, without stretch of the spring, even if the end of the path is far away.
    anchor_volume_ = frame.volume_from_world(hip_world);
    force_.forget_stretch();
    const double reach = glm::length(out - hip_world);
    energy_.discarded += 0.5 * material_of(*hand.scene, touched_item_, Side::front).stiffness * reach * reach;
  }
  next_position_ = 0;
  is_escaping_ = true;
}

void ServoCore::escape(const ServoHand& hand, const dvec3& hip_world) noexcept {
  const volume::Frame& frame = hand.scene->base->frame;
  double remaining = k_escape_speed * dt_;
  while (next_position_ < escape_path_.count && remaining > 0) {
    const dvec3 leg = escape_path_.positions_volume[next_position_] - anchor_volume_;
    const double length = glm::length(frame.vector_world_from_volume(leg));
    if (length <= remaining) {
      anchor_volume_ = escape_path_.positions_volume[next_position_++];
      remaining -= length;
    } else {
      anchor_volume_ += (remaining / length) * leg;
      remaining = 0;
    }
  }
  step_.proxy_world = frame.world_from_volume(anchor_volume_);
  const dvec3 out = step_.proxy_world - hip_world;
  const double length = glm::length(out);
  step_.normal_world = length > 0 ? out / length : dvec3(0);
  step_.has_contact = true;
  step_.shape = touched_item_;
  step_.is_buried = false;
  step_.side = Side::front;
  step_.object_motion_world = step_.turn_world = dvec3(0);
  step_.waypoint_count = 0;
  step_.contacts.clear();
}

void ServoCore::account(const ServoRecord& record) noexcept {
  const dvec3& position = record.pose.position_world;
  const bool has_position = (record.raised & fault_not_finite) == 0;
  if (had_position_ && has_position) account_motion(position - last_position_);
  if (is_turning_) {  // ends when no torque is requested or rendered
    if (had_position_ && has_position)
      energy_.turning += glm::dot(last_.torque_world, turn_between(last_turn_, record.pose.orientation));
    last_turn_ = record.pose.orientation;
    is_turning_ = !(record.torque_world == dvec3(0) && requested_.torque_world == dvec3(0));
  }
  had_position_ = has_position;
  was_escaping_ = record.is_escaping;
  last_ = record.wrench();
  last_active_ = active_force_ == dvec3(0) ? dvec3(0) : last_.force_world - passive_part(last_).force_world;
  last_normal_ = record.normal_world;
  last_position_ = position;
}

void ServoCore::account_motion(const dvec3& motion) noexcept {
  const double work = glm::dot(last_.force_world, motion);
  if (was_escaping_) {
    energy_.growth += work;
    return;
  }
  const double active = last_active_ == dvec3(0) ? 0 : glm::dot(last_active_, motion);
  energy_.active += active;
  energy_.contact += active == 0 ? work : work - active;
  if (last_normal_ != dvec3(0))
    energy_.friction +=
        work - active -
        glm::dot(last_.force_world - last_active_, last_normal_) * glm::dot(motion, last_normal_);
}

void ServoCore::restart_at(const dvec3& free_point_volume) noexcept {
  state_.begin_at(free_point_volume);
  state_.around.has_placements = false;
  is_escaping_ = false;
  force_.reset();
  passivity_.reset();
}

void ServoCore::reset() noexcept {
  if (is_escaping_) state_.reset_except_surroundings();
  is_escaping_ = false;
  force_cap_ = 0;
  force_.reset();
  guard_.reset();
  passivity_.reset();
  laws_.reset();
  popped_shape_ = -1;
}

DenormalsFlushed::DenormalsFlushed() noexcept : saved_control_(_mm_getcsr()) {
  _mm_setcsr(saved_control_ | 0x8040u);  // flush to zero, denormals are zero
}

DenormalsFlushed::~DenormalsFlushed() { _mm_setcsr((_mm_getcsr() & ~0x8040u) | (saved_control_ & 0x8040u)); }

}  // namespace trephine::haptics
