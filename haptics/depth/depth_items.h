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

/// Draws the images of each item: volumes as they are before any cut, models in their own frames. Error: a
/// model moves or is not closed, or an item is too large for its images.
Result<std::vector<DepthCube>> cubes_of(const TouchScene& scene, const ItemPixels& pixels);

}  // namespace trephine::haptics::depth
