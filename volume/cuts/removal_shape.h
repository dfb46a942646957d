// SweptShape: single-precision shape of a sweep, either a ball along a segment or a body at several poses.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/cuts/removal.h"
#include "volume/cuts/removal_kernels.h"

namespace trephine::volume {

/// The whole sweep of a ball, or up to k_max_stamps poses of a sweep of a body.
struct SweptShape : SweepShape {
  /// Largest number of poses of a body in one shape.
  static constexpr int k_max_stamps = 32;

  glm::dvec3 start_world;  ///< mm; origin of all single-precision positions
  bool continues;          ///< as Sweep::continues
  int n;                   ///< points along a cell's edge

  SweptShape(const Sweep& s, const Version& version);
  /// Poses of a body at the fractions first / count to last / count of its sweep.
  SweptShape(const ToolSweep& s, int first, int last, int count, const Version& version);

  /// Computes the sweep in one brick. `corner`, `middle`: first sample of the brick and centre of its
  /// samples, mm from the start. `old`: previous distances, or null.
  void sweep_brick(const RemovalKernels& kernels, const glm::vec3& corner, const glm::vec3& middle,
                   const float* old, BrickSweep& out) const;
  /// Computes the mask of the cell around `at` (mm from the start) in the brick last passed to sweep_brick().
  void sample(const RemovalKernels& kernels, const CellPoints& points, const glm::vec3& at, bool is_past_end,
              std::uint64_t* words) const;

  static float dot(const glm::vec3& v, const float* w) { return v.x * w[0] + v.y * w[1] + v.z * w[2]; }
  float projection(const glm::vec3& w) const { return dot(w, along); }
  /// Half the extent (mm) of a brick's samples along a unit direction.
  float brick_extent(const glm::vec3& direction) const {
    constexpr float k_half = 0.5f * (k_brick - 1);
    return 1.0001f * k_half *
           (std::abs(dot(direction, ax)) + std::abs(dot(direction, ay)) + std::abs(dot(direction, az)));
  }
  float brick_extent_along() const { return brick_extent({along[0], along[1], along[2]}); }
  /// Returns true if the sweep does not change the brick with centre w (mm from the start): the brick is
  /// beyond the band, or completely behind the start of a continued sweep. May return false for other such
  /// bricks.
  bool misses_brick(const glm::vec3& w) const {
    if (stamp_count_ > 0) {
      for (int i = 0; i < stamp_count_; ++i)
        if (!misses_brick(stamps_[static_cast<std::size_t>(i)], w)) return false;
      return true;
    }
    const float wt = projection(w);
    if (continues && length > 0 && wt < -brick_extent_along() - cell_reach) return true;
    const glm::vec3 q = w - std::clamp(wt, 0.0f, length) * glm::vec3(along[0], along[1], along[2]);
    return is_beyond(q, radius);
  }
  glm::vec3 lattice_step(float x, float y, float z) const {
    return {x * ax[0] + y * ay[0] + z * az[0], x * ax[1] + y * ay[1] + z * az[1],
            x * ax[2] + y * ay[2] + z * az[2]};
  }

 private:
  /// Sets the members common to balls and bodies.
  SweptShape(const glm::dvec3& start, bool is_continued, double smallest_radius, const Version& version);
  void set_body(const ToolBody& b);
  /// Returns true if a brick is beyond the band of a ball; q: from the ball's centre to the brick's, mm.
  bool is_beyond(const glm::vec3& q, float ball_radius) const {
    const float far = std::sqrt(glm::dot(q, q));
    return far > 0 && far - brick_extent(q / far) > ball_radius + allowance + band;
  }
  bool misses_brick(const BodyShape::Stamp& stamp, const glm::vec3& w) const {
    const glm::vec3 at(stamp.at[0], stamp.at[1], stamp.at[2]),
        axis(stamp.axis[0], stamp.axis[1], stamp.axis[2]);
    return is_beyond(w - at - body_middle_ * axis, body_reach_);
  }

  BodyShape body_{};
  std::array<BodyShape::Stamp, k_max_stamps> stamps_;  ///< poses of the body
  int stamp_count_ = 0;                                ///< 0: the shape is the sweep of a ball
  /// Stamps that reach the brick last passed to sweep_brick().
  mutable std::array<BodyShape::Stamp, k_max_stamps> near_stamps_;
  mutable int near_count_ = 0;
  float body_middle_ = 0, body_reach_ = 0;  ///< bounding ball: centre along the axis, and radius, mm
};

}  // namespace trephine::volume
