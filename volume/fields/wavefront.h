// Wavefront: finds the nearest sampled surface point for each lattice point near the surface.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "volume/fields/smooth_surface.h"
#include "volume/scan/frame.h"

namespace trephine::volume {

/// Box of lattice points, with distances of other points to it.
struct LatticeBox {
  glm::dvec3 low, high;
  double shortest_step;  ///< from shortest_step(), mm
  /// Lower bound of the distance (mm) of a lattice position to the box; exact on a lattice with equal
  /// orthogonal steps.
  double distance(const glm::dvec3& at) const {
    return shortest_step * glm::length(glm::max(glm::max(low - at, at - high), glm::dvec3(0)));
  }
};

/// Lower bound of the length (mm) of a lattice step in any direction: |A e| >= |e| / sqrt(|(A^T A)^-1|).
inline double shortest_step(const Frame& lattice) {
  const glm::dmat3 inverse = glm::inverse(glm::transpose(lattice.axes()) * lattice.axes());
  double norm = 0;
  for (int a = 0; a < 3; ++a)
    norm = std::max(norm, std::abs(inverse[a].x) + std::abs(inverse[a].y) + std::abs(inverse[a].z));
  return 1 / std::sqrt(norm);
}

/// Propagates sampled surface points through the lattice points of a box, nearest first, with the distances
/// to the surface points themselves.
class Wavefront {
 public:
  static constexpr std::uint32_t k_none = ~0u;  ///< no surface point

  /// Prepares the lattice points of `target` and `halo` more on each side; borrows all arguments but `halo`.
  Wavefront(const Frame& lattice, const LatticeBox& target, const glm::ivec3& halo,
            const std::vector<SurfacePoint>& points)
      : lattice_(lattice),
        target_(target),
        low_(glm::ivec3(target.low) - halo),
        size_(glm::ivec3(target.high) + halo - low_ + 1),
        points_(points) {
    const std::size_t count = static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                              static_cast<std::size_t>(size_.z);
    nearest_.assign(count, k_none);
    square_.assign(count, 1e30f);
    propagated_square_.assign(count, -1);
  }

  /// Propagates to distances of `reach` (mm) outside matter, and of `inner` (mm) inside. `step`: of the
  /// lattice, mm. `is_matter(v)`: true if lattice point v is solid.
  template <class IsMatter>
  void spread(double step, double reach, double inner, const IsMatter& is_matter) {
    const float limit = static_cast<float>(reach * reach), deepest = static_cast<float>(inner * inner);
    half_step_ = static_cast<float>(0.5 * step), max_square_ = limit;
    buckets_.resize(static_cast<std::size_t>(reach / step * 2) + 3);
    // Starts from the corners of each point's cell, and of both adjacent cells for a point on a lattice plane
    // (as on a flat face or the grid's border), since the cell on one side may be solid.
    constexpr double k_on_plane = 0.05;
    for (std::uint32_t p = 0; p < points_.size(); ++p) {
      const glm::dvec3 at = lattice_.volume_from_world(glm::dvec3(points_[p].at_world)) - glm::dvec3(low_);
      const glm::ivec3 first(glm::floor(at - k_on_plane)), last = glm::ivec3(glm::floor(at + k_on_plane)) + 1;
      for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
          for (int x = first.x; x <= last.x; ++x)
            if (contains({x, y, z})) update(index({x, y, z}), world_of({x, y, z}), p);
    }
    // Offsets of the 26 neighbours, in the world and in memory.
    std::array<glm::vec3, 27> offset_world;
    std::array<std::ptrdiff_t, 27> stride;
    for (std::size_t n = 0; n < 27; ++n) {
      offset_world[n] = glm::vec3(lattice_.vector_world_from_volume(glm::dvec3(neighbour(n))));
      stride[n] = static_cast<std::ptrdiff_t>(index(glm::ivec3(1) + neighbour(n))) -
                  static_cast<std::ptrdiff_t>(index(glm::ivec3(1)));
    }
    for (; bucket_ < buckets_.size(); ++bucket_)
      for (std::size_t k = 0; k < buckets_[bucket_].size(); ++k) {
        const std::size_t i = buckets_[bucket_][k];
        if (propagated_square_[i] == square_[i]) continue;  // already propagated this point
        propagated_square_[i] = square_[i];
        const glm::ivec3 c = position(i);
        // Skips lattice points too far away to affect the target.
        if (std::sqrt(static_cast<double>(square_[i])) + target_.distance(glm::dvec3(low_ + c)) > reach)
          continue;
        // Propagates outward, since the path to the nearest point never leads through the solid; inward only
        // to the depth `inner`, at which tools of a small radius need distances.
        if (!(square_[i] < deepest) && is_matter(low_ + c)) continue;
        const std::uint32_t p = nearest_[i];
        const glm::vec3 at = world_of(c);
        const bool is_inner =
            c.x > 0 && c.y > 0 && c.z > 0 && c.x + 1 < size_.x && c.y + 1 < size_.y && c.z + 1 < size_.z;
        for (std::size_t n = 0; n < 27; ++n)
          if (n != 13 && (is_inner || contains(c + neighbour(n))))
            update(static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + stride[n]), at + offset_world[n],
                   p);
      }
  }

