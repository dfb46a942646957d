// Wrench: force and torque that a device renders.
#pragma once

#include <glm/vec3.hpp>

namespace trephine::haptics {

/// Force and torque in the world frame, at the position of the pose.
struct Wrench {
  glm::dvec3 force_world{0.0};   ///< N
  glm::dvec3 torque_world{0.0};  ///< N mm

  Wrench() = default;
  Wrench(const glm::dvec3& force, const glm::dvec3& torque = glm::dvec3(0))
      : force_world(force), torque_world(torque) {}
  bool is_zero() const noexcept { return force_world == glm::dvec3(0) && torque_world == glm::dvec3(0); }
};

}  // namespace trephine::haptics
