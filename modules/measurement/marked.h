// Measurements on a surface: area within an outline, and size of a connected part.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "haptics/mesh/surface_line.h"

namespace trephine::measurement {

/// Returns the area of the surface within a closed line on it, mm2. The inside is found by projection onto
/// the plane of the line. `points`: the points that the line connects. Returns nullopt if a triangle that is
/// wholly within the line is nearly perpendicular to that plane or faces away from it.
std::optional<double> area_within(const haptics::Surface& surface,
                                  std::span<const haptics::Surface::Point> points,
                                  const std::vector<glm::dvec3>& outline);

/// Size of the connected part of a surface to which a triangle belongs.
struct MarkedPart {
  double area = 0, volume = 0;  ///< mm2, mm3
  double farthest = 0;          ///< mm, largest distance of a corner of the part from `position`
};
MarkedPart part_of(const haptics::Surface& surface, std::uint32_t triangle, const glm::dvec3& position);

}  // namespace trephine::measurement
