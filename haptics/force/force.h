// From a proxy to a force that a hand may feel: spring and damper, smoothing, and the last line before the
// device.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

struct ForceOptions {
  double smoothing_alpha =
      0.3;  ///< weight of the newest force at 1 kHz, (0, 1]; the same time constant at any rate
  double force_limit = 8;            ///< N
  double slew_limit = 1000;          ///< N/s
  double torque_limit = 150;         ///< N mm
  double torque_slew_limit = 20000;  ///< N mm/s
  double fade_seconds = 0.05;        ///< from full force to none after a fault
  /// Surfaces give a hand no more energy than they took (haptics/force/passivity.h). Off: nothing of it is
  /// run.
  bool is_passive = false;
  int delay_ticks = 0;        ///< of the device, for that
  double device_damping = 0;  ///< N s/mm, of the device: so much it takes itself, for that; 0 when not known
};

/// Reasons why the force was limited or taken away. Latched faults stay until reset().
enum FaultBit : std::uint32_t {
  fault_not_finite = 1,    ///< a pose or force was no number; latched
  fault_magnitude = 2,     ///< the force limit held
  fault_slew = 4,          ///< the slew limit held
  fault_stale_scene = 8,   ///< no new pose or scene within the watchdog's time; latched
  fault_lost_device = 16,  ///< the device stopped answering; latched
  fault_full_ring = 32,    ///< the servo's records are not read; latched
};
inline constexpr std::uint32_t k_latched_faults =
    fault_not_finite | fault_stale_scene | fault_lost_device | fault_full_ring;

/// The latched faults in words, for events and people: "full ring, lost device".
std::string fault_names(std::uint32_t faults);

/// Spring and damper between HIP and proxy: F = K (proxy - HIP) + B d/dt (proxy - HIP), less the material's
/// viscosity times the motion along the surface, seen from what is touched, then exponential
/// smoothing f_n = a x_n + (1 - a) f_(n-1) (thesis "A Surface-based Volume Haptics Approach", eq. 4.1).
class ForceModel {
 public:
  /// `dt` (s) is the servo's period; alpha is converted to it here, once.
  ForceModel(const ForceOptions& options, double dt);
  /// Servo thread.
  glm::dvec3 step(const ProxyStep& proxy, const glm::dvec3& hip_world, const TouchScene& scene) noexcept;
  /// The torque of a tool of several balls, N mm; after step().
  glm::dvec3 turn(const ProxyStep& proxy, const TouchScene& scene) noexcept;
  /// Another tool: what the last one was turned by is nothing to it.
  void forget_turn() noexcept {
    smoothed_turn_ = glm::dvec3(0);
    had_turn_ = false;
  }
  /// Starts the next stretch without damping against the last one; the smoothed force goes on.
  void let_go() noexcept { had_contact_ = had_turn_ = false; }
  /// As if never touched: the force starts from zero.
  void reset() noexcept;
  double alpha() const noexcept { return alpha_; }
  /// Complete state, field by field, for saving.
  template <class Fields>
  void each_field(Fields& fields) {
    fields(smoothed_, stretch_, hip_, had_contact_, smoothed_turn_, turn_, had_turn_);
  }

 private:
  double alpha_, dt_;
  glm::dvec3 smoothed_{0.0}, stretch_{0.0}, hip_{0.0};
  glm::dvec3 smoothed_turn_{0.0}, turn_{0.0};
  bool had_contact_ = false, had_turn_ = false;
};

/// The last line: whatever comes in, what goes out is finite, below the limit, slow enough, and faded out
/// after a latched fault. Present in every build.
class ForceGuard {
 public:
  ForceGuard(const ForceOptions& options, double dt) : options_(options), dt_(dt) {}
  /// Servo thread. `faults` are raised by others this tick.
  glm::dvec3 step(const glm::dvec3& wanted, std::uint32_t faults) noexcept;
  /// The torque of the same tick, N mm; after step(), which knows of its faults. Need not be called while
  /// none is wanted and none was rendered.
  glm::dvec3 turn(const glm::dvec3& wanted) noexcept;
  double torque_limit() const noexcept { return options_.torque_limit; }
  bool is_turning() const noexcept { return last_torque_ != glm::dvec3(0); }
  void reset() noexcept;
  const glm::dvec3& last() const noexcept { return last_; }  ///< what went out
  double fade() const noexcept { return fade_; }             ///< 1 to 0 after a latched fault
  const glm::dvec3& last_torque() const noexcept { return last_torque_; }
  /// After a latched fault: nothing is left of the force, and further steps change nothing.
  bool is_faded() const noexcept {
    return last_ == glm::dvec3(0) && last_torque_ == glm::dvec3(0) &&
           ((latched_ & fault_not_finite) != 0 || (latched_ != 0 && fade_ == 0));
  }
  std::uint32_t faults() const noexcept { return latched_ | momentary_; }
  /// Complete state, field by field, for saving.
  template <class Fields>
  void each_field(Fields& fields) {
    fields(last_, last_torque_, fade_, latched_, momentary_);
  }

 private:
  glm::dvec3 held_back(glm::dvec3 wanted, const glm::dvec3& last, double limit, double slew) noexcept;

  ForceOptions options_;
  double dt_;
  glm::dvec3 last_{0.0}, last_torque_{0.0};
  double fade_ = 1;
  std::uint32_t latched_ = 0, momentary_ = 0;
};

}  // namespace trephine::haptics
