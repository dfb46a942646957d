// Swept shape in single precision: a ball along its way, or a body at some places.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/removal.h"

namespace trephine::volume {

/// Common data of one call to RemovalEditor::remove().
struct SweptShape : SweepShape {
  /// Places of a body that are swept at once.
  static constexpr int k_most_stamps = 32;

  glm::dvec3 start_world;
  bool continues;
  int n;  ///< points along a cell's edge

  SweptShape(const Sweep& s, const Version& version);
  /// One part of a body's way: at shares `first` to `last` of it, by steps of one in `count`.
  SweptShape(const ToolSweep& s, int first, int last, int count, const Version& version);

  /// Prepares a brick whose first sample is at `corner`, mm from the start; `middle` of its samples.
  void sweep_brick(const RemovalKernels& kernels, const glm::vec3& corner, const glm::vec3& middle,
                   const float* old, BrickSweep& out) const;
  /// Mask of a cell of the brick that was swept last, around `at`.
  void sample(const RemovalKernels& kernels, const CellPoints& points, const glm::vec3& at, bool is_past_end,
              std::uint64_t* words) const;

  static float dot(const glm::vec3& v, const float* w) { return v.x * w[0] + v.y * w[1] + v.z * w[2]; }
  float projection(const glm::vec3& w) const { return dot(w, along); }
  /// Half the extent of a brick's samples along a unit direction.
  float brick_extent(const glm::vec3& direction) const {
    constexpr float k_half = 0.5f * (k_brick - 1);
    return 1.0001f * k_half *
           (std::abs(dot(direction, ax)) + std::abs(dot(direction, ay)) + std::abs(dot(direction, az)));
  }
  float brick_extent_along() const { return brick_extent({along[0], along[1], along[2]}); }
  /// Is nothing to do in the brick whose middle is at w? It lies beyond the band, by the plane through the
  /// nearest point of the sweep's axis, or wholly behind a continued sweep.
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
  /// Data that both share.
  SweptShape(const glm::dvec3& start, bool goes_on, double smallest_radius, const Version& version);
  void set_body(const ToolBody& b);
  /// Is a brick whose middle is at q from a ball's beyond the band?
  bool is_beyond(const glm::vec3& q, float ball) const {
    const float far = std::sqrt(glm::dot(q, q));
    return far > 0 && far - brick_extent(q / far) > ball + allowance + band;
  }
  bool misses_brick(const BodyShape::Stamp& stamp, const glm::vec3& w) const {
    const glm::vec3 at(stamp.at[0], stamp.at[1], stamp.at[2]),
        axis(stamp.axis[0], stamp.axis[1], stamp.axis[2]);
    return is_beyond(w - at - body_middle_ * axis, body_reach_);
  }

  BodyShape body_{};
  std::array<BodyShape::Stamp, k_most_stamps> stamps_;  ///< of a body
  int stamp_count_ = 0;                                 ///< 0: a ball's way
  /// Those that reach the brick that was swept last.
  mutable std::array<BodyShape::Stamp, k_most_stamps> near_;
  mutable int near_count_ = 0;
  float body_middle_ = 0, body_reach_ = 0;  ///< of the ball around the body
};

}  // namespace trephine::volume
