#include "apps/cli/audit/friction_audit.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "apps/bench/scenes/guaranteed_solid.h"
#include "apps/verify/friction_judge.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/methods/methods.h"

namespace trephine::cli {

using glm::dvec3;

namespace {

constexpr double k_on_surface = 2e-3;      // voxels; a point this far below the proxy must be solid
constexpr double k_leap_mm = 1;            // a longer motion of hand or proxy in a tick is not judged
constexpr double k_model_reach_mm = 1;     // models farther away are ignored
constexpr double k_facet_slack_mm = 0.02;  // facets of a model within this distance are walls
constexpr double k_min_mm = 0.05;          // a shorter pull is not judged
constexpr double k_share = 0.04,
                 k_slack_mm = 0.004;  // tolerated pull outside the cone: share of the pull plus mm

}  // namespace

FrictionAudit::Found& FrictionAudit::Found::operator+=(const Found& other) {
  judged += other.judged, slid += other.slid, outside += other.outside;
  slid_with_less += other.slid_with_less;
  worst = std::max(worst, other.worst);
  return *this;
}

void FrictionAudit::set_solid(const std::shared_ptr<const haptics::ServoHand>& hand) {
  const haptics::TouchScene& scene = *hand->scene;
  solids_.clear();
  is_new_ = true;
  if (scene_ != hand->scene) {
    scene_ = hand->scene;
    models_.clear();
    for (const haptics::TouchItem& item : scene.items)
      if (item.is_mesh() && !item.depth) models_.push_back({wall_of(*item.tree), {}, scene.tool->radius()});
  }
  const std::size_t shapes = base_shapes(scene).size();
  if (shapes + models_.size() != scene.items.size() || scene.tool->is_six_dof()) return;
  const auto blocks = [&](std::size_t i) {
    return haptics::blocks(scene.items[i].sides, haptics::Side::front) &&
           !(hand->untouchable | hand->passable_items).contains(static_cast<int>(i));
  };
  for (std::size_t i = 0; i < models_.size(); ++i) {
    const haptics::TouchItem& item = scene.items[shapes + i];
    models_[i].blocks = blocks(shapes + i);
    const auto mover = static_cast<std::size_t>(item.mover);
    models_[i].placement =
        item.mover >= 0 && mover < hand->placement_count ? hand->placements[mover] : item.placement;
  }
  if (haptics::find_method(hand->method->name())->solid != haptics::MethodInfo::Solid::smooth) return;
  const auto state = std::shared_ptr<const haptics::TouchState>(hand, &hand->state);
  for (std::size_t s = 0; s < shapes; ++s) {
    if (!blocks(s)) continue;
    const auto offset = scenes::touch_offset_field(scene, state.get(), s);
    solids_.push_back(
        {scenes::touched_smooth_solid(scene, state, s), offset ? offset->frame() : scene.base->frame});
  }
}

void FrictionAudit::judge(const haptics::ServoRecord& r, const haptics::Material& material,
                          const dvec3& pull) {
  const dvec3 last = std::exchange(last_, r.proxy_world);
  const double hand_moved =
      glm::length(r.pose.position_world - std::exchange(last_hand_, r.pose.position_world));
  const double moved = glm::length(r.proxy_world - last);
  const bool is_new = std::exchange(is_new_, false);
  if (solids_.empty() || r.side != haptics::Side::front || !(glm::length(pull) > k_min_mm)) {
    is_new_ = true;
    return;
  }
  // Do not judge leaps: after a leap of the hand the proxy follows over several ticks, because the number of
  // segments per tick is bounded.
  if (hand_moved > k_leap_mm || moved > k_leap_mm) return;
  const dvec3 mm = solids_[0].frame.spacing();
  const double voxel = std::min({mm.x, mm.y, mm.z}), step = 0.002 * voxel;
  // Intensities and distances to cuts are compared in mm: each field is divided by its slope at the proxy.
  std::vector<std::vector<double>> slopes;
  double sample = 0, nearest = 1e300;  // sample: spacing of the touched field's samples, mm
  for (const Solid& solid : solids_) {
    slopes.emplace_back();
    for (std::size_t f = 0; f < solid.solid.field_count(); ++f) {
      const auto value = [&](const dvec3& p) {
        return solid.solid.value(f, solid.frame.volume_from_world(p));
      };
      dvec3 slope;
      for (int a = 0; a < 3; ++a) {
        dvec3 offset(0);
        offset[a] = step;
        slope[a] = (value(r.proxy_world + offset) - value(r.proxy_world - offset)) / (2 * step);
      }
      slopes.back().push_back(std::max(glm::length(slope), 1e-9));
      const double distance = std::abs(value(r.proxy_world)) / slopes.back().back();
      if (distance > nearest) continue;
      const dvec3 spacing = mm / dvec3(solid.solid.per_voxel(f));
      nearest = distance, sample = std::max({spacing.x, spacing.y, spacing.z});
    }
  }
  const auto depth = [&](const dvec3& p) {
    double deepest = -1e300;
    for (std::size_t s = 0; s < solids_.size(); ++s) {
      const dvec3 p_volume = solids_[s].frame.volume_from_world(p);
      double least = 1e300;
      for (std::size_t f = 0; f < slopes[s].size(); ++f)
        least = std::min(least, solids_[s].solid.value(f, p_volume) / slopes[s][f]);
      deepest = std::max(deepest, least);
    }
    for (const Model& model : models_) {
      if (!model.blocks) continue;
      const double reach = model.radius + k_model_reach_mm;
      deepest =
          std::max(deepest, model.radius - model.wall->distance(model.placement.local_from_world(p), reach));
    }
    return deepest;
  };
  auto walls = verify::walls_at(depth, r.proxy_world, step, 0);
  // Skip a proxy that is about to leave the surface over an edge.
  if (walls.empty() || depth(r.proxy_world - k_on_surface * voxel * walls[0]) < 0) return;
  ++found_.judged;
  const double allowed = k_share * glm::length(pull) + k_slack_mm;
  double excess = verify::distance_from_cone(pull, walls, material.static_friction);
  if (excess > allowed) {
    walls = verify::walls_at(depth, r.proxy_world, step, 2 * sample);
    add_facets(r.proxy_world, walls);
    excess = verify::distance_from_cone(pull, walls, material.static_friction);
  }
  found_.worst = std::max(found_.worst, excess / glm::length(pull));
  found_.outside += excess > allowed;
  // A proxy that slid comes to rest where the cone of the dynamic coefficient just holds it. Skip proxies
  // that did not slide along one wall, and those that passed over an edge and so left the surface on their
  // path.
  if (is_new || walls.size() != 1 || !(moved > 1e-3) || moved > 2 * hand_moved + k_slack_mm) return;
  const double press = -glm::dot(pull, walls[0]), along = glm::length(pull + press * walls[0]);
  ++found_.slid;
  found_.slid_with_less += along < material.dynamic_friction * press * (1 - 2 * k_share) - k_slack_mm;
}

void FrictionAudit::add_facets(const dvec3& proxy_world, std::vector<dvec3>& walls) const {
  for (const Model& model : models_) {
    const dvec3 p = model.placement.local_from_world(proxy_world);
    if (!model.blocks ||
        std::abs(model.wall->distance(p, k_model_reach_mm + model.radius) - model.radius) > k_facet_slack_mm)
      continue;
    for (const dvec3& push : model.wall->pushes_near(p, k_facet_slack_mm, k_model_reach_mm + model.radius))
      walls.push_back(model.placement.rotation * push);
  }
}

std::shared_ptr<const verify::MeshWall> FrictionAudit::wall_of(const haptics::MeshTree& tree) {
  const dvec3 size = tree.high() - tree.low();
  return std::make_shared<verify::MeshWall>(tree.vertices(), tree.triangles(),
                                            std::max({size.x, size.y, size.z, 1e-3}) / 32);
}

dvec3 FrictionAudit::planted(const dvec3& pull, const dvec3& normal, double coefficient) {
  const dvec3 axis = std::abs(normal.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0);
  return (0.2 + 1.2 * coefficient) * glm::length(pull) * glm::normalize(glm::cross(normal, axis));
}

}  // namespace trephine::cli
