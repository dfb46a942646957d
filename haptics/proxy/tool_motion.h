// Twist: small rigid motion of a tool, as the solvers of tools with six degrees of freedom use it.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::haptics {

/// A motion of the tool: translation (mm) and rotation about its position.
struct Twist {
  glm::dvec3 translation{0.0}, rotation{0.0};
  friend Twist operator*(double share, const Twist& t) noexcept {
    return {share * t.translation, share * t.rotation};
  }
};

// Rotations are vectors as turn_between() returns them: axis times 2 sin(angle / 2). The functions use no
// trigonometric functions, so that results are identical, to the bit, on every machine.

/// Returns the rotated orientation. The angle is smaller than requested if the rotation is large.
inline glm::dquat turned(const glm::dquat& q, const glm::dvec3& rotation) noexcept {
  return glm::normalize(glm::dquat(1, 0.5 * rotation.x, 0.5 * rotation.y, 0.5 * rotation.z) * q);
}
inline Placement moved(const Placement& tool, const Twist& by) noexcept {
  return {tool.position_world + by.translation, turned(tool.rotation, by.rotation)};
}

/// Returns the motion from a tool to the hand.
inline Twist twist_between(const Placement& tool, const Placement& hand) noexcept {
  return {hand.position_world - tool.position_world, turn_between(tool.rotation, hand.rotation)};
}

/// Returns the length (mm) of one spring with the energy of all springs between tool and hand.
/// `gyration_square`: ratio (mm2) of rotational to translational stiffness. The energy of a rotation by a is
/// proportional to 4 (1 - cos(a/2)), whose derivative is turn_between().
inline double length_of_springs(const Placement& tool, const Placement& hand,
                                double gyration_square) noexcept {
  const auto [translation, rotation] = twist_between(tool, hand);
  const double square = glm::dot(rotation, rotation),
               cosine = std::sqrt(std::max(0.0, 1 - 0.25 * square));  // of half the angle
  return std::sqrt(glm::dot(translation, translation) + 2 * gyration_square * square / (1 + cosine));
}

}  // namespace trephine::haptics
