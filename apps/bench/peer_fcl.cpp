// FCL: a ball moved by its distance to the whole surface (conservative advancement), then along the plane of
// the nearest point.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#include <glm/geometric.hpp>

#include "apps/bench/measure.h"
#include "apps/bench/peers.h"
#include "haptics/mesh/mesh_tree.h"
#include "volume/surface/surface_nets.h"

namespace trephine::bench {

namespace {

using glm::dvec3;
using Model = fcl::BVHModel<fcl::OBBRSSd>;

class FclProxy final : public haptics::ProxyMethod {
 public:
  static constexpr haptics::MethodInfo k_info{
      .name = "FCL",
      .meaning = "a ball moved by distance queries to the whole surface",
      .source = "Pan, Chitta and Manocha 2012",
      .solid = haptics::MethodInfo::Solid::nothing,
      .takes_ball = true,
      .takes_cuts = false,
      .takes_meshes = true};
  const haptics::MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const haptics::TouchScene& scene) override {
    const bool is_model = scene.items.size() == 1 && scene.items[0].is_mesh();
    haptics::MethodInfo takes = k_info;
    takes.takes_ball = !is_model;
    takes.takes_meshes = is_model;
    if (Status error = haptics::check_touchable(scene, takes)) return error;
    const haptics::TouchItem& shape = scene.items[0];
    const volume::Frame& frame = scene.base->frame;
    std::vector<fcl::Vector3d> vertices;
    std::vector<fcl::Triangle> triangles;
    const auto add = [&](const auto& corners) {
      for (std::size_t t = 0; t + 2 < corners.size(); t += 3)
        triangles.emplace_back(corners[t], corners[t + 1], corners[t + 2]);
    };
    if (is_model) {
      for (const dvec3& v : shape.tree->vertices()) {
        const dvec3 p = shape.placement.world_from_local(v);
        vertices.emplace_back(p.x, p.y, p.z);
      }
      add(shape.tree->triangles());
    } else {
      const volume::Mesh net = volume::surface_net({&shape.field, nullptr, shape.bits.get()});
      for (std::size_t i = 0; i < net.vertices.size(); ++i) {
        const dvec3 p = frame.world_from_volume(dvec3(net.vertices[i]));
        vertices.emplace_back(p.x, p.y, p.z);
      }
      add(net.triangles);
    }
    auto model = std::make_shared<Model>();
    model->beginModel();
    model->addSubModel(vertices, triangles);
    model->endModel();
    model_ = model;
    return std::nullopt;
  }
  haptics::ProxyStep step(const haptics::TouchScene& scene, const haptics::TouchState&,
                          haptics::ProxyState& state,
                          const haptics::ProxyInput& input) const noexcept override {
    const volume::Frame& frame = scene.base->frame;
    haptics::ProxyStep result;
    result.normal_world = dvec3(0);
    const double radius = std::max(scene.tool->radius(), 0.01), near = 0.01;
    const fcl::Sphered ball(radius);
    const auto distance_at = [&](const dvec3& p, dvec3& normal) {
      fcl::Transform3d place = fcl::Transform3d::Identity();
      place.translation() = fcl::Vector3d(p.x, p.y, p.z);
      fcl::DistanceRequestd request(true);
      fcl::DistanceResultd answer;
      ++result.counters.iterations;
      const double d =
          fcl::distance(&ball, place, model_.get(), fcl::Transform3d::Identity(), request, answer);
      const fcl::Vector3d& q = answer.nearest_points[1];
      const dvec3 off = p - dvec3(q.x(), q.y(), q.z());
      normal = glm::length(off) > 0 ? glm::normalize(off) : dvec3(0, 0, 1);
      return d;
    };
    dvec3 at = state.has_proxy ? frame.world_from_volume(state.proxy_volume) : input.hip_world,
          target = input.hip_world;
    if (!state.has_proxy) at = target;
    for (int plane = 0; state.has_proxy && plane < 3; ++plane) {
      const dvec3 motion = target - at;
      const double length = glm::length(motion);
      double t = 0;
      dvec3 normal(0);
      bool is_blocked = false;
      for (int i = 0; i < 20 && t < 1 && length > 0; ++i) {
        const double d = distance_at(at + t * motion, normal);
        if (d <= near && glm::dot(normal, motion) < -1e-6 * length) {
          is_blocked = true;
          break;
        }
        t = std::min(1.0, t + std::max(d, 0.5 * near) / length);
      }
      at += t * motion;
      if (!is_blocked) break;
      result.has_contact = true;
      result.shape = 0, result.side = haptics::Side::front;
      result.normal_world = normal;
      target = input.hip_world + glm::dot(at - input.hip_world, normal) * normal;
      if (glm::length(target - at) < 1e-4) break;
    }
    result.path_volume[0] = state.has_proxy ? state.proxy_volume : frame.volume_from_world(at);
    result.path_volume[1] = frame.volume_from_world(at);
    result.waypoint_count = 2;
    state.has_proxy = true;
    state.had_contact = result.has_contact;
    state.proxy_volume = result.path_volume[1];
    result.proxy_world = at;
    return result;
  }

 private:
  std::shared_ptr<const Model> model_;
};

std::shared_ptr<Model> model_of(const PeerMesh& mesh) {
  std::vector<fcl::Vector3d> vertices;
  std::vector<fcl::Triangle> triangles;
  for (long v = 0; v < mesh.vertex_count; ++v)
    vertices.emplace_back(mesh.vertices[3 * v], mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]);
  for (long t = 0; t < mesh.triangle_count; ++t)
    triangles.emplace_back(mesh.triangles[3 * t], mesh.triangles[3 * t + 1], mesh.triangles[3 * t + 2]);
  auto model = std::make_shared<Model>();
  model->beginModel();
  model->addSubModel(vertices, triangles);
  model->endModel();
  return model;
}

}  // namespace

void fcl_collide(const PeerMesh& tool, const PeerMesh& scene, const double* poses, long count, double* us) {
  const std::shared_ptr<Model> moving = model_of(tool), fixed = model_of(scene);
  for (long i = 0; i < count; ++i) {
    const double* p = poses + 7 * i;
    fcl::Transform3d place = fcl::Transform3d::Identity();
    place.linear() = Eigen::Quaterniond(p[3], p[4], p[5], p[6]).toRotationMatrix();
    place.translation() = fcl::Vector3d(p[0], p[1], p[2]);
    const auto start = Clock::now();
    fcl::CollisionRequestd request(100, true);
    fcl::CollisionResultd answer;
    fcl::collide(moving.get(), place, fixed.get(), fcl::Transform3d::Identity(), request, answer);
    us[i] = 1e6 * seconds_since(start);
  }
}

Peer fcl_peer() {
  return {FclProxy::k_info, FCL_VERSION, true,
          [] { return std::unique_ptr<haptics::ProxyMethod>(std::make_unique<FclProxy>()); }};
}

}  // namespace trephine::bench
