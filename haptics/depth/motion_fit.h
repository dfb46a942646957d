// motion_of(): rigid motion that best fits moving points of a surface.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "haptics/depth/depth_source.h"

namespace trephine::haptics::depth {

inline constexpr double k_around = 5;  // mm around the touch: points that determine the motion
inline constexpr double k_near_touch_mm =
    3;  // mm around the touch: points at which the motion must be accurate

/// A point of the surface at the time of a set and when the next set is due, mm, and its weight in the fit.
struct MovingPointPair {
  glm::dvec3 now, next;
  double weight;
};
/// Returns the weight of a point by its offset (mm) from the touch.
inline double weight_of(const glm::dvec3& off) noexcept {
  const double near = 1 / (1 + glm::dot(off, off));
  return near * near;
}

/// Returns the motion that fits the pairs p -> q by linear least squares of q - p = h x (q + p), with p
/// relative to the pivot, and q relative to the moved pivot (Cayley). It is exact if the motion is rigid.
inline DepthMotion motion_of(const std::vector<MovingPointPair>& pairs) {
  using glm::dvec3;
  DepthMotion motion;
  double total = 0;
  dvec3 now(0), next(0);
  for (const MovingPointPair& s : pairs)
    total += s.weight, now += s.weight * s.now, next += s.weight * s.next;
  if (!(total > 0)) return motion;
  motion.pivot = now / total;
  motion.travel = (next - now) / total;
  glm::dmat3 square(0);
  dvec3 right(0);
  double size = 0;
  for (const MovingPointPair& s : pairs) {
    const dvec3 r = (s.now - motion.pivot) + (s.next - motion.pivot - motion.travel);
    const dvec3 d = (s.next - s.now) - motion.travel;
    square += s.weight * (glm::dot(r, r) * glm::dmat3(1) - glm::outerProduct(r, r));
    right += s.weight * glm::cross(r, d);
    size += s.weight * glm::dot(r, r);
  }
  // Points along one line do not determine the rotation about it.
  square += 1e-10 * size * glm::dmat3(1);
  if (glm::determinant(square) > 0) motion.turn = glm::inverse(square) * right;
  return motion;
}

/// Returns the largest error (mm) of the motion at points near the touch.
inline double slack_of(const DepthMotion& motion, const std::vector<MovingPointPair>& pairs,
                       const glm::dvec3& touch) {
  const Placement then = motion.after(1);
  double slack = 0;
  for (const MovingPointPair& s : pairs)
    if (glm::length(s.now - touch) < k_near_touch_mm)
      slack = std::max(slack, glm::length(then.world_from_local(s.now) - s.next));
  return slack;
}

}  // namespace trephine::haptics::depth
