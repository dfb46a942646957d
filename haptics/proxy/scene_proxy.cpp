#include "haptics/proxy/scene_proxy.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "haptics/depth/depth_source.h"
#include "haptics/proxy/slide.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_search_margin = 8;  // mm beyond the reach of a step, so that few steps search again

bool has_friction(const Material& m) noexcept { return m.static_friction > 0 || m.dynamic_friction > 0; }

using Placements = std::array<Placement, TouchScene::k_max_movers>;

/// Returns the distance (mm) from p to the box of a shape.
double distance_to(const TouchScene& scene, const SceneLayout& layout, const Placements& placements,
                   int shape, const dvec3& p_world) noexcept {
  const SceneLayout::Box& box = layout.box(shape);
  if (!(box.low.x <= box.high.x)) return 1e300;
  dvec3 p = p_world;
  if (const int mover = item_of(scene, shape).mover; mover >= 0)
    p = placements[static_cast<std::size_t>(mover)].local_from_world(p_world);
  return glm::length(p - glm::clamp(p, box.low, box.high));
}

/// Ensures that around.nearby contains every shape that a step from `start` toward `hip` may meet.
void update_near(const TouchScene& scene, const SceneLayout& layout, const Placements& placements,
                 const dvec3& start, const dvec3& hip, Surroundings& around) noexcept {
  // A step stays in the ball around the HIP whose surface contains the start. Moving the proxy off a wall
  // may leave this ball, by less than a voxel.
  const double reach = glm::length(start - hip) + scene.tool->radius() + 2 * layout.frame().spacing().x;
  if (around.near_radius > 0 && glm::length(hip - around.near_middle_world) + reach <= around.near_radius) {
    // Only moving meshes may have come nearer.
    for (const int shape : layout.movers())
      if (shape >= 0)
        around.nearby.set(shape, distance_to(scene, layout, placements, shape, around.near_middle_world) <=
                                     around.near_radius);
    return;
  }
  around.nearby = ShapeSet{};
  around.near_middle_world = hip;
  around.near_radius = reach + k_search_margin;
  for (int s = 0; s < item_count(scene); ++s)
    if (distance_to(scene, layout, placements, s, hip) <= around.near_radius) around.nearby.flip(s);
}

/// Returns true if there are shapes nearby, and all are shapes of the base volume.
bool is_only_base_near(const SceneLayout& layout, const ShapeSet& nearby) noexcept {
  const bool has_base = !layout.parts().empty() && !layout.parts()[0].uncut;
  return has_base && !nearby.is_empty() && nearby.next(layout.parts()[0].end) >= ShapeSet::k_max;
}

/// Moves the proxy to the free side of a new model. The triangles of the new model may deviate from the
/// previous surface and cover the proxy; without this motion the model would not block a covered proxy.
/// `reach`: largest deviation, mm; a deeper proxy is not moved. Does nothing if another wall is in between.
void move_out_of(const TouchScene& scene, const SceneLayout& layout, SceneWalls& walls,
                 const Placements& placements, int mesh, double reach, ProxyState& state,
                 dvec3& proxy) noexcept {
  const MeshTree& tree = walls.tree_of(mesh);
  if (!walls.blocks(mesh, Side::front) || walls.blocks(mesh, Side::back)) return;
  const double radius = scene.tool->radius(), off = radius + 2 * tree.gap();
  if (distance_to(scene, layout, placements, mesh, proxy) > radius) return;  // outside its box: not covered
  const Placement& placement = walls.placement_of(mesh);
  const dvec3 start = placement.local_from_world(proxy);
  dvec3 p = start;
  constexpr int k_max_rounds = 16;  // in a corner one facet after another
  for (int round = 0; round < k_max_rounds; ++round) {
    // Triangles that meet at the nearest point decide together whether the proxy is before or behind them.
    double nearest = std::max(reach, off);
    dvec3 to(0), normals(0);
    constexpr double k_tie = 1e-9;
    tree.for_nearest(p, nearest, k_tie, [&](const MeshTree::Near& near) {
      if (near.distance < nearest - k_tie) normals = dvec3(0);
      nearest = std::min(nearest, near.distance);
      to = near.nearest;
      normals += near.normal;
    });
    const double length = glm::length(normals);
    if (!(length > 1e-6)) break;
    if (glm::dot(p - to, normals) <= 0) {
      if (nearest > reach) return;
      p = to + off / length * normals;
    } else if (nearest >= radius + tree.gap() || !(nearest > 0)) {
      break;
    } else if (nearest < radius - reach) {
      return;  // deeper than the deviation allows
    } else {
      p = to + off / nearest * (p - to);
    }
  }
  if (p == start) return;
  const dvec3 outside = placement.world_from_local(p);
  ShapeSet inside = state.inside;
  const volume::Frame& frame = walls.frame();
  if (walls
          .reach(frame.volume_from_world(proxy), frame.volume_from_world(outside), inside,
                 1e-3 * frame.spacing().x, mesh)
          .is_blocked)
    return;
  state.inside = inside;
  state.proxy_volume = scene.base->frame.volume_from_world(proxy = outside);
}

