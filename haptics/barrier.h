// Walks the proxy's way through the voxels until a touchable surface stops it.
#pragma once

#include <algorithm>

#include "haptics/proxy_method.h"
#include "volume/traversal.h"

namespace trephine::haptics {

/// Where a way ends. When it is blocked, `before` is the last free voxel and `t` where the way leaves it.
struct WayEnd {
  bool is_blocked = false;
  double t = 1;
  glm::ivec3 before{0};
  volume::VoxelFace face;
  int shape = -1;
  bool is_back = false;  ///< stopped on the way out of a solid
};

/// Is voxel v in the solid of the shape?
inline bool is_solid(const TouchScene& scene, const volume::Version& version, std::size_t shape,
                     const glm::ivec3& v) noexcept {
  return scene.base->contains(v) && scene.shapes[shape].bits->is_solid(v) && version.is_kept(v);
}

/// The first voxel, seen from `start`, that a shape does not let the proxy enter (volume frame, exact).
/// `let_through`: shapes that hold nothing now. `inside` says in which solids the proxy is, and is brought up
/// to date where a shape lets it pass.
inline WayEnd find_barrier(const TouchScene& scene, const volume::Version& version, const glm::dvec3& start,
                           const glm::dvec3& end, const ShapeSet& let_through, ShapeSet& inside,
                           ProxyCounters& counters) noexcept {
  // One voxel of air around the grid, so that a solid may also be left through its border.
  const volume::VoxelBox box{glm::ivec3(-1), scene.base->size};
  volume::VoxelWalk walk(volume::Segment(start, end), box);
  glm::ivec3 before = walk.voxel();
  const auto count = static_cast<int>(scene.shapes.size());
  while (!walk.is_done()) {
    const glm::ivec3& v = walk.voxel();
    ++counters.voxels;
    const bool is_in_grid = scene.base->contains(v);
    for (int s = 0; s < count; ++s) {
      const TouchShape& shape = scene.shapes[static_cast<std::size_t>(s)];
      const bool is_now = is_in_grid && shape.bits->is_solid(v) && version.is_kept(v);
      const bool was = inside.contains(s);
      if (is_now == was) continue;
      if (walk.face().axis >= 0 && holds(scene, let_through, s, side_of(was)))
        return {true, walk.t_enter(), before, walk.face(), s, was};
      inside.flip(s);
    }
    before = v;
    // Nothing solid for a while: leave the empty box in one go.
    if (is_in_grid && inside.is_empty() && count > 0) {
      int far = scene.shapes[0].bits->empty_distance(v);
      for (const TouchShape& shape : scene.shapes) far = std::min(far, shape.bits->empty_distance(v));
      if (far > 0) {
        const glm::ivec3 block(v.x >> 2, v.y >> 2, v.z >> 2);
        const volume::VoxelBox empty{4 * (block - (far - 1)), 4 * (block + far) - 1};
        walk.advance_past(empty);
        // The voxel before is the neighbour on the other side of the face.
        if (!walk.is_done()) {
          before = walk.voxel();
          before[walk.face().axis] -= walk.face().step;
        }
        continue;
      }
    }
    walk.advance();
  }
  return {};
}

/// For methods whose walls are cubes. The first step, and a proxy over which matter has grown, start at the
/// HIP, inside whatever is there: sets state and path, and returns true. Else the step goes on.
bool begin_on_cubes(const TouchScene& scene, const volume::Version& version, const glm::dvec3& hip_volume,
                    ProxyState& state, ProxyStep& result) noexcept;
/// Ends the step at the path's last waypoint: friction along the way to it, which has led down to the surface
/// at waypoint `landing`, and the state for the next step.
void end_on_cubes(const TouchScene& scene, const volume::Version& version, const glm::dvec3& hip_world,
                  int landing, ProxyState& state, ProxyStep& result) noexcept;

}  // namespace trephine::haptics
