// ReturnedEnergy: energy that a rendered force gives to a hand, from the force and the hand's motion alone.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics/servo/servo_core.h"

namespace trephine::cli {

/// Sums the energy of all touches, and its bound. A force is held until the next tick while the hand keeps
/// moving. A spring of stiffness K, sampled with the period T and smoothed by alpha, therefore acts
/// d = 1/2 + (1 - alpha)/alpha ticks late. On a motion into the surface and out again, the spring returns at
/// most d K |dx|^2 per tick more than it absorbed, where dx is the motion in the tick (Colgate and Schenkel
/// 1997: a device must damp K T / 2).
class ReturnedEnergy {
 public:
  ReturnedEnergy(const haptics::TouchScene& scene, double alpha)
      : scene_(scene), delay_ticks_(0.5 + (1 - alpha) / alpha) {}
  void observe(const haptics::ServoRecord& r) {
    const glm::dvec3& position = r.pose.position_world;
    if (has_last_ && is_on_) {
      const glm::dvec3 motion = position - last_;
      work_ += glm::dot(force_, motion);
      bound_ += delay_ticks_ * stiffness_ * glm::dot(motion, motion);
    }
    constexpr double k_min_force = 1e-4;  // N; a smoothed force decays without reaching 0
    const bool is_on = r.has_contact || glm::length(r.force_world) > k_min_force;
    if (is_on_ && !is_on) end();
    if (r.has_contact && r.shape >= 0) {
      const haptics::TouchItem& item = haptics::item_of(scene_, r.shape);
      stiffness_ = std::max(stiffness_, item.ramp ? item.ramp->dense_stiffness : item.material.stiffness);
    }
    is_on_ = is_on, has_last_ = true;
    last_ = position, force_ = r.force_world;
  }
  /// Net energy (N mm) that the force gave to the hand, summed over the touches in which the force gave more
  /// than it absorbed. A touch lasts from the first contact to zero force; a touch that has not ended is not
  /// included.
  double returned() const { return returned_; }
  /// Largest value of returned() (N mm) that sampling and smoothing allow.
  double bound() const { return total_bound_; }

 private:
  void end() {
    if (work_ > 0) returned_ += work_;
    total_bound_ += bound_;
    work_ = bound_ = 0;
  }
  const haptics::TouchScene& scene_;
  double delay_ticks_, stiffness_ = 0, work_ = 0, bound_ = 0, returned_ = 0, total_bound_ = 0;
  glm::dvec3 last_{0.0}, force_{0.0};
  bool is_on_ = false, has_last_ = false;
};

}  // namespace trephine::cli
