// find_barrier(): traversal of voxels along a motion until a touchable surface stops it.
#pragma once

#include <algorithm>

#include "haptics/proxy/friction.h"
#include "haptics/walls/solid_grid.h"
#include "volume/scan/traversal.h"

namespace trephine::haptics {

/// End of a motion. If the motion is blocked, `before` is its last free voxel; it leaves this voxel at `t`,
/// through `face`.
struct MotionEnd {
  bool is_blocked = false;
  double t = 1;  ///< parameter of the motion, 0 to 1
  glm::ivec3 before{0};
  volume::VoxelFace face;
  int shape = -1;
  bool is_back = false;  ///< stopped from inside a solid
};

/// Finds the first voxel on the motion from `start` to `end` (frame of the grid) at which the surface of a
/// shape blocks the motion, into or out of its solid. No voxel is missed. `passable`: shapes that do not
/// block now. `inside`: the solids that contain the proxy, updated where a shape lets the proxy pass.
template <class Grid>
MotionEnd find_barrier(const TouchScene& scene, const Grid& grid, const glm::dvec3& start,
                       const glm::dvec3& end, const ShapeSet& passable, ShapeSet& inside,
                       ProxyCounters& counters) noexcept {
  // One voxel of air around the grid, so that a motion may also leave a solid through the grid's border.
  const volume::VoxelBox box{glm::ivec3(-1), grid.size()};
  volume::VoxelWalk walk(volume::Segment(start, end), box);
  glm::ivec3 before = walk.voxel();
  const auto count = static_cast<int>(scene.items.size());
  while (!walk.is_done()) {
    const glm::ivec3& v = walk.voxel();
    ++counters.voxels;
    const bool is_in_grid = grid.contains(v);
    for (int s = 0; s < count; ++s) {
      const bool is_inside = is_in_grid && grid.is_solid_within(static_cast<std::size_t>(s), v);
      const bool was_inside = inside.contains(s);
      if (is_inside == was_inside) continue;
      if (walk.face().axis >= 0 && blocks(scene, passable, s, side_of(was_inside)))
        return {true, walk.t_enter(), before, walk.face(), s, was_inside};
      inside.flip(s);
    }
    before = v;
    // If no solid is near, crosses the empty box in one step.
    if (is_in_grid && inside.is_empty() && count > 0) {
      const volume::VoxelBox empty = grid.empty_box(v, 0, scene.items.size());
      if (empty.low.x <= empty.high.x && empty.low.y <= empty.high.y && empty.low.z <= empty.high.z) {
        walk.advance_past(empty);
        // The previous voxel is the neighbour on the other side of the face.
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

/// Returns the shapes whose solid contains p (frame of the grid).
template <class Grid>
ShapeSet solids_at(const TouchScene& scene, const Grid& grid, const glm::dvec3& p) noexcept {
  const glm::ivec3 v = volume::voxel_of(p);
  ShapeSet found;
  for (std::size_t s = 0; s < scene.items.size(); ++s)
    if (grid.is_solid(s, v)) found.set(static_cast<int>(s), true);
  return found;
}

/// Begins the step of a method with cubes as walls. Returns false if the step continues. In the first step,
/// or if a change of the anatomy put the proxy on the other side of a blocking surface (such as restored
/// matter that covers the proxy), sets state and path to the HIP, also inside a solid, and returns true.
template <class Grid>
bool begin_on_cubes(const TouchScene& scene, const Grid& grid, const glm::dvec3& hip_world, ProxyState& state,
                    ProxyStep& result) noexcept {
  bool is_fresh = !state.has_proxy;
  if (!is_fresh) {
    const glm::ivec3 v = volume::voxel_of(state.proxy_volume);
    for (std::size_t s = 0; s < scene.items.size(); ++s) {
      const bool was_inside = state.inside.contains(static_cast<int>(s));
      if (grid.is_solid(s, v) != was_inside &&
          blocks(scene, state.around.passable, static_cast<int>(s), side_of(was_inside)))
        result.is_buried = is_fresh = true;
    }
  }
  if (!is_fresh) return false;
  const glm::dvec3 hip = grid.frame().volume_from_world(hip_world);
  begin_at_hip(hip, hip_world, state, result);
  state.inside = solids_at(scene, grid, hip);
  return true;
}

/// Returns the squared distance of two points of a volume, mm^2.
inline double squared_mm(const volume::Frame& frame, const glm::dvec3& a, const glm::dvec3& b) noexcept {
  const glm::dvec3 d = frame.vector_world_from_volume(b - a);
  return glm::dot(d, d);
}

/// Returns the unit normal (world) of the face at which a motion was stopped, against the motion.
inline glm::dvec3 voxel_face_normal(const volume::Frame& frame, const volume::VoxelFace& face) noexcept {
  glm::dvec3 out(0);
  out[face.axis] = -face.step;
  return glm::normalize(frame.gradient_world_from_volume(out));
}

/// Ends the step at the path's last waypoint: applies friction along the path, and sets the state for the
/// next step. `landing`: index of the waypoint at which the path reaches the surface.
template <class Grid>
void end_on_cubes(const TouchScene& scene, const Grid& grid, const glm::dvec3& hip_world, int landing,
                  ProxyState& state, ProxyStep& result) noexcept {
  const auto is_blocked = [&](const glm::dvec3& a, const glm::dvec3& b) {
    ShapeSet after = state.inside;
    return find_barrier(scene, grid, a, b, state.around.passable, after, result.counters).is_blocked;
  };
  end_with_friction(grid.frame(), scene, hip_world, landing, nullptr, is_blocked, state, result);
  state.inside = solids_at(scene, grid, state.proxy_volume);
}

}  // namespace trephine::haptics
