#include "haptics/proxy/scene_proxy.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "haptics/depth/depth_source.h"
#include "haptics/proxy/slide.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_look_around = 8;  // mm beyond what a step needs, so that few steps have to look

bool has_friction(const Material& m) noexcept { return m.static_friction > 0 || m.dynamic_friction > 0; }

using Placements = std::array<Placement, TouchScene::k_max_movers>;

/// mm from p to the box of a shape.
double distance_to(const TouchScene& scene, const SceneLayout& layout, const Placements& placements,
                   int shape, const dvec3& p_world) noexcept {
  const SceneLayout::Box& box = layout.box(shape);
  if (!(box.low.x <= box.high.x)) return 1e300;
  dvec3 p = p_world;
  if (const int mover = item_of(scene, shape).mover; mover >= 0)
    p = placements[static_cast<std::size_t>(mover)].local_from_world(p_world);
  return glm::length(p - glm::clamp(p, box.low, box.high));
}

/// Sees to it that around.near holds every shape that a step from `start` toward `hip` may meet.
void look_around(const TouchScene& scene, const SceneLayout& layout, const Placements& placements,
                 const dvec3& start, const dvec3& hip, Surroundings& around) noexcept {
  // A step stays in the ball around the HIP on which it starts; its lifts leave that by less than a voxel.
  const double reach = glm::length(start - hip) + scene.tool_radius + 2 * layout.frame().spacing().x;
  if (around.near_radius > 0 && glm::length(hip - around.near_middle_world) + reach <= around.near_radius) {
    // Only what moves may have come nearer.
    for (const int shape : layout.movers())
      if (shape >= 0)
        around.near.set(shape, distance_to(scene, layout, placements, shape, around.near_middle_world) <=
                                   around.near_radius);
    return;
  }
  around.near = ShapeSet{};
  around.near_middle_world = hip;
  around.near_radius = reach + k_look_around;
  for (int s = 0; s < item_count(scene); ++s)
    if (distance_to(scene, layout, placements, s, hip) <= around.near_radius) around.near.flip(s);
}

/// A model that is new may lie over the proxy by what its triangles are off the surface that was there: then
/// it is set before the model, or would be held from neither side. Not where another wall is in between.
void set_before(const TouchScene& scene, const SceneLayout& layout, SceneWalls& walls,
                const Placements& placements, int mesh, double reach, ProxyState& state,
                dvec3& proxy) noexcept {
  const MeshTree& tree = walls.tree_of(mesh);
  if (!walls.holds(mesh, Side::front) || walls.holds(mesh, Side::back)) return;
  const double radius = scene.tool_radius, off = radius + 2 * tree.gap();
  if (distance_to(scene, layout, placements, mesh, proxy) > radius) return;  // outside its box is outside
  const Placement& place = walls.placement_of(mesh);
  const dvec3 start = place.local_from_world(proxy);
  dvec3 p = start;
  constexpr int k_most_rounds = 16;  // in a corner one facet after another
  for (int round = 0; round < k_most_rounds; ++round) {
    // Triangles that meet where it is nearest decide together whether that is before them or behind.
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
      return;  // deeper than it can have come by that
    } else {
      p = to + off / nearest * (p - to);
    }
  }
  if (p == start) return;
  const dvec3 before = place.world_from_local(p);
  ShapeSet inside = state.inside;
  const volume::Frame& frame = walls.frame();
  if (walls
          .reach(frame.volume_from_world(proxy), frame.volume_from_world(before), inside,
                 1e-3 * frame.spacing().x, mesh)
          .is_blocked)
    return;
  state.inside = inside;
  state.proxy_volume = scene.base->frame.volume_from_world(proxy = before);
}

/// The shape that depth images show, near which the tool was at `start`, where its way leaves what they know;
/// -1: none.
int left_images(const TouchScene& scene, const SceneLayout& layout, const TouchState& seen,
                const SceneWalls& walls, const volume::Frame& base, const dvec3& start,
                const ProxyStep& way) noexcept {
  for (std::size_t d = 0; d < layout.depths().size(); ++d) {
    const depth::DepthSet* set = depth::set_in(seen, static_cast<int>(d));
    const int shape = layout.depths()[d];
    if (set == nullptr || !walls.holds(shape, Side::front)) continue;
    const Placement& place = walls.placement_of(shape);
    const dvec3 from = place.local_from_world(start);
    bool leaves = false;
    for (int i = 1; i < way.waypoint_count; ++i) {
      const dvec3 p = base.world_from_volume(way.path_volume[static_cast<std::size_t>(i)]);
      leaves = leaves || !set->knows(place.local_from_world(p), 0);
    }
    if (!leaves) continue;
    // The surface that it slides along may have moved off by this tick's part.
    constexpr double k_off = 1;  // mm
    const double near = scene.tool_radius + k_off;
    if (set->tree->is_near(from, near)) return shape;
  }
  return -1;
}

