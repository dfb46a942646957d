// Surface of a skull clamp for display: arms, rocker and pins.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "haptics/mesh/mesh_tree.h"
#include "modules/skull_clamp/clamp_pose.h"

namespace trephine::skull_clamp {

/// Straight part of the arms or of the rocker: a cylinder, world frame, mm.
struct ClampRod {
  glm::dvec3 from{0.0}, to{0.0};
  double radius = 0;
};
/// Returns the rods of the rocker and of the arms of a clamp. `tips_world`: tips of its pins, mm. The arms
/// form half an ellipse around the head, on the side away from the unit vector `up_world`. `arm_depth`:
/// semi-axis of the ellipse on that side, mm.
std::vector<ClampRod> clamp_rods(const ClampPose& pose, const Pins& tips_world, const glm::dvec3& up_world,
                                 double arm_depth);
/// Returns the surface of a clamp, world frame: its rods and pins. The parameters are those of clamp_rods().
std::shared_ptr<const haptics::MeshTree> clamp_surface(const ClampPose& pose, const Pins& tips_world,
                                                       const glm::dvec3& up_world,
                                                       double arm_depth = ClampSize().arm_depth);

}  // namespace trephine::skull_clamp
