// step_rigid_tool(): one step of a tool with six degrees of freedom.
#pragma once

#include <algorithm>
#include <utility>

#include "haptics/proxy/tool_motion.h"
#include "haptics/walls/scene_walls.h"

namespace trephine::haptics {

/// Motion of a mesh since the previous step.
struct MeshMotion {
  const MeshTree& tree;
  bool is_front, is_back;  ///< sides that block
  const Placement &previous, &current;
  double margin;  ///< mm, distance from the surface that a push adds

  MeshMotion(const SceneWalls& walls, int mesh, const Placement& from, const Placement& to,
             double voxel_mm) noexcept
      : tree(walls.tree_of(mesh)),
        is_front(walls.blocks(mesh, Side::front)),
        is_back(walls.blocks(mesh, Side::back)),
        previous(from),
        current(to),
        margin(1e-5 * voxel_mm) {}

  /// Returns true if the mesh passes over a ball (radius 0: a point) at `local` of a tool that moves from
  /// `tool` to `to`, earlier than at share `first` of the motion. Then sets `first` to the share at which
  /// they meet, and `push` to a translation of `to` (mm, world) that prevents this.
  bool meets(const Placement& tool, const Placement& to, const glm::dvec3& local, double radius,
             double& first, glm::dvec3& push, int& visited) const noexcept {
    const glm::dvec3 a = previous.local_from_world(tool.world_from_local(local)),
                     b = current.local_from_world(to.world_from_local(local));
    FacetHit hit;
    if (!tree.cast(a, b, radius, is_front, is_back, hit, visited) || hit.t >= first) return false;
    first = hit.t;
    const glm::dvec3 normal = current.rotation * hit.normal_world;
    const glm::dvec3 contact = current.world_from_local(a + hit.t * (b - a));
    push = (std::max(0.0, glm::dot(contact - to.world_from_local(local), normal)) + margin) * normal;
    return true;
  }

  /// Moves the tool with the mesh, or pushes it to the side. find_push(to, push) returns true if the mesh
  /// would pass over the tool while the tool moves to the pose `to`. try_pose(to) moves the tool, and returns
  /// true, if no other wall is in between. Returns false if the mesh passed over the tool.
  template <class FindPush, class TryPose>
  bool move(const Placement& tool, FindPush&& find_push, TryPose&& try_pose) const {
    constexpr int k_max_pushes = 8;
    glm::dvec3 push(0);
    if (!find_push(tool, push)) return true;
    if (const Placement along = current * previous.inverse() * tool;
        try_pose(Placement{along.position_world, unit_of(along.rotation)}))
      return true;
    Placement to = tool;
    for (int i = 0; i < k_max_pushes; ++i) {
      if (!find_push(to, push)) return try_pose(to);
      to.position_world += push;
    }
    return false;
  }
};

/// Runs one step of a tool. Tool is constructed from scene, walls, state, input and counters. Its functions:
/// begin(frame) starts at the hand; resume(pose) continues from a pose; has_grown() returns true if restored
/// matter covers parts that were free; yield_to(mesh, previous, current) returns false if the mesh passed
/// over the tool; run(result) moves toward the hand; pose() and hand() return placements.
template <class Tool>
ProxyStep step_rigid_tool(const SceneLayout& layout, const TouchScene& scene, const TouchState& touch_state,
                          ProxyState& state, const ProxyInput& input) noexcept {
  const volume::Frame& base = touch_state.version->base().frame;
  ProxyStep result;
  result.normal_world = glm::dvec3(0);
  Surroundings& around = state.around;
  // A long tool may reach any item.
  for (int s = 0; s < item_count(scene); ++s) around.nearby.set(s, true);
  around.new_models = ShapeSet{};  // a part that overlaps a new model is pushed out of it
  // Meshes move one after another. While a mesh moves, earlier ones are at their current placement, and later
  // ones at their previous placement.
  layout.adopt_sets(scene, touch_state, input, around);
  const auto current = layout.placements_of(scene, touch_state, input);
  auto moving = state.has_proxy && around.has_placements ? around.placements : current;
  SceneWalls walls(scene, layout, touch_state, state, moving, result.counters);
  Tool tool(scene, walls, state, input, result.counters);
  const bool is_new = !state.has_proxy;
  bool is_passed_over = false;
  if (!is_new) {
    tool.resume({base.world_from_volume(state.proxy_volume),
                 state.has_turn ? state.tool_turn : tool.hand().rotation});
    if (state.version != touch_state.version->serial()) result.is_buried = tool.has_grown();
    for (std::size_t m = 0; m < current.size(); ++m)
      if (const Placement before = std::exchange(moving[m], current[m]);
          before != current[m] && layout.movers()[m] >= 0)
        is_passed_over = !tool.yield_to(layout.movers()[m], before, current[m]) || is_passed_over;
  }
  around.placements = current;
  around.has_placements = true;
  if (is_new || result.is_buried)
    tool.begin(base);
  else
    tool.run(result);
  result.is_buried = result.is_buried || is_passed_over;
  result.proxy_world = tool.pose().position_world;
  state.version = touch_state.version->serial();
  state.tool_turn = tool.pose().rotation;
  state.has_turn = true;
  state.proxy_volume = base.volume_from_world(result.proxy_world);
  state.had_contact = result.has_contact;
  result.add_waypoint(state.proxy_volume);
  return result;
}

}  // namespace trephine::haptics