/// The shortest way along which `push` (unit) gains `gap` and that leads into none of the walls, whose
/// normals are given; false when they close against it.
bool way_along(const dvec3& push, double gap, const std::array<dvec3, 3>& walls, int count,
               dvec3& way) noexcept {
  constexpr double k_steepest = 0.01;  // squared sine: a way ten times as long as the push, at most
  double shortest = 1e300;
  const auto try_way = [&](const dvec3& along) {  // of which push takes a part
    const double part = glm::dot(along, push), length = glm::length(along);
    if (!(length > 0) || !(part * part > k_steepest * length * length)) return;
    const dvec3 candidate = gap / part * along;
    for (int i = 0; i < count; ++i)
      if (glm::dot(candidate, walls[static_cast<std::size_t>(i)]) < -1e-9 * glm::length(candidate)) return;
    if (glm::length(candidate) >= shortest) return;
    shortest = glm::length(candidate);
    way = candidate;
  };
  try_way(push);
  for (int i = 0; i < count; ++i) {
    const dvec3& n = walls[static_cast<std::size_t>(i)];
    try_way(push - glm::dot(push, n) * n);
    for (int j = 0; j < i; ++j) try_way(glm::cross(n, walls[static_cast<std::size_t>(j)]));
  }
  return shortest < 1e300;
}

}  // namespace

volume::Status SceneProxy::prepare(const TouchScene& scene) {
  if (volume::Status error = check_offsets(scene)) return error;
  auto layout = SceneLayout::of(scene);
  if (!layout) return layout.error();
  layout_ = std::move(layout).value();
  return std::nullopt;
}

