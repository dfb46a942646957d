// ForceJudge: judges a servo's forces, torques and energy ledger from the reports of its ticks. Recomputes
// them by the documented law: spring and damper, smoothing, limits, slew, fades, effects, passivity. Shares
// no code with haptics.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "apps/verify/effect_judge.h"

namespace trephine::verify {

/// Parameters of the law: N, s, N/s; `alpha` is the smoothing at 1 kHz.
struct ForceLaw {
  double dt = 1e-3, alpha = 0.3, limit = 8, slew = 1000, fade_seconds = 0.05;
  double lead_force = 3, lead_recovery = 10;  ///< limit during an escape, N; its increase afterwards, N/s
  /// The passivity controller is on: surfaces give no more energy along the hand's motion than they received.
  bool is_passive = false;
  int delay_ticks = 0;                             ///< ticks before a sent force takes effect
  double device_damping = 0;                       ///< N s/mm
  double torque_limit = 150, torque_slew = 20000;  ///< N mm, N mm/s
  std::vector<EffectLaw> effects;
};

/// One tick as reported.
struct ForceTick {
  glm::dvec3 position{0.0}, proxy{0.0}, force{0.0};  ///< mm, mm, N
  glm::dvec3 normal{0.0};
  double stiffness = 0, damping = 0, viscosity = 0;  ///< of the touched surface, N/mm, N s/mm, N s/mm
  glm::dvec3 carried{0.0};                           ///< mm, motion of the touched object at the contact
  /// `is_buried`: restored matter grew over the proxy. `is_escaping`: the proxy is led out of matter.
  /// `is_restarted`: the proxy starts again at a given free point.
  bool has_contact = false, is_buried = false, is_escaping = false, is_reset = false, is_restarted = false;
  bool is_working = true;                                  ///< the button is pressed
  bool is_not_finite = false;                              ///< the position was not finite
  bool is_fading = false;                                  ///< a fault is latched
  double contact_energy = 0, growth_energy = 0;            ///< ledger after this tick, N mm
  double friction_energy = 0;                              ///< of contact, along the surface, N mm
  double active_energy = 0;                                ///< of effects that may add energy, N mm
  glm::dvec3 torque{0.0};                                  ///< N mm
  glm::dvec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  ///< of the stylus; it points along -axes[2]
  double turning_energy = 0;                               ///< of torques, N mm
  /// Rotation from the hand to a tool with six degrees of freedom: axis times 2 sin(angle / 2), rad.
  glm::dvec3 turn{0.0};
  double gyration_square = 0;  ///< mm2, of that tool; 0: a tool with three degrees of freedom
};

class ForceJudge {
 public:
  explicit ForceJudge(const ForceLaw& law);
  void judge_tick(const ForceTick& tick);
  /// Sets the effects from the next tick on. An effect with a known id and kind keeps its state.
  void set_effects(std::vector<EffectLaw> laws) {
    law_.effects = laws;
    effects_.set(std::move(laws));
  }
  /// Restarts the judge. `is_fresh`: for a new servo, whose state is zero; otherwise after lost ticks, so
  /// that the servo's state is unknown.
  void restart(bool is_fresh);

  long ticks() const { return ticks_; }
  /// Returns the number of forces and torques that differ from the law by 1e-6 (N, N mm) or more.
  long wrong_forces() const { return wrong_forces_; }
  double worst_force_n() const { return worst_force_; }
  double worst_torque_nmm() const { return worst_torque_; }
  /// Returns the largest difference of the ledger from the work of the forces over the motions.
  double worst_energy_nmm() const { return worst_energy_; }

 private:
  ForceLaw law_;
  double alpha_;
  void judge_torque(const ForceTick& tick, bool is_known);
  /// Returns a requested force after the passivity controller.
  glm::dvec3 passive(const glm::dvec3& requested, const glm::dvec3& position, const glm::dvec3& proxy);

  glm::dvec3 smoothed_{0.0}, stretch_{0.0}, contact_position_{0.0}, last_{0.0}, last_position_{0.0};
  std::vector<glm::dvec3> sent_;      ///< forces of the controller, one per tick, newest last
  std::vector<glm::dvec3> measured_;  ///< positions of the hand, one per tick, newest last
  std::vector<glm::dvec3> proxies_;   ///< positions of the proxy, or of the hand without contact
  double given_ = 0;                  ///< N mm, work of past forces, less device damping, plus heat
  double firmness_ = 1;               ///< share of delayed forces that is passed on
  double strongest_ = 0;              ///< N mm, largest energy of recent steps
  glm::dvec3 motion_{0.0};            ///< latest nonzero motion, mm
  glm::dvec3 last_normal_{0.0}, last_active_{0.0};
  double fade_ = 1, cap_, contact_ = 0, growth_ = 0, friction_ = 0, active_ = 0;
  glm::dvec3 last_torque_{0.0}, last_axes_[3];
  bool has_axes_ = false;
  double turning_ = 0, worst_torque_ = 0;
  glm::dvec3 smoothed_turn_{0.0}, last_turn_{0.0};  ///< N mm; rad
  glm::dvec3 contact_torque_{0.0};                  ///< N mm, requested by surfaces in this tick
  bool had_turn_ = false;
  bool had_contact_ = false, was_led_ = false, had_position_ = false, is_lost_ = false;
  int unjudged_ticks_ = 0;  ///< ticks after a restart whose forces are not judged
  long ticks_ = 0, wrong_forces_ = 0;
  double worst_force_ = 0, worst_energy_ = 0;
  EffectJudge effects_;
};

}  // namespace trephine::verify
