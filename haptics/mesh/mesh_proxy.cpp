#include "haptics/mesh/mesh_proxy.h"

#include <algorithm>

#include "haptics/mesh/god_object.h"
#include "haptics/proxy/friction.h"
#include "volume/surface/surface_nets.h"

namespace trephine::haptics {

using glm::dvec3;

std::shared_ptr<const MeshTree> surface_tree(const TouchItem& shape) {
  const volume::Mesh net = volume::surface_net({&shape.field, nullptr, shape.bits.get()});
  const volume::Frame& frame = shape.field.volume().frame;
  const glm::dmat3& axes = frame.axes();
  std::vector<dvec3> vertices(net.vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i)
    vertices[i] = frame.world_from_volume(dvec3(net.vertices[i]));
  std::vector<std::uint32_t> triangles(net.triangles.data(), net.triangles.data() + net.triangles.size());
  if (glm::dot(glm::cross(axes[0], axes[1]), axes[2]) < 0)
    for (std::size_t t = 0; t < triangles.size(); t += 3) std::swap(triangles[t + 1], triangles[t + 2]);
  return std::make_shared<const MeshTree>(std::move(vertices), std::move(triangles));
}

Status MeshProxy::prepare(const TouchScene& scene) {
  if (Status error = check_touchable(scene, info())) return error;
  if (Status error = check_cuts(scene, info())) return error;
  trees_.clear();
  gap_ = 1e-5;
  for (const TouchItem& item : scene.items) {
    if (item.is_mesh() && !item.tree) return Error{.what = "a mesh has no search tree", .where = item.name};
    if (item.mover >= 0)
      return Error{.what = "this method does not support moving meshes",
                   .where = item.name,
                   .found = "a mesh that moves",
                   .remedy = "use method scene"};
    trees_.push_back(item.is_mesh() ? item.tree : surface_tree(item));
    gap_ = std::min(gap_, trees_.back()->gap());
  }
  return std::nullopt;
}

ProxyStep MeshProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                          const ProxyInput& input) const noexcept {
  const volume::Frame& frame = touch_state.version->base().frame;
  ProxyStep result;
  result.normal_world = dvec3(0);
  const dvec3 hip = frame.volume_from_world(input.hip_world);
  if (!state.has_proxy) {
    begin_at_hip(hip, input.hip_world, state, result);
    return result;
  }
  const auto cast = [&](const dvec3& a, const dvec3& b, FacetHit& hit) {
    const dvec3 from = frame.world_from_volume(a), to = frame.world_from_volume(b);
    bool is_hit = false;
    for (int index = 0; index < item_count(scene); ++index) {
      const TouchItem& item = item_of(scene, index);
      const Placement& placement = item.placement;
      FacetHit candidate;
      if (!trees_[static_cast<std::size_t>(index)]->cast(
              placement.local_from_world(from), placement.local_from_world(to), scene.tool->radius(),
              blocks(scene, state.around.passable, index, Side::front),
              blocks(scene, state.around.passable, index, Side::back), candidate,
              result.counters.triangles) ||
          (is_hit && candidate.t >= hit.t))
        continue;
      hit = candidate;
      if (item.is_mesh()) hit.normal_world = placement.rotation * candidate.normal_world;
      hit.shape = index;
      is_hit = true;
    }
    return is_hit;
  };
  PathFacets facets;
  const int landing = move_god_object(frame, input.hip_world, state.proxy_volume, gap_, cast, facets, result);
  const auto is_blocked = [&](const dvec3& a, const dvec3& b) {
    FacetHit hit;
    return cast(a, b, hit);
  };
  end_with_friction(frame, scene, input.hip_world, landing, &facets, is_blocked, state, result);
  return result;
}

}  // namespace trephine::haptics
