// What a device can bear: how stiff a coupling or a surface may be.
#pragma once

#include "haptics/device/device.h"
#include "haptics/force/force.h"

namespace trephine::haptics {

/// A spring and a damper.
struct Coupling {
  double stiffness = 0;  ///< N/mm
  double damping = 0;    ///< N s/mm
};

/// The stiffest critically damped coupling of a mass (kg) that a device with `device_damping` (N s/mm)
/// renders passively at a rate: B = 2 sqrt(K m) and b >= K T / 2 + B (thesis on soft-tissue simulation, 3.22
/// and 3.23, after Colgate and Schenkel 1997).
Coupling critical_coupling(double mass, double device_damping, double rate_hz);

/// The stiffest surface of damping B that a device renders passively for any hand: K = 2 (b - B) / T (Colgate
/// and Schenkel 1997). 0 where B is the larger. N/mm.
double passive_stiffness(double device_damping, double surface_damping, double rate_hz);

/// Limits of force as the device has them; what it does not say stays.
ForceOptions within_limits(const ForceOptions& options, const DeviceCapabilities& device);
/// A material as stiff as the device can render.
Material within_limits(const Material& material, const DeviceCapabilities& device);

/// Moves a virtual tool of some mass after the hand (virtual coupling, Colgate, Stanley and Brown 1995): the
/// tool feels what touches it, the hand feels the coupling. Plain data; semi-implicit Euler at the servo's
/// period.
class VirtualCoupling {
 public:
  VirtualCoupling(const Coupling& coupling, double mass, double dt) noexcept
      : coupling_(coupling), mass_(mass), dt_(dt) {}
  /// One tick: where the tool is after `force_on_tool` (N) and the coupling to the hand acted on it. The
  /// first call sets it on the hand.
  glm::dvec3 step(const glm::dvec3& hand_world, const glm::dvec3& force_on_tool) noexcept;
  /// N, on the hand.
  const glm::dvec3& force_on_hand() const noexcept { return force_; }
  const glm::dvec3& tool_world() const noexcept { return tool_; }
  void reset() noexcept { has_tool_ = false; }

 private:
  Coupling coupling_;
  double mass_, dt_;
  glm::dvec3 tool_{0.0}, velocity_{0.0}, hand_{0.0}, force_{0.0};
  bool has_tool_ = false;
};

}  // namespace trephine::haptics
