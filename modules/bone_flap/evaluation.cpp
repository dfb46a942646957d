#include "modules/bone_flap/evaluation.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <set>
#include <utility>

#include "modules/bone_flap/kerf.h"
#include "modules/bone_flap/outline.h"

namespace trephine::bone_flap {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr double k_pi = 3.14159265358979323846;

/// Plane through a flap's centre, perpendicular to its normal.
struct Plane {
  dvec3 middle, normal, right, up;
  explicit Plane(const FlapState& flap) : middle(flap.centre), normal(flap.normal) {
    set_orthogonal_axes(normal, right, up);
  }
  dvec2 operator()(const dvec3& p) const { return {glm::dot(p - middle, right), glm::dot(p - middle, up)}; }
};

std::vector<dvec2> project_outline(const FlapState& flap, const Plane& plane) {
  std::vector<dvec2> points;
  for (const dvec3& p : flap.outline) points.push_back(plane(p));
  return points;
}

template <class Point>
double distance_to(const std::vector<Point>& loop, const Point& p) {
  double least = 1e300;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Point &a = loop[i], edge = loop[(i + 1) % loop.size()] - a;
    const double length = glm::dot(edge, edge);
    const double t = length > 0 ? std::clamp(glm::dot(p - a, edge) / length, 0.0, 1.0) : 0;
    const Point offset = p - a - t * edge;
    least = std::min(least, glm::dot(offset, offset));
  }
  return std::sqrt(least);
}

}  // namespace

OutlineShape shape_of(const FlapState& flap) {
  OutlineShape shape;
  if (flap.outline.size() < 3) return shape;
  const std::vector<dvec2> loop = project_outline(flap, Plane(flap));
  double twice_area = 0, projected_perimeter = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::size_t next = (i + 1) % loop.size();
    shape.perimeter += glm::length(flap.outline[next] - flap.outline[i]);
    projected_perimeter += glm::length(loop[next] - loop[i]);
    twice_area += loop[i].x * loop[next].y - loop[next].x * loop[i].y;
  }
  shape.roundness = 4 * k_pi * 0.5 * std::abs(twice_area) / (projected_perimeter * projected_perimeter);
  dvec2 along(1, 0);
  for (const dvec2& a : loop)
    for (const dvec2& b : loop)
      if (const double far = glm::length(b - a); far > shape.length)
        shape.length = far, along = (b - a) / far;
  double low = 1e300, high = -1e300;
  for (const dvec2& p : loop) {
    const double across = p.y * along.x - p.x * along.y;
    low = std::min(low, across), high = std::max(high, across);
  }
  shape.width = high - low;
  return shape;
}

LabelExposure exposure_of(const FlapState& flap, const volume::Volume& scan, int label) {
  LabelExposure exposure;
  if (scan.labels.is_empty() || flap.outline.size() < 3) return exposure;
  const Plane plane(flap);
  const std::vector<dvec2> loop = project_outline(flap, plane);
  // Rasterize the label's projection in squares of the finest voxel spacing.
  const dvec3& h = scan.frame.spacing();
  const double cell = std::min({h.x, h.y, h.z});
  std::set<std::pair<int, int>> projection;
  exposure.depth = 1e300;
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        if (scan.labels[scan.index(x, y, z)] != label) continue;
        const dvec3 p = scan.frame.world_from_volume(dvec3(x, y, z));
        const dvec2 at = plane(p) / cell;
        projection.emplace(static_cast<int>(std::floor(at.x)), static_cast<int>(std::floor(at.y)));
        exposure.depth = std::min(exposure.depth, glm::dot(plane.middle - p, plane.normal));
      }
  if (projection.empty()) return {};
  exposure.has_label = true;
  exposure.margin = 1e300;
  std::size_t covered = 0;
  for (const auto& [x, y] : projection) {
    const dvec2 p = cell * dvec2(x + 0.5, y + 0.5);
    const double edge = distance_to(loop, p);
    const double inside = (is_within(loop, p) ? edge : -edge) - 0.5 * flap.width;
    covered += inside >= 0;
    exposure.margin = std::min(exposure.margin, inside);
  }
  exposure.share = static_cast<double>(covered) / static_cast<double>(projection.size());
  return exposure;
}