/// Returns the shape with depth images near the tool at `start`, if the path leaves the region that they
/// show; -1: no such shape.
int find_exited_shape(const TouchScene& scene, const SceneLayout& layout, const TouchState& touch_state,
                      const SceneWalls& walls, const volume::Frame& base, const dvec3& start,
                      const ProxyStep& path) noexcept {
  for (std::size_t d = 0; d < layout.depths().size(); ++d) {
    const depth::DepthSet* set = depth::set_in(touch_state, static_cast<int>(d));
    const int shape = layout.depths()[d];
    if (set == nullptr || !walls.blocks(shape, Side::front)) continue;
    const Placement& placement = walls.placement_of(shape);
    const dvec3 from = placement.local_from_world(start);
    bool leaves = false;
    for (int i = 1; i < path.waypoint_count; ++i) {
      const dvec3 p = base.world_from_volume(path.path_volume[static_cast<std::size_t>(i)]);
      leaves = leaves || !set->is_known_around(placement.local_from_world(p), 0);
    }
    if (!leaves) continue;
    // The surface may have moved away from the tool since the last tick, by at most k_off.
    constexpr double k_off = 1;  // mm
    const double near = scene.tool->radius() + k_off;
    if (set->tree->is_near(from, near)) return shape;
  }
  return -1;
}

/// Slides along the walls of the whole scene. `may_leave`: the tool touched, and there are depth images.
/// Beyond the border of the images the surface along which the tool slides is unknown: the tool stops at the
/// border until the next images arrive.
void slide_along_scene(const TouchScene& scene, const SceneLayout& layout, const TouchState& touch_state,
                       const Placements& placements, const dvec3& start, const dvec3& hip, bool may_leave,
                       ProxyState& state, ProxyStep& result) noexcept {
  const volume::Frame& base = touch_state.version->base().frame;
  SceneWalls walls(scene, layout, touch_state, state, placements, result.counters);
  if (!may_leave) return slide(scene, walls, base, state, hip, result);
  const ProxyState previous_state = state;
  const ProxyStep previous_result = result;
  slide(scene, walls, base, state, hip, result);
  constexpr double k_min = 1.0 / 64;  // share of the motion; a smaller one counts as 0
  int exited_shape = find_exited_shape(scene, layout, touch_state, walls, base, start, result);
  const int border_shape = exited_shape;
  for (double share = 0.5; exited_shape >= 0; share *= 0.5) {
    state = previous_state, result = previous_result;
    const dvec3 part = share < k_min ? dvec3(0) : share * (hip - start);
    slide(scene, walls, base, state, start + part, result);
    exited_shape =
        share < k_min ? -1 : find_exited_shape(scene, layout, touch_state, walls, base, start, result);
  }
  if (border_shape >= 0 && !result.has_contact) {
    result.has_contact = state.had_contact = true;
    result.shape = border_shape, result.side = Side::front;
    result.normal_world = glm::normalize(result.proxy_world - hip);
  }
}

