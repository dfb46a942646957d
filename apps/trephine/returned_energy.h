// The energy that a rendered force gives to a hand, by the force and the hand's way alone.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics/servo/servo_core.h"

namespace trephine::app {

/// A force is held until the next tick, while the hand goes on: a spring of stiffness K, sampled every T and
/// smoothed by alpha, acts (1/2 + (1 - alpha)/alpha) ticks late. On a way in and out again it returns at
/// most that many times K |dx|^2 a tick more than it took (Colgate and Schenkel 1997: K T / 2 is what a
/// device must damp).
class ReturnedEnergy {
 public:
  ReturnedEnergy(const haptics::TouchScene& scene, double alpha)
      : scene_(scene), late_(0.5 + (1 - alpha) / alpha) {}
  void observe(const haptics::ServoRecord& r) {
    const glm::dvec3& at = r.pose.position_world;
    if (has_last_ && is_on_) {
      const glm::dvec3 way = at - last_;
      work_ += glm::dot(force_, way);
      bound_ += late_ * stiffness_ * glm::dot(way, way);
    }
    constexpr double k_felt = 1e-4;  // N: a smoothed force dies away
    const bool is_on = r.has_contact || glm::length(r.force_world) > k_felt;
    if (is_on_ && !is_on) end();
    if (r.has_contact && r.shape >= 0) {
      const haptics::TouchItem& item = haptics::item_of(scene_, r.shape);
      stiffness_ = std::max(stiffness_, item.ramp ? item.ramp->dense_stiffness : item.material.stiffness);
    }
    is_on_ = is_on, has_last_ = true;
    last_ = at, force_ = r.force_world;
  }
  /// N mm, over all touches from first contact to no force: what the force gave beyond what it took, in those
  /// that gave.
  double returned() const { return returned_; }
  /// Returns what sampling and smoothing allow it to be at most.
  double bound() const { return all_bound_; }

 private:
  void end() {
    if (work_ > 0) returned_ += work_;
    all_bound_ += bound_;
    work_ = bound_ = 0;
  }
  const haptics::TouchScene& scene_;
  double late_, stiffness_ = 0, work_ = 0, bound_ = 0, returned_ = 0, all_bound_ = 0;
  glm::dvec3 last_{0.0}, force_{0.0};
  bool is_on_ = false, has_last_ = false;
};

}  // namespace trephine::app
