#include "haptics/force/passivity.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::haptics {

using glm::dvec3;

namespace {
constexpr double k_softest = 0.02;  // least factor of the force
constexpr double k_softer = 0.8;    // factor of the softness per tick that creates energy
constexpr double k_firmer = 0.002;  // share of the missing softness that returns per tick without contact
constexpr double k_noticed = 0.25;  // share of the largest recent step energy: less is rounding and sampling
constexpr double k_forget = 0.999;  // factor of that energy per tick
}  // namespace

PassivityController::PassivityController(double allowance, int delay_ticks,
                                         double device_damping_over_dt) noexcept
    : allowance_(allowance),
      damping_(device_damping_over_dt),
      delay_(std::clamp(delay_ticks, 0, k_max_delay)) {
  under_way_.fill(dvec3(0));
}

dvec3 PassivityController::step(const dvec3& requested, const dvec3& x, const dvec3& p) noexcept {
  dvec3 force = softness_ * requested;
  if (has_last_) {
    const dvec3 motion = x - last_x_;
    const double dissipated = std::max(0.0, -glm::dot(under_way_[0], p - last_p_));
    const double gained = glm::dot(under_way_[0], motion) + dissipated - damping_ * glm::dot(motion, motion);
    energy_ += gained;
    largest_ = std::max(std::abs(gained), k_forget * largest_);
    if (motion != dvec3(0)) move_ = motion;
    // Energy of the next hold if the hand continues its motion.
    double store = allowance_ - energy_;
    // Delayed forces act on a hand that may be faster by then.
    const double speed_margin = delay_ > 0 ? 2 : 1;
    for (int i = 1; i <= delay_; ++i)
      store -= speed_margin * std::max(0.0, glm::dot(under_way_[static_cast<std::size_t>(i)], move_));
    store = std::max(0.0, store) / speed_margin;
    // Forces under way cannot be changed: a surface that creates energy late is softened until it creates no
    // more. Stiffening it while it is pressed would create energy as well.
    if (delay_ > 0 && gained > 0 && energy_ > allowance_ + k_noticed * largest_)
      softness_ = std::max(k_softest, k_softer * softness_);
    else if (p == x)
      softness_ += k_firmer * (1 - softness_);
    force = softness_ * requested;
    const double returned = glm::dot(force, move_);
    if (returned > store) {
      force -= (returned - store) / glm::dot(move_, move_) * move_;
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

void PassivityController::on_lost_ticks() noexcept {
  energy_ = std::max(0.0, energy_);
  has_last_ = false;
}

void PassivityController::reset() noexcept {
  // Forces under way will still be rendered, and are counted then.
  energy_ = 0;
  move_ = dvec3(0);
}

}  // namespace trephine::haptics
