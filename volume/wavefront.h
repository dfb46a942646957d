// For each point of a lattice near a surface, the nearest of the surface's sampled points.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "volume/frame.h"
#include "volume/smooth_surface.h"

namespace trephine::volume {

/// A box of lattice points, and how far from it others are.
struct LatticeBox {
  glm::dvec3 low, high;
  double shortest_step;  ///< mm, of all directions
  /// mm; on sheared lattices no more than that.
  double distance(const glm::dvec3& at) const {
    return shortest_step * glm::length(glm::max(glm::max(low - at, at - high), glm::dvec3(0)));
  }
};

/// |A e| >= |e| / sqrt(|(A^T A)^-1|): no step in the world is shorter.
inline double shortest_step(const Frame& lattice) {
  const glm::dmat3 inverse = glm::inverse(glm::transpose(lattice.axes()) * lattice.axes());
  double norm = 0;
  for (int a = 0; a < 3; ++a)
    norm = std::max(norm, std::abs(inverse[a].x) + std::abs(inverse[a].y) + std::abs(inverse[a].z));
  return 1 / std::sqrt(norm);
}

/// The points of a surface that are nearest to the lattice points of a box. They spread from point to point
/// outward, nearest first: a wavefront with distances to the surface itself.
class Wavefront {
 public:
  static constexpr std::uint32_t k_none = ~0u;

  /// Prepares the lattice points of `wanted` and `halo` more on each side; borrows the points.
  Wavefront(const Frame& lattice, const LatticeBox& wanted, const glm::ivec3& halo,
            const std::vector<SurfacePoint>& points)
      : lattice_(lattice),
        wanted_(wanted),
        low_(glm::ivec3(wanted.low) - halo),
        size_(glm::ivec3(wanted.high) + halo - low_ + 1),
        points_(points) {
    const std::size_t cells = static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                              static_cast<std::size_t>(size_.z);
    nearest_.assign(cells, k_none);
    square_.assign(cells, 1e30f);
    burnt_.assign(cells, -1);
  }

  /// As far as `reach` (mm), through points that are no matter, and `inner` mm into it. `is_matter`: of a
  /// lattice point.
  template <class IsMatter>
  void spread(double step, double reach, double inner, const IsMatter& is_matter) {
    const float limit = static_cast<float>(reach * reach), deepest = static_cast<float>(inner * inner);
    half_step_ = static_cast<float>(0.5 * step), most_ = limit;
    buckets_.resize(static_cast<std::size_t>(reach / step * 2) + 3);
    // From each point to the corners of its cell, and of both where it lies on a plane of the lattice, as a
    // flat face or the grid's border may: on one side alone it might be buried.
    constexpr double k_on_plane = 0.05;
    for (std::uint32_t p = 0; p < points_.size(); ++p) {
      const glm::dvec3 at = lattice_.volume_from_world(glm::dvec3(points_[p].at_world)) - glm::dvec3(low_);
      const glm::ivec3 first(glm::floor(at - k_on_plane)), last = glm::ivec3(glm::floor(at + k_on_plane)) + 1;
      for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
          for (int x = first.x; x <= last.x; ++x)
            if (contains({x, y, z})) offer(index({x, y, z}), world_of({x, y, z}), p);
    }
    // The 26 neighbours: how far in memory and in the world.
    std::array<glm::vec3, 27> away;
    std::array<std::ptrdiff_t, 27> jump;
    for (std::size_t n = 0; n < 27; ++n) {
      away[n] = glm::vec3(lattice_.vector_world_from_volume(glm::dvec3(neighbour(n))));
      jump[n] = static_cast<std::ptrdiff_t>(index(glm::ivec3(1) + neighbour(n))) -
                static_cast<std::ptrdiff_t>(index(glm::ivec3(1)));
    }
    for (; burning_ < buckets_.size(); ++burning_)
      for (std::size_t k = 0; k < buckets_[burning_].size(); ++k) {
        const std::size_t i = buckets_[burning_][k];
        if (burnt_[i] == square_[i]) continue;  // another point came here first, and was nearer
        burnt_[i] = square_[i];
        const glm::ivec3 c = place(i);
        // Too far to be of use where it is wanted.
        if (std::sqrt(static_cast<double>(square_[i])) + wanted_.distance(glm::dvec3(low_ + c)) > reach)
          continue;
        // Outward: the way to the nearest point never leads through the solid. Inward only as deep as a
        // small radius needs samples there.
        if (!(square_[i] < deepest) && is_matter(low_ + c)) continue;
        const std::uint32_t p = nearest_[i];
        const glm::vec3 at = world_of(c);
        const bool is_inner =
            c.x > 0 && c.y > 0 && c.z > 0 && c.x + 1 < size_.x && c.y + 1 < size_.y && c.z + 1 < size_.z;
        for (std::size_t n = 0; n < 27; ++n)
          if (n != 13 && (is_inner || contains(c + neighbour(n))))
            offer(static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + jump[n]), at + away[n], p);
      }
  }

  /// The nearest point's number at lattice point v; k_none where none came.
  std::uint32_t nearest(const glm::ivec3& v) const { return nearest_[index(v - low_)]; }
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
  glm::ivec3 place(std::size_t i) const {
    const std::size_t x = static_cast<std::size_t>(size_.x), y = static_cast<std::size_t>(size_.y);
    return {static_cast<int>(i % x), static_cast<int>(i / x % y), static_cast<int>(i / (x * y))};
  }
  glm::vec3 world_of(const glm::ivec3& c) const {
    return glm::vec3(lattice_.world_from_volume(glm::dvec3(low_ + c)));
  }
  /// Point number `point` to cell i, which is inside the box and at `at`.
  void offer(std::size_t i, const glm::vec3& at, std::uint32_t point) {
    const glm::vec3 d = at - points_[point].at_world;
    const float s = glm::dot(d, d);
    if (s >= square_[i] || s > most_) return;
    square_[i] = s;
    nearest_[i] = point;
    // Never into a bucket that has burnt: a point may be nearer to a neighbour than to the cell it came from.
    const std::size_t bucket = std::max(burning_, static_cast<std::size_t>(std::sqrt(s) / half_step_));
    buckets_[std::min(bucket, buckets_.size() - 1)].push_back(static_cast<std::uint32_t>(i));
  }

  const Frame& lattice_;
  const LatticeBox& wanted_;
  glm::ivec3 low_, size_;
  const std::vector<SurfacePoint>& points_;
  std::vector<std::uint32_t> nearest_;
  std::vector<float> square_;  ///< of the distance, mm
  std::vector<float> burnt_;   ///< what that was when the cell handed its point on
  std::vector<std::vector<std::uint32_t>> buckets_;
  std::size_t burning_ = 0;
  float half_step_ = 0, most_ = 0;
};

}  // namespace trephine::volume
