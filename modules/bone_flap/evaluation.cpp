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

/// The plane across a flap's normal.
struct Plane {
  dvec3 middle, normal, right, up;
  explicit Plane(const FlapWorld& flap) : middle(flap.centre), normal(flap.normal) {
    beside(normal, right, up);
  }
  dvec2 operator()(const dvec3& p) const { return {glm::dot(p - middle, right), glm::dot(p - middle, up)}; }
};

std::vector<dvec2> flat(const FlapWorld& flap, const Plane& plane) {
  std::vector<dvec2> all;
  for (const dvec3& p : flap.outline) all.push_back(plane(p));
  return all;
}

template <class Point>
double distance_to(const std::vector<Point>& loop, const Point& p) {
  double least = 1e300;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Point &a = loop[i], edge = loop[(i + 1) % loop.size()] - a;
    const double length = glm::dot(edge, edge);
    const double t = length > 0 ? std::clamp(glm::dot(p - a, edge) / length, 0.0, 1.0) : 0;
    const Point off = p - a - t * edge;
    least = std::min(least, glm::dot(off, off));
  }
  return std::sqrt(least);
}

}  // namespace

OutlineShape shape_of(const FlapWorld& flap) {
  OutlineShape shape;
  if (flap.outline.size() < 3) return shape;
  const std::vector<dvec2> loop = flat(flap, Plane(flap));
  double twice = 0, around = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::size_t next = (i + 1) % loop.size();
    shape.perimeter += glm::length(flap.outline[next] - flap.outline[i]);
    around += glm::length(loop[next] - loop[i]);
    twice += loop[i].x * loop[next].y - loop[next].x * loop[i].y;
  }
  shape.roundness = 4 * k_pi * 0.5 * std::abs(twice) / (around * around);
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

Cover cover_of(const FlapWorld& flap, const volume::Volume& scan, int label) {
  Cover cover;
  if (scan.labels.is_empty() || flap.outline.size() < 3) return cover;
  const Plane plane(flap);
  const std::vector<dvec2> loop = flat(flap, plane);
  // Its shadow, in squares as large as the finest voxels.
  const dvec3& h = scan.frame.spacing();
  const double cell = std::min({h.x, h.y, h.z});
  std::set<std::pair<int, int>> shadow;
  cover.depth = 1e300;
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        if (scan.labels[scan.index(x, y, z)] != label) continue;
        const dvec3 p = scan.frame.world_from_volume(dvec3(x, y, z));
        const dvec2 at = plane(p) / cell;
        shadow.emplace(static_cast<int>(std::floor(at.x)), static_cast<int>(std::floor(at.y)));
        cover.depth = std::min(cover.depth, glm::dot(plane.middle - p, plane.normal));
      }
  if (shadow.empty()) return {};
  cover.is_any = true;
  cover.margin = 1e300;
  std::size_t covered = 0;
  for (const auto& [x, y] : shadow) {
    const dvec2 p = cell * dvec2(x + 0.5, y + 0.5);
    const double edge = distance_to(loop, p);
    const double inside = (is_within(loop, p) ? edge : -edge) - 0.5 * flap.width;
    covered += inside >= 0;
    cover.margin = std::min(cover.margin, inside);
  }
  cover.share = static_cast<double>(covered) / static_cast<double>(shadow.size());
  return cover;
}

OutlineDistance distance_between(const std::vector<dvec3>& one, const std::vector<dvec3>& other) {
  OutlineDistance distance;
  if (one.empty() || other.empty()) return distance;
  const auto look = [&](const std::vector<dvec3>& from, const std::vector<dvec3>& to) {
    // Places a millimetre apart or nearer, so that long sides weigh what they are long.
    double sum = 0, length = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const dvec3 &a = from[i], edge = from[(i + 1) % from.size()] - a;
      const double way = glm::length(edge);
      const int count = std::max(1, static_cast<int>(std::ceil(way)));
      for (int k = 0; k < count; ++k) {
        const double d = distance_to(to, a + (k + 0.5) / count * edge);
        sum += d * way / count;
        distance.worst = std::max(distance.worst, d);
      }
      length += way;
    }
    return length > 0 ? sum / length : 0.0;
  };
  distance.mean = 0.5 * (look(one, other) + look(other, one));
  return distance;
}

OutlineDistance distance_from_plan(const FlapWorld& flap, const std::vector<dvec3>& plan) {
  const auto seen = [&flap](const std::vector<dvec3>& outline) {
    std::vector<dvec3> all;
    const double far = glm::dot(flap.centre - flap.apex, flap.normal);
    for (const dvec3& p : outline) {
      const dvec3 w = p - flap.apex;
      all.push_back(flap.apex + far / std::max(glm::dot(w, flap.normal), 1e-3) * w);
    }
    return all;
  };
  return distance_between(seen(flap.outline), seen(plan));
}

std::vector<Near> nearness_of(const FlapWorld& flap,
                              std::span<const std::shared_ptr<const sim::Forbidden>> forbidden) {
  std::vector<Near> all;
  for (const auto& structure : forbidden) {
    Near near{structure->name(), sim::Forbidden::k_reach, {}, 1.5 * structure->voxel_mm()};
    for (std::size_t i = 0; i < flap.outline.size(); ++i) {
      // The footplate slides along under the bone: the saw's end, round here, reaches the inner table.
      const dvec3 up = flap.outline[i] - flap.floor[i];
      const double length = glm::length(up), lift = std::min(length, k_under_table + 0.5 * flap.width);
      const dvec3 end = length > 0 ? flap.floor[i] + lift / length * up : flap.floor[i];
      const double mm = structure->clearance(flap.outline[i], {end, 0.5 * flap.width}, near.mm);
      if (mm < near.mm) near.mm = mm, near.at_world = end;
    }
    all.push_back(std::move(near));
  }
  return all;
}

}  // namespace trephine::bone_flap
