#include "apps/workbench/plan_overlays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>

#include "apps/workbench/bone_rays.h"

namespace trephine::workbench {

namespace {

constexpr double k_lift = 0.8;  // mm; lines on bone are drawn this far outside the bone, to be visible

/// Moves points along `outward` (unit) to the uncut surface of the bone, as seen from outside, if it is
/// within `reach` of them, and lifts them off it. Returns the mean distance from the points to the surface;
/// `reach` for a point without a surface.
double drape(std::span<glm::dvec3> points, const glm::dvec3& outward, double reach,
             const haptics::TouchScene& scene, const volume::Version& uncut) {
  double sum = 0;
  for (glm::dvec3& p : points) {
    const double hit = first_surface(scene, uncut, p + reach * outward, p - reach * outward);
    const double height = hit > 0 ? reach - 2 * reach * hit : 0;  // of the surface above p
    sum += hit > 0 ? std::abs(height) : reach;
    p += (height + k_lift) * outward;
  }
  return points.empty() ? 0 : sum / static_cast<double>(points.size());
}

/// Adds an outline on the surface of the bone. Its outer side is the one from which the surface is nearer to
/// the points.
void add_outline(const volume::PlannedOutline& outline, const haptics::TouchScene& scene,
                 const volume::Version& uncut, sim::Overlay& overlay) {
  constexpr double k_step = 2, k_reach = 8;  // mm
  const std::vector<glm::dvec3>& corners = outline.points_world;
  glm::dvec3 normal(0);  // of the outline's mean plane
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 edge = corners[(i + 1) % corners.size()] - corners[i];
    normal += glm::cross(corners[i] - corners[0], corners[i] + edge - corners[0]);
    const int parts = std::max(1, static_cast<int>(std::ceil(glm::length(edge) / k_step)));
    for (int k = 0; k < parts; ++k) points.push_back(corners[i] + (k / static_cast<double>(parts)) * edge);
  }
  normal = glm::length(normal) > 0 ? glm::normalize(normal) : glm::dvec3(0, 0, 1);
  std::vector<glm::dvec3> other = points;
  if (drape(points, normal, k_reach, scene, uncut) > drape(other, -normal, k_reach, scene, uncut))
    points.swap(other);
  for (std::size_t i = 0; i < points.size(); ++i)
    overlay.lines.push_back({points[i], points[(i + 1) % points.size()]});
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
    std::array<glm::dvec3, k_corners> ring;
    for (int corner = 0; corner < k_corners; ++corner)
      ring[static_cast<std::size_t>(corner)] = t.entry_world + on_ring(corner);
    drape(ring, outward, radius + 4, scene, *uncut);
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
  for (const volume::PlannedOutline& outline : plan.outlines) add_outline(outline, scene, *uncut, overlay);
  return overlay.lines.empty() ? sim::Overlays{} : sim::Overlays{std::move(overlay)};
}

}  // namespace trephine::workbench
