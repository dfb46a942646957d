// Measures on a surface: size of the part within an outline, and of a separate part.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "haptics/mesh/surface_line.h"

namespace trephine::measurement {

/// mm2 of the surface within a closed line on it, seen along the line's own plane. `places`: of the line, on
/// the surface. Nothing: the surface turns away within it.
std::optional<double> area_within(const haptics::Surface& surface,
                                  std::span<const haptics::Surface::Place> places,
                                  const std::vector<glm::dvec3>& outline);

/// The part of a surface to which a triangle belongs.
struct MarkedPart {
  double area = 0, volume = 0;  ///< mm2, mm3
  double farthest = 0;          ///< mm, of its corners from a place
};
MarkedPart part_of(const haptics::Surface& surface, std::uint32_t triangle, const glm::dvec3& place);

}  // namespace trephine::measurement
