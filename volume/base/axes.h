// axis_aside(): a coordinate axis that is not parallel to a direction.
#pragma once

#include <cmath>
#include <glm/vec3.hpp>

namespace trephine::volume {

/// Returns the x or the y axis, whose angle to a unit vector is at least 37 degrees.
inline glm::dvec3 axis_aside(const glm::dvec3& direction) noexcept {
  return std::abs(direction.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
}

}  // namespace trephine::volume
