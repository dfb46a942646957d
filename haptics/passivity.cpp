#include "haptics/passivity.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::haptics {

using glm::dvec3;

PassivityController::PassivityController(double allowance, int delay_ticks,
                                         double device_damping_over_dt) noexcept
    : allowance_(allowance),
      damping_(device_damping_over_dt),
      delay_(std::clamp(delay_ticks, 0, k_most_delay)) {
  under_way_.fill(dvec3(0));
}

dvec3 PassivityController::step(const dvec3& wanted, const dvec3& x, const dvec3& p) noexcept {
  dvec3 force = wanted;
  if (has_last_) {
    const dvec3 moved = x - last_x_;
    const double lost = std::max(0.0, -glm::dot(under_way_[0], p - last_p_));
    energy_ += glm::dot(under_way_[0], moved) + lost - damping_ * glm::dot(moved, moved);
    if (moved != dvec3(0)) move_ = moved;
    // What the next hold will give when the hand goes on as it went.
    double store = allowance_ - energy_;
    // Forces that are late meet a hand that may be faster by then.
    const double faster = delay_ > 0 ? 2 : 1;
    for (int i = 1; i <= delay_; ++i)
      store -= faster * std::max(0.0, glm::dot(under_way_[static_cast<std::size_t>(i)], move_));
    store = std::max(0.0, store) / faster;
    const double give = glm::dot(wanted, move_);
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
