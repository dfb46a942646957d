// Straight paths through the bone of a scene.
#pragma once

#include "haptics/scene/touch_scene.h"

namespace trephine::workbench {

/// Returns the fraction of the path from a to b (world) at which the first solid voxel that was not removed
/// begins; negative if the path meets no such voxel.
double first_solid(const haptics::TouchScene& scene, const volume::Version& version, const glm::dvec3& a,
                   const glm::dvec3& b);
/// Returns the fraction of the path from a to b (world) at which it first crosses the interpolated surface;
/// negative without a crossing.
double first_surface(const haptics::TouchScene& scene, const volume::Version& version, const glm::dvec3& a,
                     const glm::dvec3& b);

}  // namespace trephine::workbench
