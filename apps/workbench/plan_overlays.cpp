#include "apps/workbench/plan_overlays.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/workbench/bone_rays.h"

namespace trephine::workbench {

namespace {

constexpr double k_lift = 0.8;  // mm; lines on bone are drawn this far outside the bone, to be visible

/// Adds an outline twice, on either side of the bone surface, because the outer side is not known. Bone hides
/// the inner one.
void add_outline(const volume::PlannedOutline& outline, sim::Overlay& overlay) {
  const std::vector<glm::dvec3>& points = outline.points_world;
  glm::dvec3 normal(0);  // of the outline's mean plane; its length is twice the area
  for (std::size_t i = 0; i < points.size(); ++i)
    normal += glm::cross(points[i] - points[0], points[(i + 1) % points.size()] - points[0]);
  const double twice_area = glm::length(normal);
  const glm::dvec3 lift = twice_area > 0 ? k_lift / twice_area * normal : glm::dvec3(0);
  for (const double side : {-1.0, 1.0})
    for (std::size_t i = 0; i < points.size(); ++i)
      overlay.lines.push_back({points[i] + side * lift, points[(i + 1) % points.size()] + side * lift});
  overlay.labels.push_back({points[0], outline.name});
}

}  // namespace

sim::Overlays plan_overlays(const volume::SurgicalPlan& plan, const haptics::TouchScene& scene) {
  constexpr double k_before = 20, k_cross = 3;  // mm
  constexpr int k_corners = 24;
  sim::Overlay overlay;
  const std::shared_ptr<const volume::Version> uncut = haptics::uncut_version(scene);
  for (const volume::PlannedTrajectory& t : plan.trajectories) {
    const glm::dvec3 outward = glm::normalize(t.entry_world - t.target_world);
    const glm::dvec3 begin = t.entry_world + k_before * outward;
    overlay.lines.push_back({begin, t.target_world});
    overlay.labels.push_back({begin, t.name});
    // A ring around the entry, on the bone, and one around the target, with the planned diameter.
    const glm::dvec3 axis_u = glm::normalize(
        glm::cross(outward, std::abs(outward.x) < 0.8 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const glm::dvec3 axis_v = glm::cross(outward, axis_u);
    const double radius = t.diameter > 0 ? 0.5 * t.diameter : 0.5 * k_cross;
    const auto on_ring = [&](int corner) {
      const double angle = corner * 2 * 3.14159265358979323846 / k_corners;
      return radius * (std::cos(angle) * axis_u + std::sin(angle) * axis_v);
    };
    const double reach = radius + 4;  // mm; the bone is searched to this distance from the plane of the ring
    std::array<glm::dvec3, k_corners> ring;
    for (int corner = 0; corner < k_corners; ++corner) {
      const glm::dvec3 at = t.entry_world + on_ring(corner), outside = at + reach * outward;
      const double hit = first_surface(scene, *uncut, outside, at - reach * outward);
      ring[static_cast<std::size_t>(corner)] =
          hit > 0 ? outside + (k_lift - 2 * reach * hit) * outward : at + k_lift * outward;
    }
    for (std::size_t i = 0; i < ring.size(); ++i)
      overlay.lines.push_back({ring[i], ring[(i + 1) % k_corners]});
    for (int corner = 0; corner < k_corners; ++corner)
      overlay.lines.push_back({t.target_world + on_ring(corner), t.target_world + on_ring(corner + 1)});
  }
  for (const volume::PlannedLandmark& l : plan.landmarks) {
    for (int a = 0; a < 3; ++a) {
      glm::dvec3 arm(0);
      arm[a] = k_cross;
      overlay.lines.push_back({l.position_world - arm, l.position_world + arm});
    }
    overlay.labels.push_back({l.position_world, l.name});
  }
  for (const volume::PlannedOutline& outline : plan.outlines) add_outline(outline, overlay);
  return overlay.lines.empty() ? sim::Overlays{} : sim::Overlays{std::move(overlay)};
}

}  // namespace trephine::workbench
