#include "apps/verify/effect_judge.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::verify {

using glm::dvec3;

namespace {
constexpr double k_turn = 6.283185307179586;
constexpr double k_power = 500;            // N mm/s, largest power of active effects
constexpr double k_velocity_time = 0.003;  // s over which a hand's velocity is averaged

dvec3 limited(const dvec3& v, double limit) {
  const double size = glm::length(v);
  return size > limit ? v * (limit / size) : v;
}
}  // namespace

EffectJudge::EffectJudge(std::vector<EffectLaw> laws, double dt) : laws_(std::move(laws)), dt_(dt) {
  reset();
}

void EffectJudge::reset() {
  track_end_.assign(laws_.size(), -1);
  turns_.assign(laws_.size(), 0);
  velocity_ = spin_ = dvec3(0);
  ticks_ = 0;
  has_previous_ = false;
}

void EffectJudge::set(std::vector<EffectLaw> laws) {
  std::vector<double> ends, turns;
  for (const EffectLaw& law : laws) {
    std::size_t i = 0;
    while (i < laws_.size() && !(laws_[i].id == law.id && laws_[i].kind == law.kind)) ++i;
    ends.push_back(i < laws_.size() ? track_end_[i] : -1);
    turns.push_back(i < laws_.size() ? turns_[i] : 0);
  }
  laws_ = std::move(laws);
  if (laws_.empty()) return reset();
  track_end_ = std::move(ends);
  turns_ = std::move(turns);
}

EffectJudge::Forces EffectJudge::judge_tick(const dvec3& at, const dvec3& proxy, const dvec3& normal,
                                            bool has_contact, const dvec3& contact_force, const dvec3& shaft,
                                            bool is_working, const dvec3& contact_torque) {
  if (has_previous_) {
    const double share = std::min(1.0, dt_ / k_velocity_time);
    velocity_ = (1 - share) * velocity_ + share / dt_ * (at - previous_);
  }
  previous_ = at;
  has_previous_ = true;
  ++ticks_;
  Forces sum;
  using Kind = EffectLaw::Kind;
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const EffectLaw& law = laws_[i];
    const dvec3 offset = at - law.position;
    const double along = glm::dot(offset, law.direction);
    dvec3 force(0);
    bool is_active = true;
    switch (law.kind) {
      case Kind::constant:
        force = law.position;
        break;
      case Kind::viscous:
        force = -law.strength * velocity_, is_active = false;
        break;
      case Kind::spring:
        force = -law.strength * offset, is_active = false;
        break;
      case Kind::line: {
        force = -law.strength * (offset - along * law.direction), is_active = false;
        double& end = track_end_[i];
        if (end < 0) end = std::max(0.0, along);
        // A push beyond the resistance extends the track until the push equals the resistance.
        end = std::max(end, along - law.second_parameter / law.strength);
        force -= law.strength * std::max(0.0, along - end) * law.direction;
        break;
      }
      case Kind::plane:
        force = law.strength * std::max(0.0, -along) * law.direction, is_active = false;
        break;
      case Kind::vibration:
        turns_[i] += std::min(law.second_parameter * dt_, 0.25);
        force = law.strength * std::sin(k_turn * std::fmod(turns_[i], 1.0)) * law.direction;
        break;
      case Kind::gravity:
        force = 9.80665 * law.strength * law.direction;
        break;
      case Kind::texture:
        if (has_contact) {
          const dvec3 in_surface = law.direction - glm::dot(law.direction, normal) * normal;
          const double slope = k_turn * law.strength / law.second_parameter *
                               std::cos(k_turn * glm::dot(proxy, law.direction) / law.second_parameter);
          force = -std::max(0.0, glm::dot(contact_force, normal)) * slope * in_surface;
        }
        break;
      case Kind::spin: {
        turns_[i] += std::min(law.second_parameter * dt_, 0.25);
        const double push = glm::dot(contact_force, normal);
        if (!is_working || !has_contact || push <= 0) break;
        const double swing = law.third_parameter * std::sin(k_turn * std::fmod(turns_[i], 1.0));
        // The tool turns clockwise, viewed from the hand: a wall on its left drags it forward.
        force = push * swing * normal + push * (law.strength + swing) * glm::cross(shaft, normal);
        break;
      }
      case Kind::insertion: {
        // The proxy is the tip, which is at the end of the track while the hand pushes.
        const double end = glm::dot(proxy - law.position, law.direction);
        force = -law.strength * (offset - along * law.direction) -
                law.second_parameter * std::max(0.0, along - end) * law.direction;
        is_active = false;
        break;
      }
      case Kind::missing_torque: {
        turns_[i] += std::min(law.second_parameter * dt_, 0.25);
        const double torque = glm::length(contact_torque);
        if (torque <= law.third_parameter) break;
        // The vibration is perpendicular to torque and stylus; for a torque about the stylus, along the
        // stylus.
        const dvec3 across = glm::cross(shaft, contact_torque / torque);
        const dvec3 direction = glm::length(across) > 1e-3 ? glm::normalize(across) : -shaft;
        force = law.strength * (torque - law.third_parameter) * std::sin(k_turn * std::fmod(turns_[i], 1.0)) *
                direction;
        break;
      }
      case Kind::align:  // no force
        break;
    }
    (is_active ? sum.active : sum.rendered) += limited(force, law.max_force);
  }
  if (const double speed = glm::length(velocity_); speed > 0)
    sum.active = limited(sum.active, k_power / speed);
  return sum;
}

dvec3 EffectJudge::torque(const dvec3& shaft, const dvec3& rotation) {
  spin_ += std::min(1.0, dt_ / k_velocity_time) * (rotation / dt_ - spin_);
  dvec3 sum(0);
  for (const EffectLaw& law : laws_)
    if (law.kind == EffectLaw::Kind::align)
      sum += limited(law.strength * glm::cross(shaft, law.direction) - law.second_parameter * spin_,
                     10 * law.max_force);  // N mm: each N of `max_force` allows 10 N mm
  return sum;
}

}  // namespace trephine::verify
