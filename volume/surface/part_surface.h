// PartSurface: closed surface of one connected part of a cut shape.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "volume/cuts/solid_parts.h"

namespace trephine::volume {

/// Closed mesh; triangles are counter-clockwise when viewed from outside.
struct PartSurface {
  std::vector<glm::vec3> vertices_world;  ///< mm
  std::vector<std::uint32_t> triangles;
};

/// Returns the surface net of a part after removal of all other parts. `parts`: those of `version`. Cost:
/// proportional to the voxels of the part's box.
PartSurface part_surface(const Field& field, const Occupancy& bits,
                         const std::shared_ptr<const Version>& version, const SolidParts& parts, int part);

}  // namespace trephine::volume
