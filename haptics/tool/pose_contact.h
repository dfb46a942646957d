// PoseContact: force and torque of contact on a whole tool at a given pose.
#pragma once

#include <glm/geometric.hpp>

#include "haptics/device/wrench.h"
#include "haptics/scene/touch_scene.h"
#include "haptics/tool/point_shell.h"

namespace trephine::haptics {

/// Sum of the forces on a tool's points.
struct PoseForce {
  Wrench on_tool;                 ///< torque about the position of the tool
  glm::dvec3 perpendicular{0.0};  ///< N, component of the force that is perpendicular to the torque
  int points = 0;                 ///< points that push
  int interior = 0;               ///< points so deep in matter that they do not push
  int tests = 0;                  ///< points and nodes that were tested

  void set(const glm::dvec3& force, const glm::dvec3& torque) noexcept {
    on_tool = Wrench(force, torque);
    const double size = glm::length(torque);
    if (!(size > 0)) return;
    const glm::dvec3 axis = torque / size;
    perpendicular = force - glm::dot(axis, force) * axis;
  }
};

/// A method that finds contact at a pose, but does not move the tool.
class PoseContact {
 public:
  virtual ~PoseContact() = default;
  virtual PoseForce contact(const Placement& tool) const noexcept = 0;
  virtual const PointShell& shell() const noexcept = 0;
};

}  // namespace trephine::haptics
