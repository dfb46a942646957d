// perpendicular_axes(): two directions at right angles to a given direction.
#pragma once

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace trephine::volume {

/// Returns the x or the y axis: one whose angle to a unit vector is at least 36 degrees.
inline glm::dvec3 non_parallel_axis(const glm::dvec3& direction) noexcept {
  return std::abs(direction.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
}

/// Returns two unit vectors at right angles to a unit vector, and to each other.
inline std::array<glm::dvec3, 2> perpendicular_axes(const glm::dvec3& direction) noexcept {
  const glm::dvec3 first = glm::normalize(glm::cross(direction, non_parallel_axis(direction)));
  return {first, glm::cross(direction, first)};
}

}  // namespace trephine::volume
