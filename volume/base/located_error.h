// LocatedError: the reason why a job has no result, and its position in the anatomy.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>

namespace trephine {

/// An error of a computation on the anatomy.
struct LocatedError {
  std::string reason;              ///< one clause: "the outline crosses itself"
  glm::dvec3 position_world{0.0};  ///< mm
};

/// Success without a value, or a LocatedError.
using LocatedStatus = std::optional<LocatedError>;

}  // namespace trephine
