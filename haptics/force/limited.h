// Limits of forces.
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace trephine::haptics {

/// Returns the vector with its length limited to `limit`.
inline glm::dvec3 limited(const glm::dvec3& v, double limit) noexcept {
  const double size = glm::length(v);
  return size > limit ? v * (limit / size) : v;
}

}  // namespace trephine::haptics
