#include "haptics/proxy/friction.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::haptics {

using glm::dvec3;

FrictionLoad friction_load(const HoldingWalls& walls, const dvec3& pull) noexcept {
  const auto normal = [&](int i) -> const dvec3& { return walls.normals[static_cast<std::size_t>(i)]; };
  const auto friction = [&](int i) { return walls.friction[static_cast<std::size_t>(i)]; };
  const double tolerance = 1e-9 * glm::length(pull);
  // Tries sets of one, two and three walls that bear the pull; the remainder must not press on any other
  // wall.
  const auto is_remainder = [&](const dvec3& remainder) {
    for (int k = 0; k < walls.count; ++k)
      if (glm::dot(remainder, normal(k)) > tolerance) return false;
    return true;
  };
  for (int i = 0; i < walls.count; ++i) {
    const double press = glm::dot(pull, normal(i));
    if (press <= 0) continue;
    const dvec3 remainder = pull - press * normal(i);
    if (is_remainder(remainder)) return {glm::length(remainder), friction(i) * press};
  }
  for (int i = 0; i < walls.count; ++i)
    for (int j = i + 1; j < walls.count; ++j) {
      const double c = glm::dot(normal(i), normal(j)), s = 1 - c * c;
      if (s < 1e-8) continue;
      const double pi = glm::dot(pull, normal(i)), pj = glm::dot(pull, normal(j));
      const double a = (pi - c * pj) / s, b = (pj - c * pi) / s;
      if (a < 0 || b < 0) continue;
      const dvec3 remainder = pull - a * normal(i) - b * normal(j);
      if (is_remainder(remainder)) return {glm::length(remainder), friction(i) * a + friction(j) * b};
    }
  for (int i = 0; i < walls.count; ++i)
    for (int j = i + 1; j < walls.count; ++j)
      for (int k = j + 1; k < walls.count; ++k) {
        const dvec3 jk = glm::cross(normal(j), normal(k)), ki = glm::cross(normal(k), normal(i)),
                    ij = glm::cross(normal(i), normal(j));
        const double volume = glm::dot(normal(i), jk);
        if (!(std::abs(volume) > 1e-8)) continue;
        const double a = glm::dot(pull, jk) / volume, b = glm::dot(pull, ki) / volume,
                     c = glm::dot(pull, ij) / volume;
        if (a >= 0 && b >= 0 && c >= 0) return {0, friction(i) * a + friction(j) * b + friction(k) * c};
      }
  return {glm::length(pull), 0};
}

namespace {

double coefficient(const TouchScene& scene, int shape, Side side, bool is_static) noexcept {
  const Material& material = material_of(scene, shape, side);
  return is_static ? material.static_friction : material.dynamic_friction;
}

}  // namespace

dvec3 apply_facet_friction(const volume::Frame& frame, const TouchScene& scene, const dvec3& hip_world,
                           int landing, const PathFacets& facets, ProxyStep& step,
                           bool& is_sticking) noexcept {
  const auto waypoint = [&step](int i) -> dvec3& { return step.path_volume[static_cast<std::size_t>(i)]; };
  const auto load_at = [&](const LegFacets& leg, const dvec3& p, bool is_static) {
    HoldingWalls walls;
    for (std::size_t k = 0; k < static_cast<std::size_t>(leg.count); ++k)
      walls.add(-leg.normals[k], coefficient(scene, leg.shapes[k], leg.sides[k], is_static));
    return friction_load(walls, hip_world - frame.world_from_volume(p));
  };
  const int first = std::min(landing, step.waypoint_count - 1);
  const dvec3 spacing = frame.spacing();
  // Length in mm. Shorter legs, such as those within the gap before facets, do not count as a slide.
  const double min_slide = 1e-3 * std::min({spacing.x, spacing.y, spacing.z});
  bool may_stick = is_sticking;
  is_sticking = false;
  double slid = 0;
  for (int i = first; i + 1 < step.waypoint_count; ++i) {
    const LegFacets& leg = facets[static_cast<std::size_t>(i)];
    const dvec3 begin = waypoint(i), motion = waypoint(i + 1) - begin;
    const double length = glm::length(frame.vector_world_from_volume(motion));
    const bool is_short = slid + length < min_slide && i + 2 < step.waypoint_count;
    if (const FrictionLoad load = load_at(leg, begin, may_stick); !is_short && load.is_held()) {
      is_sticking = slid < min_slide && load.is_at_rest(may_stick);
      step.waypoint_count = i + 1;
      return begin;
    }
    const auto excess = [&](double t) {
      const FrictionLoad load = load_at(leg, begin + t * motion, false);
      return load.along - load.limit;
    };
    if (!is_short && excess(1) <= 0) {
      // Along one facet or one groove the load decreases monotonically: bisection finds the point at which
      // friction holds it.
      double low = 0, high = 1;
      constexpr int k_halvings = 20;
      for (int k = 0; k < k_halvings; ++k) {
        const double middle = 0.5 * (low + high);
        (excess(middle) > 0 ? low : high) = middle;
      }
      waypoint(i + 1) = begin + high * motion;
      step.waypoint_count = i + 2;
      return waypoint(i + 1);
    }
    if (!is_short) may_stick = false;
    slid += length;
  }
  return waypoint(step.waypoint_count - 1);
}

dvec3 apply_friction(const volume::Frame& frame, const Material& material, const dvec3& hip_world,
                     int landing, ProxyStep& step, bool& is_sticking) noexcept {
  const auto waypoint = [&step](int i) -> dvec3& { return step.path_volume[static_cast<std::size_t>(i)]; };
  const dvec3& normal = step.normal_world;
  const auto tangential = [&normal](const dvec3& v) { return glm::length(v - glm::dot(v, normal) * normal); };
  const dvec3 ideal_world = frame.world_from_volume(waypoint(step.waypoint_count - 1));
  const double depth = std::max(0.0, glm::dot(ideal_world - hip_world, normal));
  const double slide = tangential(ideal_world - frame.world_from_volume(waypoint(0)));
  is_sticking = slide <= (is_sticking ? material.static_friction : material.dynamic_friction) * depth;

  const int first = std::min(landing, step.waypoint_count - 1);
  if (is_sticking) {
    step.waypoint_count = first + 1;
    return waypoint(first);
  }
  double retreat = material.dynamic_friction * depth;
  while (step.waypoint_count - 1 > first && retreat > 0) {
    dvec3& end = waypoint(step.waypoint_count - 1);
    const dvec3 begin = waypoint(step.waypoint_count - 2);
    const double length = tangential(frame.vector_world_from_volume(end - begin));
    if (length > retreat) {
      end = begin + (1 - retreat / length) * (end - begin);
      break;
    }
    retreat -= length;
    --step.waypoint_count;
  }
  return waypoint(step.waypoint_count - 1);
}

int landing_of_first_leg(const ProxyStep& step) noexcept {
  if (step.waypoint_count < 2) return 0;
  const dvec3 drop = step.path_volume[1] - step.path_volume[0];
  constexpr double k_support = 0.1;  // voxels; a longer first leg leads to the surface
  return glm::dot(drop, drop) > k_support * k_support ? 1 : 0;
}

}  // namespace trephine::haptics
