// cubes_of(): depth images of the items of a scene.
#pragma once

#include "haptics/depth/depth_cube.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::haptics::depth {

/// Sizes of pixels.
struct ItemPixels {
  double of_models = 0.2;   ///< mm
  double of_volumes = 0.2;  ///< mm, at most; sets the number of rays per voxel
};

/// Draws the images of each item before any cut; models in their own frames. Error: a model moves, is not
/// closed, or is too large for this pixel size.
Result<std::vector<DepthCube>> cubes_of(const TouchScene& scene, const ItemPixels& pixels);

}  // namespace trephine::haptics::depth
