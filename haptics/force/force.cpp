#include "haptics/force/force.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/deterministic_math.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {
bool is_finite(const dvec3& v) noexcept {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
}  // namespace

ForceModel::ForceModel(const ForceOptions& options, double dt) : alpha_(options.smoothing_alpha), dt_(dt) {
  // (1 - a)^(1000 dt): an old force decays over dt as it would at 1 kHz.
  const double ticks = 1000 * dt;
  if (alpha_ < 1 && ticks != 1) alpha_ = 1 - deterministic_exp(ticks * deterministic_log(1 - alpha_));
}

double contact_stiffness(const ProxyStep& proxy, const TouchScene& scene) noexcept {
  if (proxy.contacts.size() == 0)
    return stiffness_at(scene, proxy.shape, proxy.side, proxy.proxy_world, proxy.normal_world);
  double sum = 0, pushes = 0;
  for (std::size_t i = 0; i < proxy.contacts.size(); ++i) {
    const ToolContact& contact = proxy.contacts[i];
    const dvec3 middle = contact.point_world + scene.tool->radius() * contact.normal_world;
    sum += contact.push * stiffness_at(scene, contact.shape, contact.side, middle, contact.normal_world);
    pushes += contact.push;
  }
  return sum / pushes;
}

Wrench ForceModel::step(const ProxyStep& proxy, const dvec3& hip_world, const TouchScene& scene) noexcept {
  Wrench wrench(force(proxy, hip_world, scene));
  if (scene.tool->is_six_dof()) wrench.torque_world = torque(proxy, scene);
  return wrench;
}

dvec3 ForceModel::force(const ProxyStep& proxy, const dvec3& hip_world, const TouchScene& scene) noexcept {
  dvec3 force(0);
  if (proxy.has_contact) {
    const Material& material = material_of(scene, proxy.shape, proxy.side);
    const dvec3 stretch = proxy.proxy_world - hip_world;
    force = contact_stiffness(proxy, scene) * stretch;
    if (had_contact_) force += (material.damping / dt_) * (stretch - stretch_);
    if (had_contact_ && material.viscosity > 0) {
      const dvec3 moved = hip_world - hip_ - proxy.object_motion_world, &n = proxy.normal_world;
      force -= (material.viscosity / dt_) * (moved - glm::dot(moved, n) * n);
    }
    stretch_ = stretch;
    hip_ = hip_world;
  }
  had_contact_ = proxy.has_contact;
  if (proxy.is_buried) {
    reset();
    return dvec3(0);
  }
  smoothed_ = alpha_ * force + (1 - alpha_) * smoothed_;
  return smoothed_;
}

dvec3 ForceModel::torque(const ProxyStep& proxy, const TouchScene& scene) noexcept {
  dvec3 torque(0);
  if (proxy.has_contact) {
    const Material& material = material_of(scene, proxy.shape, proxy.side);
    const double square = scene.tool->gyration_square();
    torque = square * contact_stiffness(proxy, scene) * proxy.turn_world;
    if (had_turn_) torque += (square * material.damping / dt_) * (proxy.turn_world - turn_);
    turn_ = proxy.turn_world;
  }
  had_turn_ = proxy.has_contact;
  if (proxy.is_buried) return smoothed_turn_ = dvec3(0);
  smoothed_turn_ = alpha_ * torque + (1 - alpha_) * smoothed_turn_;
  return smoothed_turn_;
}

void ForceModel::reset() noexcept {
  smoothed_ = smoothed_turn_ = dvec3(0);
  had_contact_ = had_turn_ = false;
}

/// Returns `requested` limited in length to `limit` and in change from `last` to `slew`; sets the fault bits.
dvec3 ForceGuard::apply_limits(dvec3 requested, const dvec3& last, double limit, double slew) noexcept {
  if (const double size = glm::length(requested); size > limit) {
    requested *= limit / size;
    momentary_ |= fault_magnitude;
  }
  const dvec3 change = requested - last;
  if (const double size = glm::length(change); size > slew) {
    requested = last + change * (slew / size);
    momentary_ |= fault_slew;
  }
  if (latched_ != 0 && fade_ == 0) return dvec3(0);  // the fade ends on time, regardless of the slew limit
  return requested;
}

Wrench ForceGuard::step(const Wrench& requested, std::uint32_t faults) noexcept {
  const bool has_torque = requested.torque_world != dvec3(0) || last_.torque_world != dvec3(0);
  if (!is_finite(requested.torque_world)) faults |= fault_not_finite;  // neither value can be trusted
  last_.force_world = limited_force(requested.force_world, faults);
  last_.torque_world = has_torque ? limited_torque(requested.torque_world) : dvec3(0);
  return last_;
}

dvec3 ForceGuard::limited_force(const dvec3& requested, std::uint32_t faults) noexcept {
  momentary_ = 0;
  dvec3 force = requested;
  if (!is_finite(force)) {
    force = dvec3(0);
    faults |= fault_not_finite;
  }
  latched_ |= faults & k_latched_faults;
  if (latched_ & fault_not_finite) return dvec3(0);  // at once: no value can be trusted
  if (latched_ != 0) {
    fade_ = std::max(0.0, fade_ - dt_ / options_.fade_seconds);
    force *= fade_;
  }
  return apply_limits(force, last_.force_world, options_.force_limit, options_.slew_limit * dt_);
}

dvec3 ForceGuard::limited_torque(const dvec3& torque) noexcept {
  if (!is_finite(torque)) latched_ |= fault_not_finite;
  if (latched_ & fault_not_finite) return dvec3(0);
  // The fade is 1 while no fault is latched.
  return apply_limits(fade_ * torque, last_.torque_world, options_.torque_limit,
                      options_.torque_slew_limit * dt_);
}

void ForceGuard::reset() noexcept {
  last_ = Wrench();
  fade_ = 1;
  latched_ = momentary_ = 0;
}

}  // namespace trephine::haptics
