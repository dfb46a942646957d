// Passivity observer and controller in the time domain (after Hannaford and Ryu 2002, and the bounding of
// energy of Kim and Ryu 2010): a rendered surface may take energy and give it back, never make it.
#pragma once

#include <array>
#include <glm/vec3.hpp>

namespace trephine::haptics {

/// Watches the work done on the hand, sum of F_k . (x_{k+1} - x_k), and lets the force give no more along the
/// motion than was taken before: on the way out its part along the motion is cut to what the store still
/// holds. What a proxy that yields takes for good (friction, bone that gives way: -F_k . (p_{k+1} - p_k)
/// where that is above 0) is no store: it is heat, and may not be given back. No damping is added, so nothing
/// rings on coarse encoders. What a step gives too much, because the hand goes faster than in the step
/// before, is at most that step's energy, and is a debt. Where forces are late, what gave too much is made
/// softer, and firm again out of contact. Plain data; servo thread: no allocation, no waiting.
class PassivityController {
 public:
  static constexpr int k_most_delay = 4;
  /// `allowance`: N mm that may be given beyond what was taken. `delay_ticks`: whole ticks from this call to
  /// the hold that renders its force, 0 (the next one) to k_most_delay; forces under way are counted as
  /// given.
  /// `device_damping_over_dt`: of the device's own damping, N/mm; what it takes out of the hand's motion may
  /// be given. 0 when it is not known.
  explicit PassivityController(double allowance = 0, int delay_ticks = 0,
                               double device_damping_over_dt = 0) noexcept;

  /// The force to render in place of `wanted` at position x (mm), with the proxy at p. Once a tick, with what
  /// is measured; without contact p is x.
  glm::dvec3 step(const glm::dvec3& wanted, const glm::dvec3& x, const glm::dvec3& p) noexcept;
  /// Reports the force that was rendered last: others limited it further, or let it out more slowly.
  void set_rendered(const glm::dvec3& force) noexcept {
    under_way_[static_cast<std::size_t>(delay_)] = force;
  }
  /// Reports lost ticks, in which the motion of the hand is unknown: the debt stays, the store does not.
  void lose_sight() noexcept;
  /// Work done on the hand so far less what friction took, N mm; positive is energy that came from nowhere.
  double energy() const noexcept { return energy_; }
  /// The share of the forces wanted that is let through, as far as it is not cut; below 1 only where they are
  /// late.
  double softness() const noexcept { return softness_; }
  /// Ticks in which the force was cut.
  long cuts() const noexcept { return cuts_; }
  /// Discards the balance: contact was lost, or the scene changed.
  void reset() noexcept;
  /// Complete state, field by field, for saving.
  template <class Fields>
  void each_field(Fields& fields) {
    fields(under_way_, last_x_, last_p_, move_, energy_, softness_, largest_, cuts_, has_last_);
  }

 private:
  double allowance_, damping_;
  int delay_;
  std::array<glm::dvec3, k_most_delay + 1> under_way_{};  ///< oldest first; [0] was held since the last call
  glm::dvec3 last_x_{0.0}, last_p_{0.0}, move_{0.0};      ///< move_: the newest motion that was seen
  double energy_ = 0, softness_ = 1, largest_ = 0;        ///< largest_: energy of a step, lately
  long cuts_ = 0;
  bool has_last_ = false;
};

}  // namespace trephine::haptics
