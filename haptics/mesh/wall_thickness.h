// WallFacts: thickness of the walls of a closed surface, as needed for 3-D printing.
#pragma once

#include "haptics/mesh/mesh_tree.h"

namespace trephine::haptics {

struct WallFacts {
  std::size_t shells = 0;  ///< number of connected surfaces
  double thin_share = 0;   ///< 0 to 1, share of the surface with a wall thinner than the limit
  /// Thinnest wall, mm, and its position. The thinnest thousandth of the surface is left out, since the wall
  /// of a sharp edge has no least thickness.
  double thinnest = 0;
  glm::dvec3 thinnest_at{0.0};
};
/// Measures the wall below each triangle: from its middle along the inward normal to the first triangle that
/// this ray hits from behind. Requires a closed surface; triangles without such a hit are left out. `limit`:
/// mm. Cost: a ray cast per triangle, on all cores.
WallFacts walls_of(const MeshTree& surface, double limit);

}  // namespace trephine::haptics
