// Judges a servo's forces and its energy ledger from what a tick reports, by the law as the documents state
// it: spring and damper, smoothing, limits, slew, fades. Shares no code with haptics.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "tests/checker/effect_judge.h"

namespace trephine::checker {

/// The law's numbers: N, s; smoothing at 1 kHz.
struct ForceLaw {
  double dt = 1e-3, alpha = 0.3, limit = 8, slew = 1000, fade_seconds = 0.05;
  double lead_force = 3, lead_recovery = 10;  ///< N while a proxy is led out of matter, and N/s after that
  /// The passivity controller: what surfaces give along the hand's motion is cut to what they took.
  bool is_passive = false;
  int delay_ticks = 0;
  double device_damping = 0;                       ///< N s/mm
  double torque_limit = 150, torque_slew = 20000;  ///< N mm, N mm/s
  std::vector<EffectLaw> effects;
};

/// One tick as reported.
struct ForceTick {
  glm::dvec3 position{0.0}, proxy{0.0}, force{0.0};
  glm::dvec3 normal{0.0};
  double stiffness = 0, damping = 0, viscosity = 0;  ///< of the touched surface
  glm::dvec3 carried{0.0};                           ///< mm that what is touched moved by, there
  bool has_contact = false, is_buried = false, is_led = false, is_reset = false, is_restarted = false;
  bool is_working = true;                                  ///< the button is down
  bool is_not_finite = false;                              ///< the position was no number
  bool is_fading = false;                                  ///< a latched fault is on
  double contact_energy = 0, growth_energy = 0;            ///< the ledger after this tick, N mm
  double friction_energy = 0;                              ///< of contact: along the surface
  double active_energy = 0;                                ///< of effects that may give some
  glm::dvec3 torque{0.0};                                  ///< N mm
  glm::dvec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  ///< of the stylus; it points along -axes[2]
  double turning_energy = 0;                               ///< of torques, N mm
};

class ForceJudge {
 public:
  explicit ForceJudge(const ForceLaw& law);
  void judge_tick(const ForceTick& tick);
  /// From the next tick on these effects; what one of the same id and kind remembered stays.
  void set_effects(std::vector<EffectLaw> laws) {
    law_.effects = laws;
    effects_.set(std::move(laws));
  }
  /// Ticks were lost, or the servo was made anew: what came before is unknown. `is_fresh`: made anew,
  /// everything zero.
  void restart(bool is_fresh);

  long ticks() const { return ticks_; }
  long wrong_forces() const { return wrong_forces_; }
  double worst_force_n() const { return worst_force_; }
  double worst_torque_nmm() const { return worst_torque_; }
  double worst_energy_nmm() const {
    return worst_energy_;
  }  ///< of the ledger against the forces and motions themselves

 private:
  ForceLaw law_;
  double alpha_;
  void judge_torque(const ForceTick& tick, bool is_seen);
  /// What the controller leaves of a force wanted at a place.
  glm::dvec3 passive(const glm::dvec3& wanted, const glm::dvec3& position, const glm::dvec3& proxy);

  glm::dvec3 smoothed_{0.0}, stretch_{0.0}, contact_position_{0.0}, last_{0.0}, last_position_{0.0};
  std::vector<glm::dvec3> sent_;      ///< by the controller, every tick; the newest last
  std::vector<glm::dvec3> measured_;  ///< where the hand was then
  std::vector<glm::dvec3> proxies_;   ///< and the proxy; the hand itself without contact
  double given_ = 0;        ///< N mm, of forces that were held, less what the device damps, plus heat
  double firmness_ = 1;     ///< share of late forces that is let through
  double strongest_ = 0;    ///< energy of a step, lately
  glm::dvec3 motion_{0.0};  ///< the newest that was one
  glm::dvec3 last_normal_{0.0}, last_active_{0.0};
  double fade_ = 1, cap_, contact_ = 0, growth_ = 0, friction_ = 0, active_ = 0;
  glm::dvec3 last_torque_{0.0}, last_axes_[3];
  bool has_axes_ = false;
  double turning_ = 0, worst_torque_ = 0;
  bool had_contact_ = false, was_led_ = false, had_position_ = false, is_lost_ = false;
  int unsure_ = 0;  ///< ticks until smoothing has forgotten what was not seen
  long ticks_ = 0, wrong_forces_ = 0;
  double worst_force_ = 0, worst_energy_ = 0;
  EffectJudge effects_;
};

}  // namespace trephine::checker
