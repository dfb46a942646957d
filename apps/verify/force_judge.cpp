#include "apps/verify/force_judge.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::verify {

using glm::dvec3;

ForceJudge::ForceJudge(const ForceLaw& law)
    : law_(law),
      alpha_(1 - std::pow(1 - law.alpha, 1000 * law.dt)),
      cap_(law.limit),
      effects_(law.effects, law.dt) {}

void ForceJudge::restart(bool is_fresh) {
  has_axes_ = false;
  const ForceLaw law = law_;
  const long ticks = ticks_, wrong = wrong_forces_;
  const double force = worst_force_, torque = worst_torque_, energy = worst_energy_;
  // The lost ticks rendered no force, so a debt of energy remains. The reduced firmness also remains.
  const double debt = is_fresh ? 0 : std::max(0.0, given_), firmness = is_fresh ? 1 : firmness_,
               strongest = is_fresh ? 0 : strongest_;
  const std::vector<dvec3> sent = is_fresh ? std::vector<dvec3>() : sent_;
  const dvec3 motion = is_fresh ? dvec3(0) : motion_;
  *this = ForceJudge(law);
  ticks_ = ticks, wrong_forces_ = wrong, worst_force_ = force, worst_torque_ = torque, worst_energy_ = energy;
  given_ = debt, firmness_ = firmness, strongest_ = strongest, sent_ = sent, motion_ = motion;
  // Judge no forces for 0.8 s, since the state before the restart is unknown. Its effect on the smoothing
  // ends in about 20 ticks, but fades and the recovery of the limit after an escape take longer.
  if (!is_fresh) unjudged_ticks_ = static_cast<int>(0.8 / law_.dt);
}

dvec3 ForceJudge::passive(const dvec3& requested, const dvec3& position, const dvec3& proxy) {
  // A force sent now is held from `delay` ticks on; until then, older forces are held.
  const auto delay = static_cast<std::size_t>(law_.delay_ticks);
  const auto sent_before = [&](std::size_t ticks) {
    return ticks <= sent_.size() ? sent_[sent_.size() - ticks] : dvec3(0);
  };
  dvec3 force = firmness_ * requested;
  if (!measured_.empty()) {
    const dvec3 moved = position - measured_.back();
    const dvec3 held = sent_before(delay + 1), yielded = proxy - proxies_.back();
    // If the proxy yields to the force, the work of the force becomes heat, which cannot be recovered.
    const double heat = std::max(0.0, -glm::dot(held, yielded));
    const double gain = glm::dot(held, moved) + heat - law_.device_damping / law_.dt * glm::dot(moved, moved);
    given_ += gain;
    strongest_ = std::max(std::abs(gain), 0.999 * strongest_);
    if (glm::length(moved) > 0) motion_ = moved;
    // A delayed force may act on a hand that moves twice as fast by then.
    const double speed_factor = delay > 0 ? 2 : 1;
    double allowance = -given_;
    for (std::size_t k = 1; k <= delay; ++k)
      allowance -= speed_factor * std::max(0.0, glm::dot(sent_before(delay + 1 - k), motion_));
    // With a delay, reduce the firmness by a fifth if the energy debt grows beyond a quarter of the largest
    // recent energy of a tick. Otherwise, without contact, recover a five-hundredth of the missing firmness.
    if (delay > 0 && gain > 0 && given_ > 0.25 * strongest_)
      firmness_ = std::max(0.02, 0.8 * firmness_);
    else if (proxy == position)
      firmness_ += 0.002 * (1 - firmness_);
    force = firmness_ * requested;
    const double max_work = std::max(0.0, allowance) / speed_factor, work = glm::dot(force, motion_);
    if (work > max_work) force -= (work - max_work) / glm::dot(motion_, motion_) * motion_;
  }
  sent_.push_back(force);
  measured_.push_back(position);
  proxies_.push_back(proxy);
  if (sent_.size() > 64) {
    sent_.erase(sent_.begin(), sent_.begin() + 32);
    if (measured_.size() > 32) {
      measured_.erase(measured_.begin(), measured_.end() - 32);
      proxies_.erase(proxies_.begin(), proxies_.end() - 32);
    }
  }
  return force;
}

