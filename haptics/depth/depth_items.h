// Depth images of what a scene holds.
#pragma once

#include "haptics/depth/depth_cube.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::haptics::depth {

struct ItemPixels {
  double of_models = 0.2;   ///< mm
  double of_volumes = 0.2;  ///< mm; as many rays a voxel as that takes
};

/// Makes the images of each item, untouched; models in their own frames. Error: a model that moves, is not
/// closed, or is too large for pixels so fine.
volume::Result<std::vector<DepthCube>> cubes_of(const TouchScene& scene, const ItemPixels& pixels);

}  // namespace trephine::haptics::depth
