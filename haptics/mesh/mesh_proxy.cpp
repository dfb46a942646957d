#include "haptics/mesh/mesh_proxy.h"

#include <algorithm>

#include "haptics/mesh/god_object.h"
#include "haptics/proxy/friction.h"
#include "haptics/walls/solid_grid.h"
#include "haptics/walls/union_samples.h"
#include "volume/surface/local_net.h"
#include "volume/surface/surface_nets.h"

namespace trephine::haptics {

using glm::dvec3;
using glm::ivec3;

namespace {

/// Returns the shapes of a scene's volume that block from the front. `count`: output, their number.
ShapeSet front_shapes(const TouchScene& scene, const ShapeSet& passable, int& count) {
  ShapeSet front;
  count = 0;
  for (int s = 0; s < static_cast<int>(scene.items.size()); ++s)
    if (!scene.items[static_cast<std::size_t>(s)].is_mesh() && blocks(scene, passable, s, Side::front))
      front.set(s, true), ++count;
  return front;
}

/// Returns the surface of the union of shapes, in the world frame.
std::shared_ptr<const MeshTree> union_tree(const TouchScene& scene, const ShapeSet& members) {
  const std::shared_ptr<const volume::Version> version = uncut_version(scene);
  const VoxelGrid grid(scene, *version);
  const auto samples_of = [&](int s) { return grid.samples(static_cast<std::size_t>(s)); };
  const UnionSamples united(samples_of, members);
  const volume::LocalNet net(united);
  const volume::Frame& frame = grid.frame();
  const bool is_mirrored = glm::dot(glm::cross(frame.axes()[0], frame.axes()[1]), frame.axes()[2]) < 0;
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  const auto add = [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    for (const glm::vec3& corner : {a, is_mirrored ? c : b, is_mirrored ? b : c}) {
      triangles.push_back(static_cast<std::uint32_t>(vertices.size()));
      vertices.push_back(frame.world_from_volume(dvec3(corner)));
    }
  };
  ivec3 v;
  for (v.z = 0; v.z < grid.size().z; ++v.z)
    for (v.y = 0; v.y < grid.size().y; ++v.y)
      for (v.x = 0; v.x < grid.size().x; ++v.x) {
        if (!united.is_solid(v)) continue;
        for (int axis = 0; axis < 3; ++axis)
          for (const int sign : {-1, 1}) {
            ivec3 next = v;
            next[axis] += sign;
            if (!united.is_solid(next)) net.quad(glm::min(v, next), axis).triangles(add);
          }
      }
  return std::make_shared<const MeshTree>(std::move(vertices), std::move(triangles));
}

}  // namespace

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
    if (item.is_mesh() && !item.tree)
      return Error{.what = "a mesh has no search tree", .where = item.name, .remedy = "set TouchItem::tree"};
    if (item.mover >= 0)
      return Error{.what = "this method does not support moving meshes",
                   .where = item.name,
                   .found = "a mesh that moves",
                   .remedy = "use method scene"};
    trees_.push_back(item.is_mesh() ? item.tree : surface_tree(item));
    gap_ = std::min(gap_, trees_.back()->gap());
  }
  int count = 0;
  union_members_ = front_shapes(scene, {}, count);
  union_ = count > 1 ? union_tree(scene, union_members_) : nullptr;
  if (union_) gap_ = std::min(gap_, union_->gap());
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
  // While a shape is passable, the union of the others is not known, and only the single shapes block.
  int front_count = 0;
  const bool has_union = union_ && front_shapes(scene, state.around.passable, front_count) == union_members_;
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
    FacetHit candidate;
    if (!has_union ||
        !union_->cast(from, to, scene.tool->radius(), true, false, candidate, result.counters.triangles) ||
        (is_hit && candidate.t >= hit.t))
      return is_hit;
    hit = candidate;
    const VoxelGrid grid(scene, *touch_state.version);
    const auto samples_of = [&](int s) { return grid.samples(static_cast<std::size_t>(s)); };
    // A ball's centre is off the surface by its radius.
    const dvec3 place = from + hit.t * (to - from) - scene.tool->radius() * hit.normal_world;
    hit.shape = UnionSamples(samples_of, union_members_).owner_near(frame.volume_from_world(place));
    return true;
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