void ForceJudge::judge_tick(const ForceTick& t) {
  ++ticks_;
  const auto limited = [](const dvec3& v, double limit) {
    const double size = glm::length(v);
    return size > limit ? v * (limit / size) : v;
  };
  if (t.is_reset || t.is_restarted) {
    given_ = 0;
    motion_ = dvec3(0);
  }
  if (t.is_reset) {
    effects_.reset();
    last_torque_ = dvec3(0);
    smoothed_ = last_ = smoothed_turn_ = dvec3(0);
    had_contact_ = had_turn_ = false;
    fade_ = 1;
    cap_ = 0;
    is_lost_ = false;
  }
  if (t.is_restarted) {
    smoothed_ = smoothed_turn_ = dvec3(0);
    had_contact_ = had_turn_ = false;
  }
  if (t.is_escaping && !was_led_) had_contact_ = had_turn_ = false;

  dvec3 requested(0), active(0);
  contact_torque_ = dvec3(0);
  if (!t.is_not_finite) {
    dvec3 spring(0);
    if (t.has_contact) {
      const dvec3 stretch = t.proxy - t.position;
      spring = t.stiffness * stretch;
      if (had_contact_) {
        spring += t.damping / law_.dt * (stretch - stretch_);
        const dvec3 moved = t.position - contact_position_ - t.carried;
        spring -= t.viscosity / law_.dt * (moved - glm::dot(moved, t.normal) * t.normal);
      }
      stretch_ = stretch;
      contact_position_ = t.position;
    }
    had_contact_ = t.has_contact;
    cap_ = t.is_escaping ? law_.lead_force : std::min(law_.limit, cap_ + law_.lead_recovery * law_.dt);
    if (t.is_buried) {
      smoothed_ = dvec3(0);
      had_contact_ = false;
    } else {
      smoothed_ = alpha_ * spring + (1 - alpha_) * smoothed_;
      requested = limited(smoothed_, cap_);
    }
    if (t.gyration_square > 0) {
      dvec3 twist(0);
      if (t.has_contact) {
        twist = t.gyration_square * t.stiffness * t.turn;
        if (had_turn_) twist += t.gyration_square * t.damping / law_.dt * (t.turn - last_turn_);
        last_turn_ = t.turn;
      }
      had_turn_ = t.has_contact;
      smoothed_turn_ = t.is_buried ? dvec3(0) : alpha_ * twist + (1 - alpha_) * smoothed_turn_;
      // While the force is limited after an escape, the torque is reduced by the same share.
      contact_torque_ = std::min(1.0, cap_ / law_.limit) * smoothed_turn_;
    }
    EffectJudge::Forces effects;
    if (!effects_.is_empty()) {
      effects = effects_.judge_tick(t.position, t.proxy, t.normal, t.has_contact, requested, -t.axes[2],
                                    t.is_working, contact_torque_);
      requested += effects.rendered;
    }
    if (law_.is_passive) requested = passive(requested, t.position, t.has_contact ? t.proxy : t.position);
    requested += effects.active;
    active = effects.active;
  }
  // After a position that was not finite no state is valid until a reset.
  is_lost_ = is_lost_ || t.is_not_finite;
  dvec3 force(0);
  if (!is_lost_) {
    if (t.is_fading) fade_ = std::max(0.0, fade_ - law_.dt / law_.fade_seconds);
    force = limited(t.is_fading ? fade_ * requested : requested, law_.limit);
    const dvec3 change = force - last_;
    if (glm::length(change) > law_.slew * law_.dt) force = last_ + limited(change, law_.slew * law_.dt);
    if (t.is_fading && fade_ == 0) force = dvec3(0);
  }
  judge_torque(t, unjudged_ticks_ == 0);
  if (unjudged_ticks_ > 0) {
    --unjudged_ticks_;
  } else {
    const double error = glm::length(force - t.force);
    worst_force_ = std::max(worst_force_, error);
    if (!(error < 1e-6)) ++wrong_forces_;
  }

  // Energy ledger: work of the previous force over the motion since the previous tick.
  const bool has_position = !t.is_not_finite;
  if (had_position_ && has_position) {
    const dvec3 moved = t.position - last_position_;
    const dvec3 passive = last_ - last_active_;
    if (was_led_) {
      growth_ += glm::dot(last_, moved);
    } else {
      contact_ += glm::dot(passive, moved);
      active_ += glm::dot(last_active_, moved);
      if (glm::length(last_normal_) > 0)
        friction_ += glm::dot(passive, moved - glm::dot(moved, last_normal_) * last_normal_);
    }
  }
  worst_energy_ =
      std::max({worst_energy_, std::abs(contact_ - t.contact_energy), std::abs(growth_ - t.growth_energy),
                std::abs(friction_ - t.friction_energy), std::abs(active_ - t.active_energy)});
  contact_ = t.contact_energy, growth_ = t.growth_energy, friction_ = t.friction_energy,
  active_ = t.active_energy;
  // Limits scale all parts of a force equally.
  const double size = glm::length(requested);
  last_active_ = size > 0 ? active * std::min(1.0, glm::length(t.force) / size) : dvec3(0);
  last_normal_ = t.normal;
  had_position_ = has_position;
  last_position_ = t.position;
  was_led_ = t.is_escaping;
  last_ = t.force;
  if (!law_.is_passive) return;
  // The work is done by the force that was sent, not by the requested force.
  if (!sent_.empty()) sent_.back() = last_ - last_active_;
  if (t.is_not_finite) {
    given_ = std::max(0.0, given_);
    measured_.clear();
    proxies_.clear();
  }
}

