#include "haptics/proxy/scene_proxy.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "haptics/mesh/god_object.h"
#include "haptics/proxy/implicit_proxy.h"
#include "haptics/proxy/slide.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_look_around = 8;  // mm beyond what a step needs, so that few steps have to look

using Placements = std::array<Placement, TouchScene::k_max_movers>;

/// Of the meshes that move; however many stand still.
Placements placements_of(const TouchScene& scene, const SceneLayout& layout,
                         const ProxyInput& input) noexcept {
  Placements now;
  for (std::size_t m = 0; m < now.size(); ++m)
    if (const int shape = layout.movers()[m]; shape >= 0)
      now[m] = m < input.movers.size() ? input.movers[m] : item_of(scene, shape).placement;
  return now;
}

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
  const Placements now = placements_of(scene, layout_, input);
  dvec3 start = state.has_proxy ? base.world_from_volume(state.proxy_volume) : input.hip_world;
  const bool has_moved = state.has_proxy && around.has_placements && now != around.placements;
  if (has_moved) {
    // One mesh after the other, each seen from itself: where it would pass over the proxy it takes it along.
    Placements moving = around.placements;
    double gap = 1e-6 * frame.spacing().x;
    for (std::size_t m = 0; m < now.size(); ++m) {
      const Placement before = std::exchange(moving[m], now[m]);
      const int shape = layout_.movers()[m];
      if (before == now[m] || shape < 0) continue;
      const TouchItem& mesh = item_of(scene, shape);
      const dvec3 a = before.local_from_world(start), b = now[m].local_from_world(start);
      const bool is_front = holds(scene, around.let_through, shape, Side::front),
                 is_back = holds(scene, around.let_through, shape, Side::back);
      FacetHit hit;
      if (!mesh.tree->cast(a, b, scene.tool_radius, is_front, is_back, hit, result.counters.triangles))
        continue;
      const double approach = -glm::dot(b - a, hit.normal_world);
      const double free = approach > 0 ? std::max(0.0, hit.t - gap / approach) : 0;
      const dvec3 pushed = now[m].world_from_local(a + free * (b - a));
      look_around(scene, layout_, moving, start, pushed, around);
      SceneWalls walls(scene, layout_, seen, state, moving, result.counters);
      ShapeSet inside = state.inside;
      const Reach way = walls.reach(frame.volume_from_world(start), frame.volume_from_world(pushed), inside,
                                    1e-3 * frame.spacing().x, shape);
      if (way.is_blocked) {
        // Between two walls that close: let go.
        result.is_buried = true;
        break;
      }
      state.inside = inside;
      start = pushed;
      state.proxy_volume = base.volume_from_world(start);
    }
  }
  around.placements = now;
  around.has_placements = true;
  look_around(scene, layout_, now, start, input.hip_world, around);
  SceneWalls walls(scene, layout_, seen, state, now, result.counters);
  if (result.is_buried) state.forget();
  const bool was_buried = result.is_buried;
  Slide(scene, walls, base, state, input.hip_world, result).run();
  result.is_buried = result.is_buried || was_buried;
  return result;
}

volume::Status SequentialProxy::prepare(const TouchScene& scene) {
  if (volume::Status error = check_offsets(scene)) return error;
  if (volume::Status error = check_burr_opens_voxels(scene)) return error;
  auto layout = SceneLayout::of(scene);
  if (!layout) return layout.error();
  layout_ = std::move(layout).value();
  volumes_.clear(), first_shape_.clear(), untouched_.clear();
  method_ = std::make_unique<ImplicitProxy>();
  for (const SceneLayout::Part& part : layout_.parts()) {
    TouchScene one;
    one.tool_radius = scene.tool_radius;
    one.base = part.untouched ? part.untouched->version->shared_base() : scene.base;
    one.items.assign(scene.items.begin() + part.begin, scene.items.begin() + part.end);
    if (volume::Status error = method_->prepare(one)) return error;
    volumes_.push_back(std::move(one));
    first_shape_.push_back(part.begin);
    untouched_.push_back(part.untouched);
  }
  return std::nullopt;
}

