// ForceModel, ForceGuard: force from proxy and HIP by spring and damper, smoothing, and the final limits
// before the device.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>

#include "haptics/device/wrench.h"
#include "haptics/force/faults.h"
#include "haptics/proxy/proxy_step.h"

namespace trephine::haptics {

struct ForceOptions {
  /// Weight of the newest force at 1 kHz, above 0, at most 1. Other rates keep the time constant.
  double smoothing_alpha = 0.3;
  double force_limit = 8;            ///< N
  double slew_limit = 1000;          ///< N/s
  double torque_limit = 150;         ///< N mm
  double torque_slew_limit = 20000;  ///< N mm/s
  double fade_seconds = 0.05;        ///< s, from full force to zero after a fault
  /// True: a controller limits the force so that surfaces return no more energy than they stored
  /// (haptics/force/passivity.h).
  bool is_passive = false;
  int delay_ticks = 0;        ///< delay of the device, for the passivity controller
  double device_damping = 0;  ///< of the device itself, N s/mm, for the passivity controller; 0: unknown
};

/// Returns the stiffness (N/mm) of a contact; for a tool with six degrees of freedom the mean over its
/// contacts, weighted by their push.
double contact_stiffness(const ProxyStep& proxy, const TouchScene& scene) noexcept;

/// Spring and damper between HIP and proxy: F = K (proxy - HIP) + B d/dt (proxy - HIP), minus the material's
/// viscosity times the tangential motion relative to the touched object, then exponential smoothing
/// f_n = a x_n + (1 - a) f_(n-1) (Jiang, dissertation, eq. 4.1).
class ForceModel {
 public:
  /// `dt`: period of the servo, s; smoothing_alpha is converted to it.
  ForceModel(const ForceOptions& options, double dt);
  /// Returns the force, and the torque of a tool with six degrees of freedom. Servo thread.
  Wrench step(const ProxyStep& proxy, const glm::dvec3& hip_world, const TouchScene& scene) noexcept;
  /// Clears the state of the torque, for a change of the tool.
  void reset_torque() noexcept {
    smoothed_turn_ = glm::dvec3(0);
    had_turn_ = false;
  }
  /// Forgets the last stretch of the spring, so that its next change is not damped; the smoothed force
  /// continues.
  void forget_stretch() noexcept { had_contact_ = had_turn_ = false; }
  /// Clears all state: the force starts from zero.
  void reset() noexcept;
  double alpha() const noexcept { return alpha_; }  ///< converted to the period
  /// Returns the result of the last step.
  Wrench smoothed() const noexcept { return {smoothed_, smoothed_turn_}; }
  /// Visits the complete state, field by field, for saving.
  template <class Fields>
  void each_field(Fields& fields) {
    fields(smoothed_, stretch_, hip_, had_contact_, smoothed_turn_, turn_, had_turn_);
  }

 private:
  glm::dvec3 force(const ProxyStep& proxy, const glm::dvec3& hip_world, const TouchScene& scene) noexcept;
  glm::dvec3 torque(const ProxyStep& proxy, const TouchScene& scene) noexcept;

  double alpha_, dt_;
  glm::dvec3 smoothed_{0.0}, stretch_{0.0}, hip_{0.0};
  glm::dvec3 smoothed_turn_{0.0}, turn_{0.0};
  bool had_contact_ = false, had_turn_ = false;
};

/// Final limits before the device: for any input the output is finite and within the
/// magnitude limit. Its change is within the slew limit, except at an end: a latched fault fades it out
/// within the fade time, and a value that is not finite sets it to zero at once. Present in every build.
class ForceGuard {
 public:
  ForceGuard(const ForceOptions& options, double dt) : options_(options), dt_(dt) {}
  /// Returns the limited wrench. `faults`: those raised outside the guard in this tick. Servo thread.
  Wrench step(const Wrench& requested, std::uint32_t faults) noexcept;
  double torque_limit() const noexcept { return options_.torque_limit; }
  void reset() noexcept;
  const Wrench& last() const noexcept { return last_; }  ///< last output
  double fade() const noexcept { return fade_; }         ///< factor, 1 to 0 after a latched fault
  /// True after a latched fault if the wrench is zero and further steps change nothing.
  bool is_faded() const noexcept {
    return last_.is_zero() && ((latched_ & fault_not_finite) != 0 || (latched_ != 0 && fade_ == 0));
  }
  std::uint32_t faults() const noexcept { return latched_ | momentary_; }
  /// Visits the complete state, field by field, for saving.
  template <class Fields>
  void each_field(Fields& fields) {
    fields(last_.force_world, last_.torque_world, fade_, latched_, momentary_);
  }

 private:
  glm::dvec3 limited_force(const glm::dvec3& requested, std::uint32_t faults) noexcept;
  glm::dvec3 limited_torque(const glm::dvec3& requested) noexcept;
  glm::dvec3 apply_limits(glm::dvec3 requested, const glm::dvec3& last, double limit, double slew) noexcept;

  ForceOptions options_;
  double dt_;
  Wrench last_;
  double fade_ = 1;
  std::uint32_t latched_ = 0, momentary_ = 0;
};

}  // namespace trephine::haptics