/// Judges the torque of a tick and its energy.
void ForceJudge::judge_torque(const ForceTick& t, bool is_known) {
  const auto limited = [](const dvec3& v, double limit) {
    const double size = glm::length(v);
    return size > limit ? v * (limit / size) : v;
  };
  // Turn of the stylus: half the sum of the axes' motions about their previous directions.
  dvec3 turn(0);
  if (has_axes_ && !t.is_not_finite) {
    for (int a = 0; a < 3; ++a) turn += 0.5 * glm::cross(last_axes_[a], t.axes[a]);
    const double sine = glm::length(turn);
    if (sine > 0) turn *= 2 * std::sin(0.5 * std::asin(std::min(1.0, sine))) / sine;
  }
  turning_ += glm::dot(last_torque_, turn);
  if (is_known) worst_energy_ = std::max(worst_energy_, std::abs(turning_ - t.turning_energy));
  turning_ = t.turning_energy;
  dvec3 torque = contact_torque_;
  if (!t.is_not_finite && !effects_.is_empty())
    torque += effects_.torque(-t.axes[2], effects_.has_previous_tick() ? turn : dvec3(0));
  torque = is_lost_ ? dvec3(0) : limited(fade_ * torque, law_.torque_limit);
  if (!is_lost_) torque = last_torque_ + limited(torque - last_torque_, law_.torque_slew * law_.dt);
  if (t.is_fading && fade_ == 0) torque = dvec3(0);
  if (is_known) {
    const double error = glm::length(torque - t.torque);
    worst_torque_ = std::max(worst_torque_, error);
    if (!(error < 1e-6)) ++wrong_forces_;
  }
  last_torque_ = t.torque;
  has_axes_ = !t.is_not_finite;
  for (int a = 0; a < 3; ++a) last_axes_[a] = t.axes[a];
}

}  // namespace trephine::verify
