#include "haptics/force/coupling.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace trephine::haptics {

using glm::dvec3;

namespace {
constexpr double k_mm_per_newton = 1000;  // 1 N accelerates 1 kg by 1000 mm/s2
}

Coupling critical_coupling(double mass, double device_damping, double rate_hz) {
  // b = K T / 2 + 2 sqrt(K m / 1000) is quadratic in sqrt(K): lengths are mm.
  const double a = 0.5 / rate_hz, half_root = std::sqrt(mass / k_mm_per_newton);
  const double root = (-half_root + std::sqrt(half_root * half_root + a * std::max(0.0, device_damping))) / a;
  return {root * root, 2 * half_root * root};
}

double passive_stiffness(double device_damping, double surface_damping, double rate_hz) {
  return std::max(0.0, 2 * (device_damping - surface_damping) * rate_hz);
}

ForceOptions within_limits(const ForceOptions& options, const DeviceCapabilities& device) {
  ForceOptions limited = options;
  if (device.max_force > 0) limited.force_limit = std::min(options.force_limit, device.max_force);
  if (device.max_torque > 0) limited.torque_limit = std::min(options.torque_limit, device.max_torque);
  if (device.max_slew > 0) limited.slew_limit = std::min(options.slew_limit, device.max_slew);
  if (device.damping > 0) limited.device_damping = device.damping;
  return limited;
}

Material within_limits(const Material& material, const DeviceCapabilities& device) {
  Material limited = material;
  if (device.max_stiffness > 0) limited.stiffness = std::min(material.stiffness, device.max_stiffness);
  return limited;
}

const dvec3& VirtualCoupling::step(const dvec3& hand, const Wrench& on_tool,
                                   const glm::dquat& hand_orientation) noexcept {
  if (!has_tool_) {
    tool_ = hand_ = hand;
    tool_turn_ = hand_turn_ = hand_orientation;
    velocity_ = spin_ = dvec3(0);
    on_hand_ = {};
    has_tool_ = true;
    return tool_;
  }
  const dvec3 hand_velocity = (hand - hand_) / dt_;
  hand_ = hand;
  // Implicit in the coupling, so that a light tool does not oscillate: one step of
  // m dv/dt = K (hand - tool) + B (hand's velocity - v) + f.
  const double step = k_mm_per_newton * dt_ / mass_;
  const dvec3 pull =
      coupling_.stiffness * (hand - tool_) + coupling_.damping * hand_velocity + on_tool.force_world;
  velocity_ = (velocity_ + step * pull) / (1 + step * (coupling_.damping + coupling_.stiffness * dt_));
  tool_ += dt_ * velocity_;
  on_hand_.force_world =
      coupling_.stiffness * (tool_ - hand) + coupling_.damping * (velocity_ - hand_velocity);
  if (turning_.inertia > 0) turn(hand_orientation, on_tool.torque_world);
  return tool_;
}

/// Integrates the rotation: I dw/dt = K (turn to the hand) + B (hand's spin - w) + torque.
void VirtualCoupling::turn(const glm::dquat& hand, const dvec3& torque_on_tool) noexcept {
  const dvec3 hand_spin = turn_between(hand_turn_, hand) / dt_;
  hand_turn_ = hand;
  const double step = k_mm_per_newton * dt_ / turning_.inertia;
  const dvec3 pull =
      turning_.stiffness * turn_between(tool_turn_, hand) + turning_.damping * hand_spin + torque_on_tool;
  spin_ = (spin_ + step * pull) / (1 + step * (turning_.damping + turning_.stiffness * dt_));
  tool_turn_ = glm::normalize(glm::dquat(1, 0.5 * dt_ * spin_) * tool_turn_);
  on_hand_.torque_world =
      turning_.stiffness * turn_between(hand, tool_turn_) + turning_.damping * (spin_ - hand_spin);
}

}  // namespace trephine::haptics
