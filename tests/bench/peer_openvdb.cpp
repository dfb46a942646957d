// OpenVDB: level-set ray casts from the proxy to the hand, each followed by the tangent plane that was hit.
#include <glm/geometric.hpp>
#include <openvdb/openvdb.h>
#include <openvdb/tools/RayIntersector.h>

#include "tests/bench/peers.h"

namespace trephine::bench {

namespace {

using glm::dvec3;
using Grid = openvdb::FloatGrid;
using Intersector = openvdb::tools::LevelSetRayIntersector<Grid>;

/// For one thread: the intersector keeps its place in the tree.
class OpenVdbProxy final : public haptics::ProxyMethod {
 public:
  const char* name() const noexcept override { return "OpenVDB"; }
  volume::Status prepare(const haptics::TouchScene& scene) override {
    if (volume::Status error = haptics::check_touchable(scene)) return error;
    openvdb::initialize();
    const volume::Field& field = scene.shapes[0].field;
    const volume::Volume& base = *scene.base;
    // In index space: a level set wants cubic voxels, which rays in voxels have. Values in the band of the
    // surface, as slopes make them distances there: about.
    grid_ = Grid::create(3.0f);
    grid_->setGridClass(openvdb::GRID_LEVEL_SET);
    Grid::Accessor accessor = grid_->getAccessor();
    const volume::Occupancy& bits = *scene.shapes[0].bits;
    const auto is_in_at = [&](int x, int y, int z) {
      return base.contains({x, y, z}) && bits.is_solid({x, y, z});
    };
    for (int z = 1; z + 1 < base.size.z; ++z)
      for (int y = 1; y + 1 < base.size.y; ++y)
        for (int x = 1; x + 1 < base.size.x; ++x) {
          if (bits.empty_distance({x, y, z}) > 1) {
            x |= 3;  // nothing near this block
            continue;
          }
          const bool is_in = is_in_at(x, y, z);
          bool is_near = false;
          for (int k = -2; k <= 2 && !is_near; ++k)
            is_near = is_in_at(x + k, y, z) != is_in || is_in_at(x, y + k, z) != is_in ||
                      is_in_at(x, y, z + k) != is_in;
          if (is_near) {
            const dvec3 slope = field.gradient(dvec3(x, y, z));
            accessor.setValue({x, y, z},
                              static_cast<float>(std::clamp(
                                  -field.at(x, y, z) / std::max(1.0, glm::length(slope)), -2.9, 2.9)));
          } else if (is_in) {
            accessor.setValueOff({x, y, z}, -3.0f);
          }
        }
    grid_->pruneGrid();
    intersector_ = std::make_unique<Intersector>(*grid_);
    return std::nullopt;
  }
  haptics::ProxyStep step(const haptics::TouchScene& scene, const volume::Version& version,
                          haptics::ProxyState& state,
                          const haptics::ProxyInput& input) const noexcept override {
    (void)scene;
    const volume::Frame& frame = version.base().frame;
    haptics::ProxyStep result;
    result.normal_world = dvec3(0);
    const dvec3 hip = frame.volume_from_world(input.hip_world);
    dvec3 at = state.has_proxy ? state.proxy_volume : hip, target = hip;
    result.path_volume[0] = at;
    result.waypoint_count = 1;
    for (int i = 0; state.has_proxy && i < 3 && at != target; ++i) {
      ++result.counters.iterations;
      const double length = glm::length(target - at);
      // It looks for a change of sign between voxels: ways of a part of a voxel begin before and end after.
      constexpr double k_margin = 1.5;
      const dvec3 along = (target - at) / length, from = at - k_margin * along;
      const auto cast = [&](double begin, dvec3& met, dvec3& out) {
        const openvdb::math::Ray<double> ray(openvdb::Vec3d(from.x, from.y, from.z),
                                             openvdb::Vec3d(along.x, along.y, along.z), begin,
                                             length + 2 * k_margin);
        openvdb::Vec3d place(0.0), normal(0.0);  // its world is the volume frame
        if (!intersector_->intersectsWS(ray, place, normal)) return false;
        met = {place.x(), place.y(), place.z()};
        out = {normal.x(), normal.y(), normal.z()};
        return true;
      };
      // What lies behind the proxy is no hit; the ray goes on from there.
      constexpr double k_behind = 0.05;
      dvec3 met(0), out(0);
      bool is_met = cast(1e-9, met, out);
      for (int more = 0; is_met && more < 4 && glm::dot(met - at, along) < -k_behind; ++more)
        is_met = cast(glm::dot(met - from, along) + k_behind, met, out);
      const double reached = glm::dot(met - at, along);
      if (!is_met || reached < -k_behind || reached > length) {
        at = target;
        break;
      }
      out = glm::normalize(frame.gradient_world_from_volume(out));
      if (glm::dot(out, frame.vector_world_from_volume(target - at)) >= 0) break;
      result.has_contact = true;
      result.shape = 0, result.side = 1;
      result.normal_world = out;
      const dvec3 met_world = frame.world_from_volume(met);
      at = frame.volume_from_world(met_world + 0.01 * frame.spacing().x * out);
      target = frame.volume_from_world(input.hip_world + glm::dot(met_world - input.hip_world, out) * out +
                                       0.01 * frame.spacing().x * out);
      if (glm::length(target - at) < 1e-6) break;
    }
    if (!state.has_proxy) at = hip;
    if (at != result.path_volume[0])
      result.path_volume[static_cast<std::size_t>(result.waypoint_count++)] = at;
    state.has_proxy = true;
    state.had_contact = result.has_contact;
    state.proxy_volume = at;
    result.proxy_world = frame.world_from_volume(at);
    return result;
  }

 private:
  Grid::Ptr grid_;
  std::unique_ptr<Intersector> intersector_;
};

}  // namespace

Peer openvdb_peer() {
  return {{"OpenVDB", "ray casts at a level set, and the planes they meet", "Museth 2013",
           haptics::MethodInfo::Solid::nothing},
          OPENVDB_LIBRARY_VERSION_STRING,
          false,
          [] { return std::unique_ptr<haptics::ProxyMethod>(std::make_unique<OpenVdbProxy>()); }};
}

}  // namespace trephine::bench
