// VirtualCoupling: spring and damper from the hand to a virtual tool, and stiffness limits of devices.
#pragma once

#include "haptics/device/device.h"
#include "haptics/force/force.h"

namespace trephine::haptics {

/// Spring and damper.
struct Coupling {
  double stiffness = 0;  ///< N/mm
  double damping = 0;    ///< N s/mm
};

/// Returns the stiffest critically damped coupling of a mass (kg) that a device with `device_damping` (N
/// s/mm) renders passively at a rate: B = 2 sqrt(K m) and b >= K T / 2 + B (after Colgate and Schenkel 1997).
Coupling critical_coupling(double mass, double device_damping, double rate_hz);

/// Returns the largest stiffness (N/mm) of a surface of damping B (N s/mm) that a device renders passively
/// for any hand: K = 2 (b - B) / T (Colgate and Schenkel 1997). 0 if B exceeds b.
double passive_stiffness(double device_damping, double surface_damping, double rate_hz);

/// Returns the options limited by the device's capabilities; unknown capabilities do not limit.
ForceOptions within_limits(const ForceOptions& options, const DeviceCapabilities& device);
/// Returns the material with its stiffness limited to what the device can render.
Material within_limits(const Material& material, const DeviceCapabilities& device);

/// Rotational coupling of a tool, about its own position and the same about every axis.
struct RotationalCoupling {
  double inertia = 0;    ///< kg mm2; 0: the tool does not rotate by itself, and no torque is computed
  double stiffness = 0;  ///< N mm/rad
  double damping = 0;    ///< N mm s/rad
};

/// Couples a virtual tool with mass to the hand (virtual coupling, Colgate, Stanley and Brown 1995): contact
/// acts on the tool, and the coupling is rendered to the hand. 3 degrees of freedom, or 6. Plain data;
/// semi-implicit Euler at the servo's period.
class VirtualCoupling {
 public:
  VirtualCoupling(const Coupling& coupling, double mass, double dt,
                  const RotationalCoupling& turning = {}) noexcept
      : coupling_(coupling), turning_(turning), mass_(mass), dt_(dt) {}
  /// Runs one tick. Returns the position of the tool (mm) after `on_tool` and the coupling to the hand acted
  /// on it. The first call places the tool at the hand.
  const glm::dvec3& step(const glm::dvec3& hand_world, const Wrench& on_tool,
                         const glm::dquat& hand_orientation = {1, 0, 0, 0}) noexcept;
  const Wrench& on_hand() const noexcept { return on_hand_; }
  const glm::dvec3& tool_world() const noexcept { return tool_; }
  const glm::dquat& tool_orientation() const noexcept { return tool_turn_; }
  void reset() noexcept { has_tool_ = false; }

 private:
  void turn(const glm::dquat& hand, const glm::dvec3& torque_on_tool) noexcept;

  Coupling coupling_;
  RotationalCoupling turning_;
  double mass_, dt_;
  glm::dvec3 tool_{0.0}, velocity_{0.0}, hand_{0.0}, spin_{0.0};  ///< spin_: rad/s
  glm::dquat tool_turn_{1, 0, 0, 0}, hand_turn_{1, 0, 0, 0};
  Wrench on_hand_;
  bool has_tool_ = false;
};

}  // namespace trephine::haptics
