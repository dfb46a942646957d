#include "tests/checker/force_judge.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::checker {

using glm::dvec3;

ForceJudge::ForceJudge(const ForceLaw& law)
    : law_(law), alpha_(1 - std::pow(1 - law.alpha, 1000 * law.dt)), cap_(law.limit) {}

void ForceJudge::restart(bool is_fresh) {
  const ForceLaw law = law_;
  const long ticks = ticks_, wrong = wrong_forces_;
  const double force = worst_force_, energy = worst_energy_;
  *this = ForceJudge(law);
  ticks_ = ticks, wrong_forces_ = wrong, worst_force_ = force, worst_energy_ = energy;
  // Half a second: smoothing forgets in some 20 ticks, fades and the way back from a lead take longer.
  if (!is_fresh) unsure_ = static_cast<int>(0.8 / law_.dt);
}

void ForceJudge::look(const ForceTick& t) {
  ++ticks_;
  const auto shortened = [](const dvec3& v, double most) {
    const double size = glm::length(v);
    return size > most ? v * (most / size) : v;
  };
  if (t.is_reset) {
    smoothed_ = last_ = dvec3(0);
    had_contact_ = false;
    fade_ = 1;
    cap_ = law_.limit;
    is_lost_ = false;
  }
  if (t.is_restarted) {
    smoothed_ = dvec3(0);
    had_contact_ = false;
  }
  if (t.is_led && !was_led_) had_contact_ = false;

  dvec3 wanted(0);
  if (!t.is_not_finite) {
    dvec3 spring(0);
    if (t.has_contact) {
      const dvec3 stretch = t.proxy - t.position;
      spring = t.stiffness * stretch;
      if (had_contact_) spring += t.damping / law_.dt * (stretch - stretch_);
      stretch_ = stretch;
    }
    had_contact_ = t.has_contact;
    cap_ = t.is_led ? law_.lead_force : std::min(law_.limit, cap_ + law_.lead_recovery * law_.dt);
    if (t.is_buried) {
      smoothed_ = dvec3(0);
      had_contact_ = false;
    } else {
      smoothed_ = alpha_ * spring + (1 - alpha_) * smoothed_;
      wanted = shortened(smoothed_, cap_);
    }
  }
  // A position that was none leaves nothing to trust until a reset.
  is_lost_ = is_lost_ || t.is_not_finite;
  dvec3 force(0);
  if (!is_lost_) {
    if (t.is_fading) fade_ = std::max(0.0, fade_ - law_.dt / law_.fade_seconds);
    force = shortened(t.is_fading ? fade_ * wanted : wanted, law_.limit);
    const dvec3 change = force - last_;
    if (glm::length(change) > law_.slew * law_.dt) force = last_ + shortened(change, law_.slew * law_.dt);
    if (t.is_fading && fade_ == 0) force = dvec3(0);
  }
  if (unsure_ > 0) {
    --unsure_;
  } else {
    const double off = glm::length(force - t.force);
    worst_force_ = std::max(worst_force_, off);
    if (!(off < 1e-6)) ++wrong_forces_;
  }

  // The ledger: work of the force that was held over the motion that followed.
  const bool has_position = !t.is_not_finite;
  if (had_position_ && has_position)
    (was_led_ ? growth_ : contact_) += glm::dot(last_, t.position - last_position_);
  worst_energy_ = std::max(
      worst_energy_, std::max(std::abs(contact_ - t.contact_energy), std::abs(growth_ - t.growth_energy)));
  contact_ = t.contact_energy, growth_ = t.growth_energy;
  had_position_ = has_position;
  last_position_ = t.position;
  was_led_ = t.is_led;
  last_ = t.force;
}

}  // namespace trephine::checker
