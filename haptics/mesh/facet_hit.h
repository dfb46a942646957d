// FacetHit: first crossing of a motion with a facet of a mesh or of a surface of voxels.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "haptics/scene/touch_scene.h"

namespace trephine::haptics {

/// First crossing of a motion with a facet that blocks it.
struct FacetHit {
  double t = 1;                  ///< parameter of the motion, 0 to 1
  glm::dvec3 normal_world{0.0};  ///< unit, toward the side from which the motion came
  int shape = -1;
  Side side = Side::none;
  std::uint32_t triangle = 0;  ///< index in the MeshTree; only for a mesh
};

}  // namespace trephine::haptics
