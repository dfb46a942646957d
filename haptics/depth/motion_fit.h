// The rigid motion that places of a surface come nearest to.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "haptics/depth/depth_source.h"

namespace trephine::haptics::depth {

inline constexpr double k_around = 5;   // mm of the touch: what says how it moves there
inline constexpr double k_touched = 3;  // mm of it: where it must move so

/// A place of the surface, now and when the next set is due, and how much it says about the motion.
struct MovingPlace {
  glm::dvec3 now, next;
  double weight;
};
/// Weight of a place by its distance to the touch.
inline double weight_of(const glm::dvec3& off) noexcept {
  const double near = 1 / (1 + glm::dot(off, off));
  return near * near;
}

/// Fits p -> q with q - p = h x (q + p) about the pivot, exact if the motion is rigid (Cayley): least
/// squares of that, which is linear.
inline DepthMotion motion_of(const std::vector<MovingPlace>& places) {
  using glm::dvec3;
  DepthMotion motion;
  double total = 0;
  dvec3 now(0), next(0);
  for (const MovingPlace& s : places) total += s.weight, now += s.weight * s.now, next += s.weight * s.next;
  if (!(total > 0)) return motion;
  motion.pivot = now / total;
  motion.travel = (next - now) / total;
  glm::dmat3 square(0);
  dvec3 right(0);
  double size = 0;
  for (const MovingPlace& s : places) {
    const dvec3 r = (s.now - motion.pivot) + (s.next - motion.pivot - motion.travel);
    const dvec3 d = (s.next - s.now) - motion.travel;
    square += s.weight * (glm::dot(r, r) * glm::dmat3(1) - glm::outerProduct(r, r));
    right += s.weight * glm::cross(r, d);
    size += s.weight * glm::dot(r, r);
  }
  // Places along one line do not say how they turn about it.
  square += 1e-10 * size * glm::dmat3(1);
  if (glm::determinant(square) > 0) motion.turn = glm::inverse(square) * right;
  return motion;
}

/// mm that places near the touch are off where the motion puts them.
inline double slack_of(const DepthMotion& motion, const std::vector<MovingPlace>& places,
                       const glm::dvec3& touch) {
  const Placement then = motion.after(1);
  double slack = 0;
  for (const MovingPlace& s : places)
    if (glm::length(s.now - touch) < k_touched)
      slack = std::max(slack, glm::length(then.world_from_local(s.now) - s.next));
  return slack;
}

}  // namespace trephine::haptics::depth