ProxyStep SequentialProxy::step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                                const ProxyInput& input) const noexcept {
  const volume::Frame& base = seen.version->base().frame;
  const dvec3& hip = input.hip_world;
  ProxyStep result;
  result.normal_world = dvec3(0);
  if (!state.has_proxy) {
    state.begin_at(base.volume_from_world(hip));
    state.on_meshes_world = hip;
    state.has_on_meshes = true;
    for (std::size_t i = 0; i < volumes_.size(); ++i) {
      ProxyState own;
      method_->step(volumes_[i], untouched_[i] ? *untouched_[i] : seen, own, {hip});
      for (int s = 0; s < static_cast<int>(volumes_[i].items.size()); ++s)
        state.inside.set(first_shape_[i] + s, own.inside.contains(s));
    }
    result.proxy_world = hip;
    result.path_volume[0] = state.proxy_volume;
    result.waypoint_count = 1;
    return result;
  }
  // The god-object on the meshes; set anew where the proxy was.
  if (!state.has_on_meshes) state.on_meshes_world = base.world_from_volume(state.proxy_volume);
  state.has_on_meshes = true;
  const Placements placements = placements_of(scene, layout_, input);
  static const volume::Frame world;
  const auto cast = [&](const dvec3& a, const dvec3& b, FacetHit& hit) {
    bool is_hit = false;
    for (int shape = 0; shape < item_count(scene); ++shape) {
      const TouchItem& mesh = item_of(scene, shape);
      if (!mesh.is_mesh()) continue;
      const Placement& placement =
          mesh.mover < 0 ? mesh.placement : placements[static_cast<std::size_t>(mesh.mover)];
      FacetHit one;
      if (!mesh.tree->cast(placement.local_from_world(a), placement.local_from_world(b), scene.tool_radius,
                           holds(scene, state.around.let_through, shape, Side::front),
                           holds(scene, state.around.let_through, shape, Side::back), one,
                           result.counters.triangles) ||
          (is_hit && one.t >= hit.t))
        continue;
      hit = one;
      hit.normal_world = placement.rotation * one.normal_world;
      hit.shape = shape;
      is_hit = true;
    }
    return is_hit;
  };
  double gap = 1e-5;
  for (const TouchItem& item : scene.items)
    if (item.is_mesh()) gap = std::min(gap, item.tree->gap());
  ProxyStep on_meshes;
  move_god_object(world, hip, state.on_meshes_world, gap, cast, on_meshes);
  const dvec3 target = on_meshes.path_volume[static_cast<std::size_t>(on_meshes.waypoint_count - 1)];
  state.on_meshes_world = target;
  result.counters.iterations += on_meshes.counters.iterations;
  // Every volume follows it; the one that was met first on the way counts.
  const dvec3 start = base.world_from_volume(state.proxy_volume);
  double shortest = 1e300;
  ProxyStep chosen;
  ProxyState chosen_state;
  std::size_t chosen_volume = 0;
  ShapeSet inside;
  for (std::size_t i = 0; i < volumes_.size(); ++i) {
    const volume::Frame& frame = volumes_[i].base->frame;
    const int first = first_shape_[i];
    ProxyState own = state;
    own.proxy_volume = i == 0 && !untouched_[0] ? state.proxy_volume : frame.volume_from_world(start);
    own.inside = own.around.let_through = ShapeSet{};
    for (int s = 0; s < static_cast<int>(volumes_[i].items.size()); ++s) {
      own.inside.set(s, state.inside.contains(first + s));
      own.around.let_through.set(s, state.around.let_through.contains(first + s));
    }
    const ProxyStep one = method_->step(volumes_[i], untouched_[i] ? *untouched_[i] : seen, own, {target});
    result.counters.voxels += one.counters.voxels;
    result.counters.cells += one.counters.cells;
    for (int s = 0; s < static_cast<int>(volumes_[i].items.size()); ++s)
      inside.set(first + s, own.inside.contains(s));
    result.is_buried = result.is_buried || one.is_buried;
    const double depth =
        one.has_contact && one.waypoint_count > 1
            ? glm::length(frame.vector_world_from_volume(one.path_volume[1] - one.path_volume[0]))
            : (one.has_contact ? 0 : 1e299);
    if (depth < shortest) {
      shortest = depth;
      chosen = one;
      chosen_state = own;
      chosen_volume = i;
    }
  }
  result.path_volume[0] = state.proxy_volume;
  result.waypoint_count = 1;
  const auto add = [&](const dvec3& p_volume) {
    if (result.waypoint_count < k_max_waypoints)
      result.path_volume[static_cast<std::size_t>(result.waypoint_count++)] = p_volume;
  };
  dvec3 proxy = target;
  if (shortest < 1e299) {
    const volume::Frame& frame = volumes_[chosen_volume].base->frame;
    for (int k = 1; k < chosen.waypoint_count; ++k) {
      const dvec3& p = chosen.path_volume[static_cast<std::size_t>(k)];
      add(untouched_[chosen_volume] ? base.volume_from_world(frame.world_from_volume(p)) : p);
    }
    proxy = chosen.proxy_world;
    result.has_contact = true;
    result.shape = first_shape_[chosen_volume] + chosen.shape;
    result.side = chosen.side;
    result.normal_world = chosen.normal_world;
    state.is_sticking = chosen_state.is_sticking;
  } else {
    add(base.volume_from_world(target));
    result.has_contact = on_meshes.has_contact;
    result.shape = on_meshes.shape;
    result.side = on_meshes.side;
    result.normal_world = on_meshes.normal_world;
  }
  state.had_contact = shortest < 1e299;
  state.inside = inside;
  state.proxy_volume = result.path_volume[static_cast<std::size_t>(result.waypoint_count - 1)];
  result.proxy_world = proxy;
  return result;
}

}  // namespace trephine::haptics