  /// Index of the surface point nearest to lattice point v; k_none if no point was propagated to v.
  std::uint32_t nearest(const glm::ivec3& v) const { return nearest_[index(v - low_)]; }
  /// Distance (mm) of lattice point v to that surface point.
  double distance(const glm::ivec3& v) const {
    return std::sqrt(static_cast<double>(square_[index(v - low_)]));
  }

 private:
  static glm::ivec3 neighbour(std::size_t n) {
    const int i = static_cast<int>(n);
    return {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
  }
  bool contains(const glm::ivec3& c) const {
    return c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x < size_.x && c.y < size_.y && c.z < size_.z;
  }
  std::size_t index(const glm::ivec3& c) const {
    return static_cast<std::size_t>(c.x) +
           static_cast<std::size_t>(size_.x) *
               (static_cast<std::size_t>(c.y) +
                static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(c.z));
  }
  glm::ivec3 position(std::size_t i) const {
    const std::size_t x = static_cast<std::size_t>(size_.x), y = static_cast<std::size_t>(size_.y);
    return {static_cast<int>(i % x), static_cast<int>(i / x % y), static_cast<int>(i / (x * y))};
  }
  glm::vec3 world_of(const glm::ivec3& c) const {
    return glm::vec3(lattice_.world_from_volume(glm::dvec3(low_ + c)));
  }
  /// Sets `point` as the nearest of lattice point i (inside the box, at `at_world`) if it is nearer.
  void update(std::size_t i, const glm::vec3& at_world, std::uint32_t point) {
    const glm::vec3 d = at_world - points_[point].at_world;
    const float s = glm::dot(d, d);
    if (s >= square_[i] || s > max_square_) return;
    square_[i] = s;
    nearest_[i] = point;
    // Avoids processed buckets: a surface point may be nearer to a neighbour than to the lattice point that
    // propagates it.
    const std::size_t bucket = std::max(bucket_, static_cast<std::size_t>(std::sqrt(s) / half_step_));
    buckets_[std::min(bucket, buckets_.size() - 1)].push_back(static_cast<std::uint32_t>(i));
  }

  const Frame& lattice_;
  const LatticeBox& target_;
  glm::ivec3 low_, size_;
  const std::vector<SurfacePoint>& points_;
  std::vector<std::uint32_t> nearest_;
  std::vector<float> square_;             ///< squared distance, mm^2
  std::vector<float> propagated_square_;  ///< squared distance at the last propagation from the lattice point
  std::vector<std::vector<std::uint32_t>> buckets_;  ///< lattice points by distance, in steps of half_step_
  std::size_t bucket_ = 0;                           ///< current bucket
  float half_step_ = 0, max_square_ = 0;             ///< mm, mm^2
};

}  // namespace trephine::volume
