#include "haptics/baselines/sequential_proxy.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics/mesh/god_object.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/walls/scene_walls.h"

namespace trephine::haptics::baselines {

using glm::dvec3;

namespace {

constexpr double k_not_met = 1e299;  // depth of a volume without contact

const Placement& placement_of(const TouchItem& mesh, const ProxyInput& input) noexcept {
  const auto m = static_cast<std::size_t>(mesh.mover);
  return mesh.mover >= 0 && m < input.movers.size() ? input.movers[m] : mesh.placement;
}

/// Moves the god-object on the meshes alone, in the world frame.
ProxyStep follow_on_meshes(const TouchScene& scene, const ProxyState& state, const ProxyInput& input,
                           ProxyCounters& counters) noexcept {
  const auto cast = [&](const dvec3& a, const dvec3& b, FacetHit& hit) {
    bool is_hit = false;
    for (int i = 0; i < item_count(scene); ++i) {
      const TouchItem& mesh = item_of(scene, i);
      if (!mesh.is_mesh()) continue;
      const Placement& placement = placement_of(mesh, input);
      FacetHit candidate;
      if (!mesh.tree->cast(placement.local_from_world(a), placement.local_from_world(b), scene.tool->radius(),
                           blocks(scene, state.around.passable, i, Side::front),
                           blocks(scene, state.around.passable, i, Side::back), candidate,
                           counters.triangles) ||
          (is_hit && candidate.t >= hit.t))
        continue;
      hit = candidate;
      hit.normal_world = placement.rotation * candidate.normal_world;
      hit.shape = i;
      is_hit = true;
    }
    return is_hit;
  };
  double gap = 1e-5;
  for (const TouchItem& item : scene.items)
    if (item.is_mesh()) gap = std::min(gap, item.tree->gap());
  static const volume::Frame world;
  ProxyStep step;
  PathFacets facets;
  move_god_object(world, input.hip_world, state.mesh_proxy_world, gap, cast, facets, step);
  return step;
}

}  // namespace

Status SequentialProxy::prepare(const TouchScene& scene) {
  if (Status error = check_offsets(scene, info())) return error;
  if (Status error = check_burr_opens_voxels(scene)) return error;
  if (Status error = check_has_no_depth(scene)) return error;
  const auto layout = SceneLayout::of(scene);
  if (!layout) return layout.error();
  parts_.clear();
  for (const SceneLayout::Part& layout_part : layout.value().parts()) {
    Part part{{}, layout_part.begin, layout_part.uncut};
    part.scene.tool = scene.tool;
    part.scene.base = layout_part.uncut ? layout_part.uncut->version->shared_base() : scene.base;
    part.scene.items.assign(scene.items.begin() + layout_part.begin, scene.items.begin() + layout_part.end);
    if (Status error = method_.prepare(part.scene)) return error;
    parts_.push_back(std::move(part));
  }
  return std::nullopt;
}

/// Starts at the HIP, inside any solid there.
void SequentialProxy::begin(const TouchState& touch_state, const dvec3& hip,
                            ProxyState& state) const noexcept {
  state.begin_at(touch_state.version->base().frame.volume_from_world(hip));
  state.mesh_proxy_world = hip;
  state.has_mesh_proxy = true;
  for (const Part& part : parts_) {
    ProxyState own;
    method_.step(part.scene, part.state(touch_state), own, {hip});
    for (int s = 0; s < part.count(); ++s) state.inside.set(part.first + s, own.inside.contains(s));
  }
}

/// Moves the proxy on one volume alone, from `start` toward `target`, the god-object on the meshes.
SequentialProxy::PartResult SequentialProxy::follow(const Part& part, const TouchState& touch_state,
                                                    const ProxyState& state, const dvec3& start,
                                                    const dvec3& target) const noexcept {
  const volume::Frame& frame = part.scene.base->frame;
  PartResult part_result;
  ProxyState& own = part_result.state;
  own = state;
  if (part.uncut) own.proxy_volume = frame.volume_from_world(start);
  own.inside = own.around.passable = ShapeSet{};
  for (int s = 0; s < part.count(); ++s) {
    own.inside.set(s, state.inside.contains(part.first + s));
    own.around.passable.set(s, state.around.passable.contains(part.first + s));
  }
  part_result.step = method_.step(part.scene, part.state(touch_state), own, {target});
  const ProxyStep& step = part_result.step;
  part_result.depth =
      step.has_contact && step.waypoint_count > 1
          ? glm::length(frame.vector_world_from_volume(step.path_volume[1] - step.path_volume[0]))
          : (step.has_contact ? 0 : k_not_met);
  return part_result;
}

ProxyStep SequentialProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                                const ProxyInput& input) const noexcept {
  const volume::Frame& base = touch_state.version->base().frame;
  ProxyStep result;
  result.normal_world = dvec3(0);
  if (!state.has_proxy) {
    begin(touch_state, input.hip_world, state);
    result.proxy_world = input.hip_world;
    result.add_waypoint(state.proxy_volume);
    return result;
  }

  // Moves the god-object on the meshes; it starts at the proxy if it has no position.
  if (!state.has_mesh_proxy) state.mesh_proxy_world = base.world_from_volume(state.proxy_volume);
  state.has_mesh_proxy = true;
  const ProxyStep on_meshes = follow_on_meshes(scene, state, input, result.counters);
  const dvec3 target = on_meshes.path_volume[static_cast<std::size_t>(on_meshes.waypoint_count - 1)];
  state.mesh_proxy_world = target;
  result.counters.iterations += on_meshes.counters.iterations;

  // On every volume a proxy follows the god-object; the proxy that is stopped first counts.
  const dvec3 start = base.world_from_volume(state.proxy_volume);
  const Part* best_part = nullptr;
  PartResult nearest;
  ShapeSet inside;
  for (const Part& part : parts_) {
    const PartResult part_result = follow(part, touch_state, state, start, target);
    result.counters.voxels += part_result.step.counters.voxels;
    result.counters.cells += part_result.step.counters.cells;
    result.is_buried = result.is_buried || part_result.step.is_buried;
    for (int s = 0; s < part.count(); ++s) inside.set(part.first + s, part_result.state.inside.contains(s));
    if (part_result.depth >= nearest.depth) continue;
    nearest = part_result;
    best_part = &part;
  }

  result.add_waypoint(state.proxy_volume);
  state.had_contact = nearest.depth < k_not_met;
  if (state.had_contact) {
    const volume::Frame& frame = best_part->scene.base->frame;
    for (int k = 1; k < nearest.step.waypoint_count; ++k) {
      const dvec3& p = nearest.step.path_volume[static_cast<std::size_t>(k)];
      result.add_waypoint(best_part->uncut ? base.volume_from_world(frame.world_from_volume(p)) : p);
    }
    result.set_contact(best_part->first + nearest.step.shape, nearest.step.side, nearest.step.normal_world);
    result.proxy_world = nearest.step.proxy_world;
    state.is_sticking = nearest.state.is_sticking;
  } else {
    result.add_waypoint(base.volume_from_world(target));
    if (on_meshes.has_contact) result.set_contact(on_meshes.shape, on_meshes.side, on_meshes.normal_world);
    result.proxy_world = target;
  }
  state.inside = inside;
  state.proxy_volume = result.path_volume[static_cast<std::size_t>(result.waypoint_count - 1)];
  return result;
}

}  // namespace trephine::haptics::baselines
