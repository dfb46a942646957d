#include "haptics/force/passivity.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::haptics {

using glm::dvec3;

namespace {
constexpr double k_softest = 0.02;  // share of the force that is always left
constexpr double k_softer = 0.8;    // of it is left after a tick that made energy from nowhere
constexpr double k_firmer = 0.002;  // of what is missing comes back in a tick without contact
constexpr double k_noticed = 0.25;  // of the largest step's energy lately: less is rounding and sampling
constexpr double k_forget = 0.999;  // of that is left after a tick
}  // namespace

PassivityController::PassivityController(double allowance, int delay_ticks,
                                         double device_damping_over_dt) noexcept
    : allowance_(allowance),
      damping_(device_damping_over_dt),
      delay_(std::clamp(delay_ticks, 0, k_most_delay)) {
  under_way_.fill(dvec3(0));
}

dvec3 PassivityController::step(const dvec3& wanted, const dvec3& x, const dvec3& p) noexcept {
  dvec3 force = softness_ * wanted;
  if (has_last_) {
    const dvec3 moved = x - last_x_;
    const double lost = std::max(0.0, -glm::dot(under_way_[0], p - last_p_));
    const double fresh = glm::dot(under_way_[0], moved) + lost - damping_ * glm::dot(moved, moved);
    energy_ += fresh;
    largest_ = std::max(std::abs(fresh), k_forget * largest_);
    if (moved != dvec3(0)) move_ = moved;
    // Energy of the next hold when the hand goes on as it went.
    double store = allowance_ - energy_;
    // Forces that are late meet a hand that may be faster by then.
    const double faster = delay_ > 0 ? 2 : 1;
    for (int i = 1; i <= delay_; ++i)
      store -= faster * std::max(0.0, glm::dot(under_way_[static_cast<std::size_t>(i)], move_));
    store = std::max(0.0, store) / faster;
    // Forces under way cannot be taken back: a surface that makes energy late is made softer, until it makes
    // none. To make it firmer while it is pressed would be energy from nowhere too.
    if (delay_ > 0 && fresh > 0 && energy_ > allowance_ + k_noticed * largest_)
      softness_ = std::max(k_softest, k_softer * softness_);
    else if (p == x)
      softness_ += k_firmer * (1 - softness_);
    force = softness_ * wanted;
    const double give = glm::dot(force, move_);
    if (give > store) {
      force -= (give - store) / glm::dot(move_, move_) * move_;
      ++cuts_;
    }
  }
  for (int i = 0; i < delay_; ++i)
    under_way_[static_cast<std::size_t>(i)] = under_way_[static_cast<std::size_t>(i) + 1];
  under_way_[static_cast<std::size_t>(delay_)] = force;
  last_x_ = x;
  last_p_ = p;
  has_last_ = true;
  return force;
}

void PassivityController::lose_sight() noexcept {
  energy_ = std::max(0.0, energy_);
  has_last_ = false;
}

void PassivityController::reset() noexcept {
  // Forces that are under way will still be held, and are counted then.
  energy_ = 0;
  move_ = dvec3(0);
}

}  // namespace trephine::haptics
