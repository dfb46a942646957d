// OpenVDB: level-set ray casts from the proxy to the hand, each followed by the tangent plane at the hit.
#include <algorithm>
#include <chrono>
#include <glm/geometric.hpp>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/RayIntersector.h>

#include "apps/bench/peers.h"
#include "volume/surface/surface_nets.h"

namespace trephine::bench {

namespace {

using glm::dvec3;
using Grid = openvdb::FloatGrid;
using Intersector = openvdb::tools::LevelSetRayIntersector<Grid>;

/// For one thread: the intersector keeps its position in the tree.
class OpenVdbProxy final : public haptics::ProxyMethod {
 public:
  static constexpr haptics::MethodInfo k_info{
      .name = "OpenVDB",
      .meaning = "ray casts against the level set of the surface net, and tangent planes at their hits",
      .source = "Museth 2013",
      .solid = haptics::MethodInfo::Solid::nothing};
  const haptics::MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const haptics::TouchScene& scene) override {
    if (Status error = haptics::check_touchable(scene, k_info)) return error;
    openvdb::initialize();
    const haptics::TouchItem& shape = scene.items[0];
    const volume::Frame& frame = scene.base->frame;
    const dvec3& spacing = frame.spacing();
    voxel_ = std::min({spacing.x, spacing.y, spacing.z});
    const volume::Mesh net = volume::surface_net({&shape.field, nullptr, shape.bits.get()});
    const auto to_grid = openvdb::math::Transform::createLinearTransform(voxel_);
    std::vector<openvdb::Vec3s> vertices;
    for (std::size_t i = 0; i < net.vertices.size(); ++i) {
      const dvec3 p = frame.world_from_volume(dvec3(net.vertices[i]));
      vertices.emplace_back(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z));
    }
    std::vector<openvdb::Vec3I> triangles;
    for (std::size_t t = 0; t < net.triangles.size(); t += 3)
      triangles.emplace_back(net.triangles[t], net.triangles[t + 1], net.triangles[t + 2]);
    grid_ = openvdb::tools::meshToLevelSet<Grid>(*to_grid, vertices, triangles, 3.0f);
    if (grid_->empty()) return Error{.what = "the surface has no level set", .expected = "a closed surface"};
    intersector_ = std::make_unique<Intersector>(*grid_);
    return std::nullopt;
  }
  haptics::ProxyStep step(const haptics::TouchScene& scene, const haptics::TouchState&,
                          haptics::ProxyState& state,
                          const haptics::ProxyInput& input) const noexcept override {
    (void)scene;
    const volume::Frame& frame = scene.base->frame;
    haptics::ProxyStep result;
    result.normal_world = dvec3(0);
    const dvec3& hip = input.hip_world;
    dvec3 at = state.has_proxy ? frame.world_from_volume(state.proxy_volume) : hip, target = hip;
    result.path_volume[0] = frame.volume_from_world(at);
    const double above = 0.01 * voxel_;
    // Distance to the surface (mm), negative in matter; limited to the narrow band.
    const auto distance = [&](const dvec3& p) {
      const openvdb::Vec3d place = grid_->transform().worldToIndex(openvdb::Vec3d(p.x, p.y, p.z));
      return double{openvdb::tools::BoxSampler::sample(grid_->tree(), place)};
    };
    for (int i = 0; state.has_proxy && i < 3 && at != target; ++i) {
      const double length = glm::length(target - at);
      // The intersector searches for a change of sign between voxels, which needs more than a voxel's length:
      // segments are extended at both ends.
      const double margin = 1.5 * voxel_;
      const dvec3 along = (target - at) / length, from = at - margin * along;
      const auto cast = [&](double begin, dvec3& met, dvec3& out) {
        ++result.counters.iterations;
        const openvdb::math::Ray<double> ray(openvdb::Vec3d(from.x, from.y, from.z),
                                             openvdb::Vec3d(along.x, along.y, along.z), begin,
                                             length + 2 * margin);
        openvdb::Vec3d place(0.0), normal(0.0);
        if (!intersector_->intersectsWS(ray, place, normal)) return false;
        met = {place.x(), place.y(), place.z()};
        out = {normal.x(), normal.y(), normal.z()};
        return true;
      };
      // A hit behind the proxy is ignored; the ray continues from there.
      const double behind = 0.05 * voxel_;
      dvec3 met(0), out(0);
      bool is_met = cast(1e-9, met, out);
      // A point where the ray leaves matter is not a hit either.
      const auto is_no_hit = [&] { return glm::dot(met - at, along) < -behind || glm::dot(out, along) >= 0; };
      for (int more = 0; is_met && more < 8 && is_no_hit(); ++more)
        is_met = cast(glm::dot(met - from, along) + behind, met, out);
      if (!is_met || is_no_hit() || glm::dot(met - at, along) > length) {
        // Two changes of sign in one voxel are missed by the ray: the end of the segment is tested.
        if (distance(target) >= 0) {
          at = target;
        } else {
          result.has_contact = true;
          result.shape = 0, result.side = haptics::Side::front;
          if (result.normal_world == dvec3(0)) result.normal_world = -along;
        }
        break;
      }
      result.has_contact = true;
      result.shape = 0, result.side = haptics::Side::front;
      result.normal_world = out;
      // Move off the surface at the hit and, near another wall, out of that wall as well.
      dvec3 over = met + above * out;
      for (int more = 0; more < 4 && distance(over) < 0; ++more) over += (above - distance(over)) * out;
      if (distance(over) < 0) break;
      at = over;
      target = hip + (glm::dot(met - hip, out) + above) * out;
      if (glm::length(target - at) < 1e-6 * voxel_) break;
    }
    if (!state.has_proxy) at = hip;
    result.path_volume[1] = frame.volume_from_world(at);
    result.waypoint_count = 2;
    state.has_proxy = true;
    state.had_contact = result.has_contact;
    state.proxy_volume = result.path_volume[1];
    result.proxy_world = at;
    return result;
  }

 private:
  Grid::Ptr grid_;
  std::unique_ptr<Intersector> intersector_;
  double voxel_ = 1;
};

}  // namespace

OpenVdbLookups openvdb_lookups(const unsigned char* types, const int* size, unsigned char background,
                               const int* voxels, long count) {
  using Tree = openvdb::tree::Tree4<std::uint8_t, 5, 4, 3>::Type;
  Tree tree(background);
  openvdb::tree::ValueAccessor<Tree> writer(tree);
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x)
        if (const unsigned char type = *types++; type != background)
          writer.setValue(openvdb::Coord(x, y, z), type);
  tree.prune();
  OpenVdbLookups result;
  result.megabytes = 1e-6 * static_cast<double>(tree.memUsage());
  result.ns = 1e300;
  constexpr int k_runs = 5;
  for (int run = 0; run < k_runs; ++run) {
    const openvdb::tree::ValueAccessor<const Tree> reader(tree);
    const auto start = std::chrono::steady_clock::now();
    long sum = 0;
    for (long i = 0; i < count; ++i)
      sum += reader.getValue(openvdb::Coord(voxels[3 * i], voxels[3 * i + 1], voxels[3 * i + 2]));
    const double ns =
        std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
    result.ns = std::min(result.ns, ns / static_cast<double>(count));
    result.sum = sum;
  }
  return result;
}

Peer openvdb_peer() {
  return {OpenVdbProxy::k_info, OPENVDB_LIBRARY_VERSION_STRING, false,
          [] { return std::unique_ptr<haptics::ProxyMethod>(std::make_unique<OpenVdbProxy>()); }};
}

}  // namespace trephine::bench
