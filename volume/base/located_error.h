// LocatedError: the reason why a job has no result, and the position in the anatomy to which the reason
// refers.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace trephine {

/// An error of a computation on the anatomy.
struct LocatedError {
  std::string reason;              ///< one clause: "the outline crosses itself"
  glm::dvec3 position_world{0.0};  ///< mm
};

/// Success without a value, or a LocatedError.
using LocatedStatus = std::optional<LocatedError>;

/// Returns the reason of an error; empty for a success.
inline std::string_view reason_of(const LocatedStatus& status) noexcept {
  return status ? std::string_view(status->reason) : std::string_view();
}

}  // namespace trephine