OutlineDistance distance_between(const std::vector<dvec3>& first, const std::vector<dvec3>& second) {
  OutlineDistance distance;
  if (first.empty() || second.empty()) return distance;
  const auto mean_distance = [&](const std::vector<dvec3>& from, const std::vector<dvec3>& to) {
    // Samples are at most 1 mm apart. Each counts by the length that it represents.
    double sum = 0, length = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const dvec3 &a = from[i], edge = from[(i + 1) % from.size()] - a;
      const double side_length = glm::length(edge);
      const int count = std::max(1, static_cast<int>(std::ceil(side_length)));
      for (int k = 0; k < count; ++k) {
        const double d = distance_to(to, a + (k + 0.5) / count * edge);
        sum += d * side_length / count;
        distance.worst = std::max(distance.worst, d);
      }
      length += side_length;
    }
    return length > 0 ? sum / length : 0.0;
  };
  distance.mean = 0.5 * (mean_distance(first, second) + mean_distance(second, first));
  return distance;
}

OutlineDistance distance_from_plan(const FlapState& flap, const std::vector<dvec3>& plan) {
  // If the plan is on another side of the head, its projection onto the plane of the flap has no meaning.
  constexpr double k_least_cosine = 0.5;
  if (std::any_of(plan.begin(), plan.end(), [&flap](const dvec3& p) {
        const dvec3 w = p - flap.apex;
        return glm::dot(w, flap.normal) < k_least_cosine * glm::length(w);
      }))
    return distance_between(flap.outline, plan);
  const auto project = [&flap](const std::vector<dvec3>& outline) {
    std::vector<dvec3> points;
    const double depth = glm::dot(flap.centre - flap.apex, flap.normal);
    for (const dvec3& p : outline) {
      const dvec3 w = p - flap.apex;
      points.push_back(flap.apex + depth / std::max(glm::dot(w, flap.normal), 1e-3) * w);
    }
    return points;
  };
  return distance_between(project(flap.outline), project(plan));
}

std::optional<OutlineDistance> distance_from_nearest(const FlapState& flap,
                                                     const volume::SurgicalPlan& plan) {
  std::optional<OutlineDistance> nearest;
  for (const volume::PlannedOutline& outline : plan.outlines) {
    const OutlineDistance distance = distance_from_plan(flap, outline.points_world);
    if (!nearest || distance.mean < nearest->mean) nearest = distance;
  }
  return nearest;
}

std::vector<StructureClearance> clearances_of(
    const FlapState& flap, std::span<const std::shared_ptr<const sim::Forbidden>> forbidden) {
  std::vector<StructureClearance> clearances;
  if (flap.floor.size() != flap.outline.size()) return clearances;  // cut by hand: the tool reported contacts
  for (const auto& structure : forbidden) {
    StructureClearance clearance{structure->name(), sim::Forbidden::k_reach, {}, 1.5 * structure->voxel_mm()};
    for (std::size_t i = 0; i < flap.outline.size(); ++i) {
      // The footplate slides along the inner table, so the saw ends there. Its end is modelled as a ball.
      const dvec3 up = flap.outline[i] - flap.floor[i];
      const double length = glm::length(up), lift = std::min(length, k_overcut + 0.5 * flap.width);
      const dvec3 end = length > 0 ? flap.floor[i] + lift / length * up : flap.floor[i];
      const double mm = structure->clearance(flap.outline[i], {end, 0.5 * flap.width}, clearance.mm);
      if (mm < clearance.mm) clearance.mm = mm, clearance.at_world = end;
    }
    clearances.push_back(std::move(clearance));
  }
  return clearances;
}

}  // namespace trephine::bone_flap