/// Finds the shortest motion that advances by `gap` along the unit vector `push`, and leads into none of the
/// walls, which are given by their normals. Returns false if the walls leave no such motion.
bool find_motion(const dvec3& push, double gap, const std::array<dvec3, 3>& walls, int count,
                 dvec3& motion) noexcept {
  constexpr double k_steepest = 0.01;  // squared sine: a motion at most ten times as long as the push
  double shortest = 1e300;
  const auto try_direction = [&](const dvec3& along) {
    const double part = glm::dot(along, push), length = glm::length(along);
    if (!(length > 0) || !(part * part > k_steepest * length * length)) return;
    const dvec3 candidate = gap / part * along;
    for (int i = 0; i < count; ++i)
      if (glm::dot(candidate, walls[static_cast<std::size_t>(i)]) < -1e-9 * glm::length(candidate)) return;
    if (glm::length(candidate) >= shortest) return;
    shortest = glm::length(candidate);
    motion = candidate;
  };
  try_direction(push);
  for (int i = 0; i < count; ++i) {
    const dvec3& n = walls[static_cast<std::size_t>(i)];
    try_direction(push - glm::dot(push, n) * n);
    for (int j = 0; j < i; ++j) try_direction(glm::cross(n, walls[static_cast<std::size_t>(j)]));
  }
  return shortest < 1e300;
}

}  // namespace

Status SceneProxy::prepare(const TouchScene& scene) {
  if (Status error = check_offsets(scene, info())) return error;
  auto layout = SceneLayout::of(scene);
  if (!layout) return layout.error();
  layout_ = std::move(layout).value();
  return std::nullopt;
}

