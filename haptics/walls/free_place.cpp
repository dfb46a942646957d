#include "haptics/walls/free_place.h"

#include "haptics/proxy/explicit_proxy.h"
#include "haptics/walls/smooth_walls.h"
#include "haptics/walls/solid_grid.h"

namespace trephine::haptics {

using glm::dvec3;

bool is_free(const TouchScene& scene, const TouchState& touch_state, const dvec3& position) noexcept {
  const auto count = base_shapes(scene).size();
  if (count == 0) return true;
  const bool is_round = scene.tool->radius() > 0;
  const OffsetGrid lattice(scene, touch_state);
  const VoxelGrid voxels(scene, *touch_state.version);
  const dvec3 p =
      is_round
          ? lattice.frame().volume_from_world(touch_state.version->base().frame.world_from_volume(position))
          : position;
  const glm::ivec3 v = volume::voxel_of(p);
  ProxyCounters counters;
  const ShapeSet nothing_passable;
  SmoothWalls walls(scene, touch_state, nothing_passable, counters);
  for (std::size_t s = 0; s < count; ++s) {
    if (is_round ? lattice.is_solid(s, v) : voxels.is_solid(s, v)) return false;
    if (walls.is_solid(static_cast<int>(s), p)) return false;
    if (is_behind_triangles(scene, touch_state, s, position)) return false;
  }
  return true;
}

}  // namespace trephine::haptics
