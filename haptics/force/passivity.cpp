#include "haptics/force/passivity.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "haptics/device/pose_path.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {
constexpr double k_least_scale = 0.02;  // least factor of the force
constexpr double k_softening = 0.8;     // factor of the scale per tick that creates energy
constexpr double k_recovery = 0.002;    // share of the missing scale that returns per tick without contact
constexpr double k_noticed = 0.25;  // share of the largest recent step energy: less is rounding and sampling
constexpr double k_forget = 0.999;  // factor of that energy per tick
}  // namespace

PassivityController::PassivityController(double allowance, int delay_ticks,
                                         double device_damping_over_dt) noexcept
    : allowance_(allowance),
      damping_(device_damping_over_dt),
      delay_(std::clamp(delay_ticks, 0, k_max_delay)) {}

namespace {
double work(const Wrench& wrench, const dvec3& motion, const dvec3& turn) noexcept {
  return glm::dot(wrench.force_world, motion) + glm::dot(wrench.torque_world, turn);
}
dvec3 turn_from(const glm::dquat& last, const glm::dquat& now) noexcept {
  return last == now ? dvec3(0) : turn_between(last, now);
}
}  // namespace

Wrench PassivityController::step(const Wrench& requested, const dvec3& x, const dvec3& p,
                                 const glm::dquat& hand, const glm::dquat& tool) noexcept {
  const auto softened = [&] {
    return Wrench(force_scale_ * requested.force_world, force_scale_ * requested.torque_world);
  };
  Wrench wrench = softened();
  if (has_last_) {
    const dvec3 motion = x - last_x_, turn = turn_from(last_hand_, hand);
    const double dissipated = std::max(0.0, -work(under_way_[0], p - last_p_, turn_from(last_tool_, tool)));
    const double gained =
        work(under_way_[0], motion, turn) + dissipated - damping_ * glm::dot(motion, motion);
    energy_ += gained;
    largest_ = std::max(std::abs(gained), k_forget * largest_);
    if (motion != dvec3(0) || turn != dvec3(0)) move_ = motion, turn_ = turn;
    // Energy that may still be returned.
    double store = allowance_ - energy_;
    // Delayed forces act on a hand that may be faster by then.
    const double speed_margin = delay_ > 0 ? 2 : 1;
    for (int i = 1; i <= delay_; ++i)
      store -= speed_margin * std::max(0.0, work(under_way_[static_cast<std::size_t>(i)], move_, turn_));
    store = std::max(0.0, store) / speed_margin;
    // Forces under way cannot be changed: a surface that creates energy late is softened until it creates no
    // more. Stiffening it while it is pressed would create energy as well.
    if (delay_ > 0 && gained > 0 && energy_ > allowance_ + k_noticed * largest_)
      force_scale_ = std::max(k_least_scale, k_softening * force_scale_);
    else if (p == x && tool == hand)
      force_scale_ += k_recovery * (1 - force_scale_);
    wrench = softened();
    // Energy of the next hold if the hand continues its motion.
    const double returned = work(wrench, move_, turn_);
    if (returned > store) {
      const double share =
          (returned - store) / (glm::dot(move_, move_) + k_arm_square * glm::dot(turn_, turn_));
      wrench.force_world -= share * move_;
      wrench.torque_world -= share * k_arm_square * turn_;
      ++limited_ticks_;
    }
  }
  for (int i = 0; i < delay_; ++i)
    under_way_[static_cast<std::size_t>(i)] = under_way_[static_cast<std::size_t>(i) + 1];
  under_way_[static_cast<std::size_t>(delay_)] = wrench;
  last_x_ = x;
  last_p_ = p;
  last_hand_ = hand;
  last_tool_ = tool;
  has_last_ = true;
  return wrench;
}

void PassivityController::on_lost_ticks() noexcept {
  energy_ = std::max(0.0, energy_);
  has_last_ = false;
}

void PassivityController::reset() noexcept {
  // Forces under way will still be rendered, and are counted then.
  energy_ = 0;
  move_ = turn_ = dvec3(0);
}

}  // namespace trephine::haptics
