#include "haptics/force/coupling.h"

#include <algorithm>
#include <cmath>

namespace trephine::haptics {

Coupling critical_coupling(double mass, double device_damping, double rate_hz) {
  // b = K T / 2 + 2 sqrt(K m / 1000) is quadratic in sqrt(K): lengths are mm.
  const double a = 0.5 / rate_hz, half_root = std::sqrt(mass / k_mm_s2_per_n_kg);
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

}  // namespace trephine::haptics
