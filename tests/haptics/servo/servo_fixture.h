// Options of small phantoms, rotations, and servo scenes of one hand, for servo tests.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "apps/bench/scenes/scenes.h"
#include "haptics/servo/servo_scene.h"

namespace trephine::haptics {

inline data_tools::PhantomOptions phantom_options(int size) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(size);
  o.psf_sigma_voxels = 1;
  return o;
}

/// Returns the rotation about the vector `about`. The angle (rad) is the length of the vector.
inline glm::dquat rotation_of(const glm::dvec3& about) {
  const double angle = glm::length(about);
  if (angle == 0) return {1, 0, 0, 0};
  const glm::dvec3 v = std::sin(0.5 * angle) / angle * about;
  return {std::cos(0.5 * angle), v.x, v.y, v.z};
}

inline std::shared_ptr<const ServoScene> servo_scene_of(const TouchScene& scene, const ProxyMethod& method) {
  return std::make_shared<ServoScene>(
      scene_for_one(scene, method, std::make_shared<volume::Version>(scene.base)));
}

}  // namespace trephine::haptics
