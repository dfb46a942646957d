#include "haptics/depth/depth_proxy.h"

#include <algorithm>

#include "haptics/depth/depth_items.h"
#include "haptics/proxy/friction.h"
#include "haptics/walls/cell_cast.h"
#include "haptics/walls/union_samples.h"
#include "volume/surface/local_net.h"

namespace trephine::haptics {

using depth::DepthCube;
using glm::dvec3;
using glm::ivec3;

Status DepthProxy::prepare(const TouchScene& scene) {
  if (Status error = check_touchable(scene, info())) return error;
  if (Status error = check_cuts(scene, info())) return error;
  auto cubes = depth::cubes_of(scene, {k_pixel, 1e300});
  if (!cubes) return cubes.error();
  nets_.clear();
  gap_ = 1;
  for (std::size_t i = 0; i < cubes.value().size(); ++i) {
    DepthCube& cube = cubes.value()[i];
    const dvec3 mm = cube.frame().spacing();
    using Thin = depth::DepthNet::Thin;
    nets_.emplace_back(std::move(cube), scene.items[i].is_mesh() ? Thin::joined : Thin::separate);
    gap_ = std::min(gap_, k_facet_gap * std::min({mm.x, mm.y, mm.z}));
  }
  return std::nullopt;
}

ProxyStep DepthProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                           const ProxyInput& input) const noexcept {
  const volume::Frame& frame = touch_state.version->base().frame;
  ProxyStep result;
  result.normal_world = dvec3(0);
  const auto net_of = [this](int index) -> const depth::DepthNet& {
    return nets_[static_cast<std::size_t>(index)];
  };
  depth::VertexCache placed;
  const auto surface_of = [&](int index) {
    return volume::LocalNet{depth::DepthSamples(net_of(index), &placed)};
  };
  const auto in_cube = [&](int index, const dvec3& p_world) {
    const TouchItem& item = item_of(scene, index);
    return net_of(index).cube().frame().volume_from_world(
        item.is_mesh() ? item.placement.local_from_world(p_world) : p_world);
  };
  const auto find_solids = [&](const dvec3& p_world) {
    for (int index = 0; index < item_count(scene); ++index)
      state.inside.set(index, is_behind_cells(surface_of(index), in_cube(index, p_world)));
  };
  if (!state.has_proxy) {
    begin_at_hip(frame.volume_from_world(input.hip_world), input.hip_world, state, result);
    find_solids(input.hip_world);
    return result;
  }
  const auto cast = [&](const dvec3& a, const dvec3& b, FacetHit& hit) {
    if (a == b) return false;
    const dvec3 from = frame.world_from_volume(a), to = frame.world_from_volume(b);
    const auto no_box = [](const ivec3&) { return volume::VoxelBox{ivec3(1), ivec3(0)}; };
    bool is_hit = false;
    ShapeSet front;  // shapes of the volume that block from the front
    int front_count = 0;
    for (int index = 0; index < item_count(scene); ++index) {
      const bool is_front = blocks(scene, state.around.passable, index, Side::front),
                 is_back = blocks(scene, state.around.passable, index, Side::back);
      if (!is_front && !is_back) continue;
      if (is_front && !state.inside.contains(index) && !item_of(scene, index).is_mesh())
        front.set(index, true), ++front_count;
      const DepthCube& cube = net_of(index).cube();
      if (!cast_on_cells(surface_of(index), cube.frame(), cube.size(), no_box, in_cube(index, from),
                         in_cube(index, to), is_front, is_back, is_hit, hit, result.counters))
        continue;
      const TouchItem& item = item_of(scene, index);
      if (item.is_mesh()) hit.normal_world = item.placement.rotation * hit.normal_world;
      hit.shape = index;
      is_hit = true;
    }
    if (front_count < 2) return is_hit;
    const auto samples_of = [&](int index) { return depth::DepthSamples(net_of(index)); };
    const UnionSamples united(samples_of, front);
    const int first = front.next(0);
    const DepthCube& cube = net_of(first).cube();
    const dvec3 start = in_cube(first, from), end = in_cube(first, to);
    if (!cast_on_cells(volume::LocalNet(united), cube.frame(), cube.size(), no_box, start, end, true, false,
                       is_hit, hit, result.counters))
      return is_hit;
    hit.shape = united.owner_near(start + hit.t * (end - start));
    return true;
  };
  const dvec3 before = state.proxy_volume;
  PathFacets facets;
  const int landing = move_god_object(frame, input.hip_world, state.proxy_volume, gap_, cast, facets, result);
  const auto is_blocked = [&](const dvec3& a, const dvec3& b) {
    FacetHit hit;
    return cast(a, b, hit);
  };
  end_with_friction(frame, scene, input.hip_world, landing, &facets, is_blocked, state, result);
  // The proxy enters a solid only through a side that does not block.
  if (state.proxy_volume != before && (!state.inside.is_empty() || !result.has_contact))
    find_solids(result.proxy_world);
  return result;
}

}  // namespace trephine::haptics
