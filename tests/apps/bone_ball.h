// A ball of bone in air, for tests of positions in pictures.
#pragma once

#include <glm/geometric.hpp>
#include <memory>

#include "apps/bench/scenes/scenes.h"

namespace trephine::view {

/// Returns a scene of 48 x 48 x 48 voxels of 1 mm with a ball of bone of radius 4 mm around `middle` (mm).
inline std::unique_ptr<haptics::TouchScene> bone_ball(const glm::dvec3& middle) {
  volume::Volume base = volume::make_volume(glm::ivec3(48), volume::Frame(), false).value();
  base.is_hounsfield = true;
  for (int z = 0; z < 48; ++z)
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 48; ++x)
        base.voxels[base.index(x, y, z)] = glm::length(glm::dvec3(x, y, z) - middle) <= 4 ? 1000 : -1000;
  return std::make_unique<haptics::TouchScene>(scenes::scene_of(std::move(base), {}));
}

}  // namespace trephine::view
