// Embree: a god-object whose path segments are cast against the whole surface by Embree's robust traversal,
// in single precision.
#include <embree3/rtcore.h>
#include <glm/geometric.hpp>

#include "apps/bench/measure.h"
#include "apps/bench/peers.h"
#include "haptics/mesh/god_object.h"
#include "haptics/mesh/mesh_tree.h"
#include "volume/base/parallel.h"
#include "volume/surface/surface_nets.h"

namespace trephine::bench {

namespace {

using glm::dvec3;

class EmbreeProxy final : public haptics::ProxyMethod {
 public:
  EmbreeProxy() : device_(rtcNewDevice(nullptr)) {}
  ~EmbreeProxy() override {
    if (scene_) rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeProxy(const EmbreeProxy&) = delete;
  EmbreeProxy& operator=(const EmbreeProxy&) = delete;

  static constexpr haptics::MethodInfo k_info{
      .name = "Embree",
      .meaning = "a god-object on the whole surface, path segments cast by Embree",
      .source = "Wald et al. 2014",
      .solid = haptics::MethodInfo::Solid::net,
      .takes_cuts = false,
      .takes_meshes = true};
  const haptics::MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const haptics::TouchScene& scene) override {
    const bool is_model = scene.items.size() == 1 && scene.items[0].is_mesh();
    haptics::MethodInfo takes = k_info;
    takes.takes_meshes = is_model;
    if (Status error = haptics::check_touchable(scene, takes)) return error;
    if (scene_) rtcReleaseScene(scene_);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    const haptics::TouchItem& shape = scene.items[0];
    const Triangles net = is_model ? of_model(scene) : of_shape(shape);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), net.vertices.size()));
    for (std::size_t i = 0; i < net.vertices.size(); ++i)
      for (int a = 0; a < 3; ++a) vertices[3 * i + static_cast<std::size_t>(a)] = net.vertices[i][a];
    auto* triangles =
        static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                       3 * sizeof(unsigned), net.triangles.size() / 3));
    std::copy(net.triangles.begin(), net.triangles.end(), triangles);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
    return std::nullopt;
  }
  haptics::ProxyStep step(const haptics::TouchScene& scene, const haptics::TouchState&,
                          haptics::ProxyState& state,
                          const haptics::ProxyInput& input) const noexcept override {
    const volume::Frame& frame = scene.base->frame;
    haptics::ProxyStep result;
    result.normal_world = dvec3(0);
    const dvec3 hip = frame.volume_from_world(input.hip_world);
    if (!state.has_proxy) {
      state.begin_at(hip);
      result.proxy_world = input.hip_world;
      result.path_volume[0] = hip;
      result.waypoint_count = 1;
      return result;
    }
    const auto cast = [&](const dvec3& a, const dvec3& b, haptics::FacetHit& hit) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      RTCRayHit ray{};
      const dvec3 direction = b - a;
      ray.ray.org_x = static_cast<float>(a.x), ray.ray.org_y = static_cast<float>(a.y),
      ray.ray.org_z = static_cast<float>(a.z);
      ray.ray.dir_x = static_cast<float>(direction.x), ray.ray.dir_y = static_cast<float>(direction.y),
      ray.ray.dir_z = static_cast<float>(direction.z);
      ray.ray.tnear = 0, ray.ray.tfar = 1, ray.ray.mask = ~0u;
      ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene_, &context, &ray);
      ++result.counters.triangles;
      if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
      const dvec3 out(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z);
      if (glm::dot(out, direction) >= 0) return false;  // only the front
      hit.t = static_cast<double>(ray.ray.tfar);
      hit.normal_world = glm::normalize(frame.gradient_world_from_volume(out));
      hit.shape = 0, hit.side = haptics::Side::front;
      return true;
    };
    const glm::dvec3& spacing = frame.spacing();
    const double gap = 1e-3 * std::min({spacing.x, spacing.y,
                                        spacing.z});  // mm, larger than the rounding of single precision
    haptics::PathFacets facets;
    const int landing =
        haptics::move_god_object(frame, input.hip_world, state.proxy_volume, gap, cast, facets, result);
    const auto is_blocked = [&](const dvec3& a, const dvec3& b) {
      haptics::FacetHit hit;
      return cast(a, b, hit);
    };
    haptics::end_with_friction(frame, scene, input.hip_world, landing, &facets, is_blocked, state, result);
    return result;
  }

 private:
  /// In the volume's frame.
  struct Triangles {
    std::vector<glm::vec3> vertices;
    std::vector<std::uint32_t> triangles;
  };
  static Triangles of_shape(const haptics::TouchItem& shape) {
    const volume::Mesh net = volume::surface_net({&shape.field, nullptr, shape.bits.get()});
    return {{net.vertices.span().begin(), net.vertices.span().end()},
            {net.triangles.span().begin(), net.triangles.span().end()}};
  }
  static Triangles of_model(const haptics::TouchScene& scene) {
    const haptics::TouchItem& item = scene.items[0];
    Triangles model;
    for (const dvec3& v : item.tree->vertices())
      model.vertices.emplace_back(scene.base->frame.volume_from_world(item.placement.world_from_local(v)));
    model.triangles = item.tree->triangles();
    return model;
  }

  RTCDevice device_;
  RTCScene scene_ = nullptr;
};

}  // namespace

