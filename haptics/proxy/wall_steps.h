// Plane, Planes: walls at a point, and steps along them toward the point nearest to the HIP.
#pragma once

#include <algorithm>
#include <array>

#include "haptics/walls/smooth_walls.h"

namespace trephine::haptics {

inline constexpr int k_max_planes = 4;        ///< walls at a point; at most three of them are active at once
inline constexpr double k_short_step = 0.02;  ///< voxels: a shorter step follows the wall to second order

/// A wall linearized at a point, in mm: a displacement p must satisfy normal . p <= distance.
struct Plane {
  Wall wall;
  bool is_frozen;     ///< the tangent plane of a wall that was left earlier in this step; without curvature
  glm::dvec3 normal;  ///< unit, world, into the solid
  double distance;    ///< mm, to the plane just before the wall; negative beyond that plane
  double steepness;   ///< length of the gradient of the wall's function, per mm
  volume::Jet jet;
};

/// Walls at one point; those beyond `count` are never read.
struct Planes {
  int count = 0;
  std::array<Plane, k_max_planes> all;

  Plane& operator[](int i) noexcept { return all[static_cast<std::size_t>(i)]; }
  const Plane& operator[](int i) const noexcept { return all[static_cast<std::size_t>(i)]; }
  void copy_from(const Planes& other) noexcept {
    count = other.count;
    for (int i = 0; i < count; ++i) (*this)[i] = other[i];
  }
};

/// Computes two unit vectors that complete a unit normal to a frame.
void tangents(const glm::dvec3& normal, glm::dvec3& u, glm::dvec3& w) noexcept;
/// Returns Newton's step to the point of one wall that is nearest to the HIP (mm, world). The tangential part
/// uses the reduced Hessian 1 + lambda (tangential second derivatives); the normal part leads to the wall.
/// `to_hip`: from the current point to the HIP, mm, world. `frame`: frame of the walls.
glm::dvec3 single_step(const volume::Frame& frame, double voxel_mm, const Plane& plane,
                       const glm::dvec3& to_hip) noexcept;
/// Returns Newton's step with several walls: the step of the first active set that violates no other wall and
/// has no negative multiplier. If all sets fail, returns a step onto one or two of the walls.
glm::dvec3 joint_step(const volume::Frame& frame, double voxel_mm, const Planes& planes,
                      const glm::dvec3& to_hip) noexcept;
/// Returns the step onto the walls along their normals, without motion along the walls.
glm::dvec3 step_to_walls(const Planes& planes) noexcept;

}  // namespace trephine::haptics
