// PassivityController: passivity observer and controller in the time domain (after Hannaford and Ryu 2002,
// and the energy bounding of Kim and Ryu 2010). A rendered surface may store and return energy, never create
// it.
#pragma once

#include <array>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "haptics/device/wrench.h"

namespace trephine::haptics {

/// Observes the work that the wrench does on the hand: the sum of F_k . (x_{k+1} - x_k), plus torque times
/// rotation with six degrees of freedom. Bounds the energy that the wrench returns: if the hand moves along
/// the wrench, the component of the wrench along the motion is limited to return at most the stored energy.
/// Energy dissipated by a yielding proxy (friction, bone that gives way: -F_k . (p_{k+1} - p_k) if that is
/// above 0) is not stored and may not be returned. No damping is added, so coarse encoders cause no
/// oscillation. A step in which the hand accelerates may return too much, at most that step's energy; the
/// excess counts as a debt. With delayed forces, a force that returned too much is softened, and stiffened
/// again out of contact. Plain data. Servo thread: no allocation, no waiting.
class PassivityController {
 public:
  static constexpr int k_max_delay = 4;
  /// `allowance`: N mm that may be returned beyond the stored energy. `delay_ticks`: whole ticks from this
  /// call to the hold that renders its force, 0 (the next one) to k_max_delay; forces under way count as
  /// rendered. `device_damping_over_dt`: the device's own damping divided by the period, N/mm; the energy
  /// that it takes from the motion of the hand may be returned. 0 if unknown.
  explicit PassivityController(double allowance = 0, int delay_ticks = 0,
                               double device_damping_over_dt = 0) noexcept;

  /// Returns the wrench to render instead of `requested` at position x (mm), with the proxy at p. Call once
  /// per tick, with measured positions; without contact p is x. `hand`, `tool`: rotations of hand and proxy,
  /// unit quaternions; used only with six degrees of freedom.
  Wrench step(const Wrench& requested, const glm::dvec3& x, const glm::dvec3& p,
              const glm::dquat& hand = {1, 0, 0, 0}, const glm::dquat& tool = {1, 0, 0, 0}) noexcept;
  /// Sets the wrench that was rendered last, if it was limited or delayed further after step().
  void set_rendered(const Wrench& wrench) noexcept { under_way_[static_cast<std::size_t>(delay_)] = wrench; }
  /// Handles lost ticks, in which the motion of the hand is unknown: the debt stays, the store is discarded.
  void on_lost_ticks() noexcept;
  /// Returns the work done on the hand plus the energy dissipated by a yielding proxy, minus that taken by
  /// the device's damping, N mm; positive: created energy.
  double energy() const noexcept { return energy_; }
  /// Returns the factor of the requested forces before they are limited; below 1 only with delayed forces.
  double force_scale() const noexcept { return force_scale_; }
  /// Returns the number of ticks in which the force was limited.
  long limited_ticks() const noexcept { return limited_ticks_; }
  /// Clears the energy balance, for a proxy that starts again.
  void reset() noexcept;
  /// Visits the state field by field, for saving.
  template <class Fields>
  void each_field(Fields& fields) {
    for (Wrench& wrench : under_way_) fields(wrench.force_world, wrench.torque_world);
    fields(last_x_, last_p_, move_, last_hand_, last_tool_, turn_, energy_, force_scale_, largest_,
           limited_ticks_, has_last_);
  }

 private:
  double allowance_, damping_;
  int delay_;
  /// mm2: when a wrench is limited, a rotation counts as the motion of a point 20 mm from the hand.
  static constexpr double k_arm_square = 400;

  std::array<Wrench, k_max_delay + 1> under_way_;     ///< oldest first; [0] was held since the last call
  glm::dvec3 last_x_{0.0}, last_p_{0.0}, move_{0.0};  ///< move_: of the newest tick with motion
  glm::dquat last_hand_{1, 0, 0, 0}, last_tool_{1, 0, 0, 0};
  glm::dvec3 turn_{0.0};                               ///< rotation that belongs to move_, rad
  double energy_ = 0, force_scale_ = 1, largest_ = 0;  ///< largest_: energy of the largest recent step
  long limited_ticks_ = 0;
  bool has_last_ = false;
};

}  // namespace trephine::haptics
