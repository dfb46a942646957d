// ScrewModel: closed surface of a pedicle screw, correctly placed or misplaced.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "volume/base/error.h"

namespace trephine::data_tools {

/// Position of a screw: entry of its shaft into bone, and its tip, mm (LPS).
struct ScrewPosition {
  glm::dvec3 entry_world{0.0}, tip_world{0.0};
  double diameter = 6;  ///< of the shaft, mm
};
/// Parses "EX,EY,EZ:TX,TY,TZ:D" (mm). Error if it is invalid, the screw is shorter than twice its diameter,
/// or the diameter is not 1 to 15 mm.
Result<ScrewPosition> parse_screw(std::string_view text);

struct ScrewModel {
  std::vector<glm::dvec3> vertices_world;  ///< mm (LPS)
  std::vector<std::uint32_t> triangles;    ///< counter-clockwise from outside
};
/// Length of a screw's conical tip, in diameters.
inline constexpr double k_screw_tip = 1;
/// Returns a shaft with a pointed tip, and a head of 1.5 diameters that extends 6 mm outside the entry.
ScrewModel screw_model(const ScrewPosition& screw);
/// Returns the position of a screw from the vertices of its screw_model(), as a session stores them; empty
/// for any other model.
std::optional<ScrewPosition> recognized_screw(std::span<const glm::dvec3> vertices_world);

}  // namespace trephine::data_tools
