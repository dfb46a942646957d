// Small scenes for servo tests.
#pragma once

#include "apps/bench/scenes/scenes.h"
#include "haptics/servo/servo_scene.h"

namespace trephine::haptics {

inline data_tools::PhantomOptions grid(int size) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(size);
  o.psf_sigma_voxels = 1;
  return o;
}

inline std::shared_ptr<const ServoScene> seen_by(const TouchScene& scene, const ProxyMethod& method) {
  return std::make_shared<ServoScene>(
      scene_for_one(scene, method, std::make_shared<volume::Version>(scene.base)));
}

}  // namespace trephine::haptics
