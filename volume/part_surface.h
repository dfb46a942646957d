// The surface of one part of a cut shape, as of a thing of its own.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "volume/solid_parts.h"

namespace trephine::volume {

/// Closed; seen from outside counter-clockwise.
struct PartSurface {
  std::vector<glm::vec3> vertices_world;  ///< mm
  std::vector<std::uint32_t> triangles;
};

/// Surface of a part as `version` has it: its surface net, with every other part out of the way. `parts` are
/// those of the version. Cost: the voxels of its box.
PartSurface part_surface(const Field& field, const Occupancy& bits,
                         const std::shared_ptr<const Version>& version, const SolidParts& parts, int part);

}  // namespace trephine::volume