ProxyStep SceneProxy::step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                           const ProxyInput& input) const noexcept {
  const volume::Frame &base = seen.version->base().frame, &frame = layout_.frame();
  Surroundings& around = state.around;
  ProxyStep result;
  result.normal_world = dvec3(0);
  const ShapeSet adopted = layout_.adopt_sets(scene, seen, input, around);
  const Placements now = layout_.placements_of(scene, seen, input);
  const int rubbed = state.touched;
  dvec3 start = state.has_proxy ? base.world_from_volume(state.proxy_volume) : input.hip_world;
  const auto set_before_all = [&](const ShapeSet& shapes, const Placements& at, auto reach_of) {
    for (int s = shapes.next(0); state.has_proxy && s < item_count(scene); s = shapes.next(s + 1)) {
      look_around(scene, layout_, at, start, start, around);
      SceneWalls walls(scene, layout_, seen, state, at, result.counters);
      set_before(scene, layout_, walls, at, s, reach_of(s), state, start);
    }
  };
  if (!around.fresh.is_empty()) {
    const dvec3& spacing = scene.base->frame.spacing();
    const double reach = 0.5 * std::max({spacing.x, spacing.y, spacing.z});
    set_before_all(around.fresh, now, [&](int) { return reach; });
    around.fresh = ShapeSet{};
  }
  // New images show a surface a little off that which was there, where that had gone by itself.
  if (!adopted.is_empty())
    set_before_all(adopted, around.has_placements ? around.placements : now, [&](int shape) {
      const depth::DepthSet* set = depth::set_in(seen, layout_.depth_of(shape));
      return set ? 2 * set->view.pixel + 2 * set->slack_before : 0.0;
    });
  const bool has_moved = state.has_proxy && around.has_placements && now != around.placements;
  if (has_moved) {
    // One mesh after the other, each seen from itself: what the tool rubs on takes it along, and what would
    // pass over it pushes it.
    Placements moving = around.placements;
    std::array<dvec3, 3> in_the_way;  // normals of what blocked
    int in_the_way_count = 0;
    const SceneWalls trees(scene, layout_, seen, state, moving, result.counters);
    const auto tree_of = [&](int mesh) -> const MeshTree& { return trees.tree_of(mesh); };
    const auto move_to = [&](const dvec3& place, int mesh) {
      look_around(scene, layout_, moving, start, place, around);
      SceneWalls walls(scene, layout_, seen, state, moving, result.counters);
      ShapeSet inside = state.inside;
      const dvec3 from = frame.volume_from_world(start), to = frame.volume_from_world(place);
      const Reach way = walls.reach(from, to, inside, 1e-3 * frame.spacing().x, mesh);
      if (way.is_blocked) {
        const dvec3 out =
            -frame.gradient_world_from_volume(walls.jet(way.wall, from + way.t * (to - from)).gradient);
        if (!(glm::length(out) > 0)) return false;
        const dvec3 normal = glm::normalize(out);
        // A wall that bends stands in the way again a little farther on.
        int i = 0;
        while (i < in_the_way_count && glm::dot(in_the_way[static_cast<std::size_t>(i)], normal) < 0.95) ++i;
        if (i < static_cast<int>(in_the_way.size())) in_the_way[static_cast<std::size_t>(i)] = normal;
        in_the_way_count = std::max(in_the_way_count, std::min(i + 1, static_cast<int>(in_the_way.size())));
        return false;
      }
      state.inside = inside;
      start = place;
      state.proxy_volume = base.volume_from_world(start);
      return true;
    };
    /// Around what stands in the way of a push; `a`: where the tool was, seen from the mesh.
    const auto push_aside = [&](std::size_t m, int shape, const dvec3& a) {
      const bool is_front = holds(scene, around.let_through, shape, Side::front),
                 is_back = holds(scene, around.let_through, shape, Side::back);
      constexpr int k_most_rounds = 8;
      for (int round = 0; round < k_most_rounds; ++round) {
        const dvec3 b = now[m].local_from_world(start);
        FacetHit hit;
        if (!tree_of(shape).cast(a, b, scene.tool_radius, is_front, is_back, hit, result.counters.triangles))
          return true;
        const dvec3 push = now[m].rotation * hit.normal_world;
        const dvec3 contact = now[m].world_from_local(a + hit.t * (b - a));
        const double gap = std::max(0.0, glm::dot(contact - start, push)) + 1e-5 * frame.spacing().x;
        dvec3 way(0);
        if (!way_along(push, gap, in_the_way, in_the_way_count, way)) return false;
        // A hair off the walls that it runs along.
        for (int i = 0; i < in_the_way_count; ++i)
          way += 1e-5 * frame.spacing().x * in_the_way[static_cast<std::size_t>(i)];
        move_to(start + way, shape);
      }
      return false;
    };
    const double gap = 1e-6 * frame.spacing().x;
    for (std::size_t m = 0; m < now.size(); ++m) {
      const Placement before = std::exchange(moving[m], now[m]);
      const int shape = layout_.movers()[m];
      if (before == now[m] || shape < 0) continue;
      const TouchItem& mesh = item_of(scene, shape);
      const dvec3 a = before.local_from_world(start), along = now[m].world_from_local(a);
      const bool may_touch = holds(scene, around.let_through, shape, Side::front) ||
                             holds(scene, around.let_through, shape, Side::back);
      if (state.touched == shape && may_touch) {
        result.carried_world = along - start;
        const bool is_rough =
            has_friction(mesh.material) || (mesh.back_material && has_friction(*mesh.back_material));
        if (is_rough && move_to(along, shape)) continue;
      }
      const dvec3 b = now[m].local_from_world(start);
      FacetHit hit;
      if (!tree_of(shape).cast(a, b, scene.tool_radius, holds(scene, around.let_through, shape, Side::front),
                               holds(scene, around.let_through, shape, Side::back), hit,
                               result.counters.triangles))
        continue;
      const double approach = -glm::dot(b - a, hit.normal_world);
      const double free = approach > 0 ? std::max(0.0, hit.t - gap / approach) : 0;
      in_the_way_count = 0;
      if (move_to(now[m].world_from_local(a + free * (b - a)), shape) || push_aside(m, shape, a)) continue;
      // Between two walls that close: the mesh passes over the tool, which stays where the others hold it.
      result.is_buried = true;
    }
  }
  around.placements = now;
  around.has_placements = true;
  look_around(scene, layout_, now, start, input.hip_world, around);
  SceneWalls walls(scene, layout_, seen, state, now, result.counters);
  const bool was_buried = result.is_buried;
  const bool may_leave = state.had_contact && !layout_.depths().empty();
  const ProxyState before = may_leave ? state : ProxyState{};
  const ProxyStep made = result;
  slide(scene, walls, base, state, input.hip_world, result);
  // Beyond the border of depth images the surface that the tool slides along is unknown: it goes no farther
  // until the next ones come.
  constexpr double k_least = 1.0 / 64;  // of its way; less does not count
  int left = may_leave ? left_images(scene, layout_, seen, walls, base, start, result) : -1;
  const int holding = left;
  for (double share = 0.5; left >= 0; share *= 0.5) {
    state = before, result = made;
    const dvec3 part = share < k_least ? dvec3(0) : share * (input.hip_world - start);
    slide(scene, walls, base, state, start + part, result);
    left = share < k_least ? -1 : left_images(scene, layout_, seen, walls, base, start, result);
  }
  if (holding >= 0 && !result.has_contact) {
    result.has_contact = state.had_contact = true;
    result.shape = holding, result.side = Side::front;
    result.normal_world = glm::normalize(result.proxy_world - input.hip_world);
  }
  result.is_buried = result.is_buried || was_buried;
  const int touched = result.has_contact && item_of(scene, result.shape).mover >= 0 ? result.shape : -1;
  if (touched != rubbed) result.carried_world = dvec3(0);
  state.touched = touched;
  return result;
}

}  // namespace trephine::haptics