ProxyStep SceneProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                           const ProxyInput& input) const noexcept {
  const volume::Frame &base = touch_state.version->base().frame, &frame = layout_.frame();
  Surroundings& around = state.around;
  ProxyStep result;
  result.normal_world = dvec3(0);
  const ShapeSet adopted = layout_.adopt_sets(scene, touch_state, input, around);
  const Placements next = layout_.placements_of(scene, touch_state, input);
  const int previous_item = state.touched_mover;
  dvec3 start = state.has_proxy ? base.world_from_volume(state.proxy_volume) : input.hip_world;
  const auto move_out_of_all = [&](const ShapeSet& shapes, const Placements& at, auto reach_of) {
    for (int s = shapes.next(0); state.has_proxy && s < item_count(scene); s = shapes.next(s + 1)) {
      update_near(scene, layout_, at, start, start, around);
      SceneWalls walls(scene, layout_, touch_state, state, at, result.counters);
      move_out_of(scene, layout_, walls, at, s, reach_of(s), state, start);
    }
  };
  if (!around.new_models.is_empty()) {
    const dvec3& spacing = scene.base->frame.spacing();
    const double reach = 0.5 * std::max({spacing.x, spacing.y, spacing.z});
    move_out_of_all(around.new_models, next, [&](int) { return reach; });
    around.new_models = ShapeSet{};
  }
  // New depth images may show the surface a little off the previous images, whose motion was extrapolated.
  if (!adopted.is_empty())
    move_out_of_all(adopted, around.has_placements ? around.placements : next, [&](int shape) {
      const depth::DepthSet* set = depth::set_in(touch_state, layout_.depth_index(shape));
      return set ? 2 * set->view.pixel + 2 * set->slack_before : 0.0;
    });
  const bool has_moved = state.has_proxy && around.has_placements && next != around.placements;
  if (has_moved) {
    // Moves one mesh after another, each in its own frame. A touched mesh with friction carries the tool
    // along. A mesh that would pass over the tool pushes it.
    Placements moving = around.placements;
    std::array<dvec3, 3> blockers;  // of walls that blocked a push
    int blocker_count = 0;
    const SceneWalls trees(scene, layout_, touch_state, state, moving, result.counters);
    const auto tree_of = [&](int mesh) -> const MeshTree& { return trees.tree_of(mesh); };
    const auto try_move = [&](const dvec3& target, int mesh) {
      update_near(scene, layout_, moving, start, target, around);
      SceneWalls walls(scene, layout_, touch_state, state, moving, result.counters);
      ShapeSet inside = state.inside;
      const dvec3 from = frame.volume_from_world(start), to = frame.volume_from_world(target);
      const Reach reach = walls.reach(from, to, inside, 1e-3 * frame.spacing().x, mesh);
      if (reach.is_blocked) {
        const dvec3 out =
            -frame.gradient_world_from_volume(walls.jet(reach.wall, from + reach.t * (to - from)).gradient);
        if (!(glm::length(out) > 0)) return false;
        const dvec3 normal = glm::normalize(out);
        // A bent wall may block again a little farther on: the new normal then replaces the earlier one.
        int i = 0;
        while (i < blocker_count && glm::dot(blockers[static_cast<std::size_t>(i)], normal) < 0.95) ++i;
        if (i < static_cast<int>(blockers.size())) blockers[static_cast<std::size_t>(i)] = normal;
        blocker_count = std::max(blocker_count, std::min(i + 1, static_cast<int>(blockers.size())));
        return false;
      }
      state.inside = inside;
      start = target;
      state.proxy_volume = base.volume_from_world(start);
      return true;
    };
    /// Pushes the tool out of the way of a mesh, around the walls that block the push. `a`: previous position
    /// of the tool in the mesh's frame. Returns false if the mesh still passes over the tool.
    const auto push_aside = [&](std::size_t m, int shape, const dvec3& a) {
      const bool is_front = blocks(scene, around.passable, shape, Side::front),
                 is_back = blocks(scene, around.passable, shape, Side::back);
      constexpr int k_max_rounds = 8;
      for (int round = 0; round < k_max_rounds; ++round) {
        const dvec3 b = next[m].local_from_world(start);
        FacetHit hit;
        if (!tree_of(shape).cast(a, b, scene.tool->radius(), is_front, is_back, hit,
                                 result.counters.triangles))
          return true;
        const dvec3 push = next[m].rotation * hit.normal_world;
        const dvec3 contact = next[m].world_from_local(a + hit.t * (b - a));
        const double gap = std::max(0.0, glm::dot(contact - start, push)) + 1e-5 * frame.spacing().x;
        dvec3 motion(0);
        if (!find_motion(push, gap, blockers, blocker_count, motion)) return false;
        // The motion keeps a small distance from the walls along which it leads.
        for (int i = 0; i < blocker_count; ++i)
          motion += 1e-5 * frame.spacing().x * blockers[static_cast<std::size_t>(i)];
        try_move(start + motion, shape);
      }
      return false;
    };
    const double gap = 1e-6 * frame.spacing().x;
    for (std::size_t m = 0; m < next.size(); ++m) {
      const Placement before = std::exchange(moving[m], next[m]);
      const int shape = layout_.movers()[m];
      if (before == next[m] || shape < 0) continue;
      const TouchItem& mesh = item_of(scene, shape);
      const dvec3 a = before.local_from_world(start), along = next[m].world_from_local(a);
      const bool may_touch = blocks(scene, around.passable, shape, Side::front) ||
                             blocks(scene, around.passable, shape, Side::back);
      if (state.touched_mover == shape && may_touch) {
        result.object_motion_world = along - start;
        const bool is_rough =
            has_friction(mesh.material) || (mesh.back_material && has_friction(*mesh.back_material));
        if (is_rough && try_move(along, shape)) continue;
      }
      const dvec3 b = next[m].local_from_world(start);
      FacetHit hit;
      if (!tree_of(shape).cast(a, b, scene.tool->radius(), blocks(scene, around.passable, shape, Side::front),
                               blocks(scene, around.passable, shape, Side::back), hit,
                               result.counters.triangles))
        continue;
      const double approach = -glm::dot(b - a, hit.normal_world);
      const double free = approach > 0 ? std::max(0.0, hit.t - gap / approach) : 0;
      blocker_count = 0;
      if (try_move(next[m].world_from_local(a + free * (b - a)), shape) || push_aside(m, shape, a)) continue;
      // Between two closing walls, the mesh passes over the tool, which stays where the other walls stop it.
      result.is_buried = true;
    }
  }
  around.placements = next;
  around.has_placements = true;
  update_near(scene, layout_, next, start, input.hip_world, around);
  const bool was_buried = result.is_buried;
  const bool may_leave = state.had_contact && !layout_.depths().empty();
  if (may_leave || !is_only_base_near(layout_, around.nearby)) {
    slide_along_scene(scene, layout_, touch_state, next, start, input.hip_world, may_leave, state, result);
  } else {
    // Most steps: nothing is near but the base, whose walls need no other frame.
    SmoothWalls walls(scene, touch_state, around.passable, result.counters, 0, layout_.parts()[0].end,
                      &around.nearby);
    slide(scene, walls, base, state, input.hip_world, result);
  }
  result.is_buried = result.is_buried || was_buried;
  const int touched = result.has_contact && item_of(scene, result.shape).mover >= 0 ? result.shape : -1;
  if (touched != previous_item) result.object_motion_world = dvec3(0);
  state.touched_mover = touched;
  return result;
}

}  // namespace trephine::haptics
