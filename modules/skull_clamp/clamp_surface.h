// Surface of a skull clamp for display: arms, rocker and pins.
#pragma once

#include <glm/vec3.hpp>
#include <memory>

#include "haptics/mesh/mesh_tree.h"
#include "modules/skull_clamp/clamp_pose.h"

namespace trephine::skull_clamp {

/// Returns the clamp's surface, world frame. `tips_world`: of its pins. The arms lead around the head on the
/// side away from `up_world`.
std::shared_ptr<const haptics::MeshTree> clamp_surface(const ClampPose& pose, const Pins& tips_world,
                                                       const glm::dvec3& up_world);

}  // namespace trephine::skull_clamp