Peer embree_peer() {
  return {EmbreeProxy::k_info, RTC_VERSION_STRING, false,
          [] { return std::unique_ptr<haptics::ProxyMethod>(std::make_unique<EmbreeProxy>()); }};
}

namespace {

/// A scene of triangles, and the least of three build times.
struct Built {
  RTCDevice device;
  RTCScene scene = nullptr;
  double ms = 1e300;

  Built(const float* vertices, long vertex_count, const unsigned* triangles, long triangle_count)
      : device(rtcNewDevice(nullptr)) {
    for (int run = 0; run < 3; ++run) {
      if (scene) rtcReleaseScene(scene);
      const auto begin = Clock::now();
      scene = rtcNewScene(device);
      rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
      RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
      auto* to = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                             RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                             static_cast<std::size_t>(vertex_count)));
      std::copy_n(vertices, 3 * vertex_count, to);
      auto* corners = static_cast<unsigned*>(
          rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned),
                                  static_cast<std::size_t>(triangle_count)));
      std::copy_n(triangles, 3 * triangle_count, corners);
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene, geometry);
      rtcReleaseGeometry(geometry);
      rtcCommitScene(scene);
      ms = std::min(ms, 1e3 * seconds_since(begin));
    }
  }
  ~Built() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Built(const Built&) = delete;
  Built& operator=(const Built&) = delete;
};

}  // namespace

double embree_build_ms(const float* vertices, long vertex_count, const unsigned* triangles,
                       long triangle_count) {
  return Built(vertices, vertex_count, triangles, triangle_count).ms;
}

double embree_images(const float* vertices, long vertex_count, const unsigned* triangles, long triangle_count,
                     const double* middle, double edge, int pixels, double& images_ms, float* depths) {
  const Built built(vertices, vertex_count, triangles, triangle_count);
  images_ms = 1e300;
  for (int run = 0; run < 3; ++run) {
    const auto begin = Clock::now();
    parallel_for(6 * pixels, 0, [&](int line) {
      const int camera = line / pixels, row = line % pixels, axis = camera / 2, u = (axis + 1) % 3,
                v = (axis + 2) % 3;
      const double sign = camera % 2 == 0 ? 1 : -1;
      for (int column = 0; column < pixels; ++column) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRayHit ray{};
        double from[3], along[3] = {0, 0, 0};
        from[axis] = middle[axis] - 0.5 * sign * edge;
        from[u] = middle[u] + edge * ((column + 0.5) / pixels - 0.5);
        from[v] = middle[v] + edge * ((row + 0.5) / pixels - 0.5);
        along[axis] = sign;
        ray.ray.org_x = static_cast<float>(from[0]), ray.ray.org_y = static_cast<float>(from[1]),
        ray.ray.org_z = static_cast<float>(from[2]);
        ray.ray.dir_x = static_cast<float>(along[0]), ray.ray.dir_y = static_cast<float>(along[1]),
        ray.ray.dir_z = static_cast<float>(along[2]);
        ray.ray.tnear = 0, ray.ray.tfar = static_cast<float>(edge), ray.ray.mask = ~0u;
        ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(built.scene, &context, &ray);
        depths[static_cast<std::size_t>(line) * static_cast<std::size_t>(pixels) +
               static_cast<std::size_t>(column)] = ray.ray.tfar;
      }
    });
    images_ms = std::min(images_ms, 1e3 * seconds_since(begin));
  }
  return built.ms;
}

}  // namespace trephine::bench
