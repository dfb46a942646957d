#include "haptics/servo_core.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <xmmintrin.h>

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

/// Where voxels can still be counted, however small they are.
bool is_in_reach(const volume::Frame& frame, const dvec3& p) noexcept {
  const dvec3 v = frame.volume_from_world(p);
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(v[a]) < 0.25 * volume::k_traversal_limit)) return false;
  return true;
}

dvec3 clamped(const dvec3& v, double most) noexcept {
  const double size = glm::length(v);
  return size > most ? v * (most / size) : v;
}

}  // namespace

ServoCore::ServoCore(const TouchScene& scene, const ProxyMethod& method, const ForceOptions& options,
                     double dt, std::uint64_t first_tick)
    : scene_(&scene),
      method_(&method),
      force_(options, dt),
      guard_(options, dt),
      dt_(dt),
      force_limit_(options.force_limit),
      tick_(first_tick),
      cap_(options.force_limit) {}

ServoRecord ServoCore::step(const volume::Version& version, const ServoInput& input) noexcept {
  if (input.is_reset) reset();
  if (input.is_restarted) restart_at(input.restart_volume);
  ServoRecord record;
  record.tick = tick_++;
  record.t = static_cast<double>(record.tick) * dt_;
  record.version = version.serial();
  record.pose = input.pose;
  record.hand = hand_;
  record.is_reset = input.is_reset;
  record.is_restarted = input.is_restarted;
  record.restart_volume = input.restart_volume;
  std::uint32_t faults = input.faults;
  wanted_ = dvec3(0);
  const dvec3& hip = input.pose.position_world;
  if (is_place(hip) && is_in_reach(scene_->base->frame, hip) && (faults & fault_not_finite) == 0) {
    const bool has_grown = has_pending_ && version.serial() >= pending_.version;
    if (has_grown) {
      way_ = pending_;
      has_pending_ = false;
      if (is_led_) begin_lead(hip);
    }
    if (!is_led_) {
      step_ = method_->step(*scene_, version, state_, {hip});
      if (step_.has_contact) touched_ = step_.shape;
      if (step_.is_buried && has_grown) begin_lead(hip);
    }
    if (is_led_) lead(hip);
    cap_ = is_led_ ? k_lead_force : std::min(force_limit_, cap_ + k_lead_recovery * dt_);
    wanted_ = clamped(force_.step(step_, hip, *scene_), cap_);
    record.proxy_world = step_.proxy_world;
    record.normal_world = step_.normal_world;
    record.has_contact = step_.has_contact;
    record.is_buried = step_.is_buried;
    record.is_led = is_led_;
    record.shape = step_.shape;
    record.side = step_.side;
  } else {
    record.pose.position_world = dvec3(0);
    faults |= fault_not_finite;
  }
  record.raised = faults;
  record.force_world = guard_.step(wanted_, faults);
  record.faults = guard_.faults();
  // Without a force there is no hand on the tool, and a tool on its way out rests: nothing is cut.
  if ((record.faults & k_latched_faults) || is_led_) record.pose.is_pressed = false;
  account(record);
  record.energy = energy_;
  if (is_led_ && next_place_ == way_.count) {
    is_led_ = false;  // arrived: from here on the method holds it
    state_.begin_at(anchor_volume_);
  }
  return record;
}

dvec3 ServoCore::skip(std::uint32_t faults, std::uint64_t count) noexcept {
  had_position_ = false;
  tick_ += count;
  for (; count > 0; --count) {
    last_force_ = guard_.step(wanted_, faults);
    if (guard_.is_faded()) break;
  }
  return last_force_;
}

void ServoCore::offer(const WayOut& way) noexcept {
  pending_ = way;
  has_pending_ = way.count > 0;
}

void ServoCore::begin_lead(const dvec3& hip_world) noexcept {
  const volume::Frame& frame = scene_->base->frame;
  const dvec3 out = frame.world_from_volume(way_.places_volume[way_.count - 1]);
  if (!is_led_) {
    // The spring starts unstretched at the hand, wherever that is.
    anchor_volume_ = frame.volume_from_world(hip_world);
    force_.let_go();
    const double reach = glm::length(out - hip_world);
    energy_.discarded += 0.5 * material_of(*scene_, touched_, 1).stiffness * reach * reach;
  }
  next_place_ = 0;
  is_led_ = true;
}

void ServoCore::lead(const dvec3& hip_world) noexcept {
  const volume::Frame& frame = scene_->base->frame;
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
  step_.side = 1;
  step_.waypoint_count = 0;
}

void ServoCore::account(const ServoRecord& record) noexcept {
  const dvec3& position = record.pose.position_world;
  const bool has_position = (record.raised & fault_not_finite) == 0;
  if (had_position_ && has_position)
    (was_led_ ? energy_.growth : energy_.contact) += glm::dot(last_force_, position - last_position_);
  had_position_ = has_position;
  was_led_ = record.is_led;
  last_force_ = record.force_world;
  last_position_ = position;
}

void ServoCore::restart_at(const dvec3& free_point_volume) noexcept {
  state_.begin_at(free_point_volume);
  is_led_ = false;
  force_.reset();
}

void ServoCore::reset() noexcept {
  state_.forget();
  is_led_ = false;
  cap_ = force_limit_;
  force_.reset();
  guard_.reset();
}

DenormalsFlushed::DenormalsFlushed() noexcept : before_(_mm_getcsr()) {
  _mm_setcsr(before_ | 0x8040u);  // flush to zero, denormals are zero
}

DenormalsFlushed::~DenormalsFlushed() { _mm_setcsr((_mm_getcsr() & ~0x8040u) | (before_ & 0x8040u)); }

}  // namespace trephine::haptics
