#include "haptics/force/coupling.h"

#include <algorithm>
#include <cmath>

namespace trephine::haptics {

using glm::dvec3;

namespace {
constexpr double k_mm_per_newton = 1000;  // 1 N accelerates 1 kg by 1000 mm/s2
}

Coupling critical_coupling(double mass, double device_damping, double rate_hz) {
  // b = K T / 2 + 2 sqrt(K m / 1000) is quadratic in sqrt(K): lengths are mm.
  const double a = 0.5 / rate_hz, half = std::sqrt(mass / k_mm_per_newton);
  const double root = (-half + std::sqrt(half * half + a * std::max(0.0, device_damping))) / a;
  return {root * root, 2 * half * root};
}

double passive_stiffness(double device_damping, double surface_damping, double rate_hz) {
  return std::max(0.0, 2 * (device_damping - surface_damping) * rate_hz);
}

ForceOptions within_limits(const ForceOptions& options, const DeviceCapabilities& device) {
  ForceOptions limited = options;
  if (device.max_force > 0) limited.force_limit = std::min(options.force_limit, device.max_force);
  if (device.max_slew > 0) limited.slew_limit = std::min(options.slew_limit, device.max_slew);
  if (device.damping > 0) limited.device_damping = device.damping;
  return limited;
}

Material within_limits(const Material& material, const DeviceCapabilities& device) {
  Material limited = material;
  if (device.max_stiffness > 0) limited.stiffness = std::min(material.stiffness, device.max_stiffness);
  return limited;
}

dvec3 VirtualCoupling::step(const dvec3& hand, const dvec3& force_on_tool) noexcept {
  if (!has_tool_) {
    tool_ = hand_ = hand;
    velocity_ = force_ = dvec3(0);
    has_tool_ = true;
    return tool_;
  }
  const dvec3 hand_velocity = (hand - hand_) / dt_;
  hand_ = hand;
  // Implicit in the coupling, so that a light tool does not ring: one step of
  // m dv/dt = K (hand - tool) + B (hand's velocity - v) + f.
  const double step = k_mm_per_newton * dt_ / mass_;
  const dvec3 pull = coupling_.stiffness * (hand - tool_) + coupling_.damping * hand_velocity + force_on_tool;
  velocity_ = (velocity_ + step * pull) / (1 + step * (coupling_.damping + coupling_.stiffness * dt_));
  tool_ += dt_ * velocity_;
  force_ = coupling_.stiffness * (tool_ - hand) + coupling_.damping * (velocity_ - hand_velocity);
  return tool_;
}

}  // namespace trephine::haptics
