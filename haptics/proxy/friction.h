// friction_load(): Coulomb friction: the proxy rests where the pull of the hand is within the friction cone
// of the walls that stop the proxy.
#pragma once

#include "haptics/proxy/proxy_step.h"

namespace trephine::haptics {

/// Walls that stop a tool at one point.
struct HoldingWalls {
  static constexpr int k_max = 6;
  int count = 0;
  std::array<glm::dvec3, k_max> normals;  ///< unit, world, into the solid
  std::array<double, k_max> friction;     ///< coefficients

  void add(const glm::dvec3& normal_into_solid, double coefficient) noexcept {
    if (count == k_max) return;
    normals[static_cast<std::size_t>(count)] = normal_into_solid;
    friction[static_cast<std::size_t>(count++)] = coefficient;
  }
};

/// Parts of a pull on some walls, in mm of the spring's stretch from the proxy to the HIP: along them, and
/// the limit up to which their friction holds.
struct FrictionLoad {
  double along = 0, limit = 0;
  bool is_held() const noexcept { return along <= limit; }
  /// Returns true if the tool sticks. A slide ends on the cone, from where it continues in the next step: a
  /// tool that slid before sticks only if the load is clearly inside the cone.
  bool is_at_rest(bool was_sticking) const noexcept {
    constexpr double k_rest = 0.98;
    return along <= (was_sticking ? 1 : k_rest) * limit;
  }
};

/// Splits a pull into pressures on the walls (factors of their normals, at least 0, that leave the shortest
/// remainder) and the remainder, which is along the walls. Each wall holds its own coefficient times its own
/// pressure: in a groove both walls count.
FrictionLoad friction_load(const HoldingWalls& walls, const glm::dvec3& pull) noexcept;

/// For methods on voxels: shortens step.path_volume, which ends at the frictionless proxy, so that the
/// tangential spring force stays within the cone of `material` at the normal of the path's end. Returns the
/// new proxy: a waypoint, or a point inside the last leg, which the caller checks again, since rounding may
/// have moved it across a voxel's face. The legs up to waypoint `landing` lead down to the surface and stay.
/// Call while contact lasts, not in its first step.
glm::dvec3 apply_friction(const volume::Frame& frame, const Material& material, const glm::dvec3& hip_world,
                          int landing, ProxyStep& step, bool& is_sticking) noexcept;

/// Facets along which a leg of a path leads.
struct LegFacets {
  int count = 0;
  static constexpr int k_max = 3;
  std::array<glm::dvec3, k_max> normals;  ///< unit, world, toward the tool
  std::array<int, k_max> shapes;
  std::array<Side, k_max> sides;

  void add(const glm::dvec3& normal, int shape, Side side) noexcept {
    if (count == k_max) {
      for (std::size_t i = 1; i < normals.size(); ++i)
        normals[i - 1] = normals[i], shapes[i - 1] = shapes[i], sides[i - 1] = sides[i];
      --count;
    }
    const auto i = static_cast<std::size_t>(count++);
    normals[i] = normal, shapes[i] = shape, sides[i] = side;
  }
};
/// Facets of the legs that begin at each waypoint of a path.
using PathFacets = std::array<LegFacets, k_max_waypoints>;

/// For methods on facets, with straight legs: finds the first point of the path, from waypoint `landing` on,
/// at which the facets of its leg hold the pull. Shortens the path to it and returns it, to be checked again
/// as above.
glm::dvec3 apply_facet_friction(const volume::Frame& frame, const TouchScene& scene,
                                const glm::dvec3& hip_world, int landing, const PathFacets& facets,
                                ProxyStep& step, bool& is_sticking) noexcept;

/// Returns the landing for methods that lead their first leg down to a surface that fell away from under the
/// proxy: 1 if the leg is longer than a tenth of a voxel, twice the lift of a step; else 0.
int landing_of_first_leg(const ProxyStep& step) noexcept;

/// Ends a step at its path's last waypoint: applies friction along the path, tests the leg that friction
/// shortened, and sets the state for the next step. `is_blocked(a, b)`: true if a wall stops the motion from
/// a to b (volume frame). `facets`: of the path's legs; null for methods on voxels.
template <class IsBlocked>
void end_with_friction(const volume::Frame& frame, const TouchScene& scene, const glm::dvec3& hip_world,
                       int landing, const PathFacets* facets, IsBlocked&& is_blocked, ProxyState& state,
                       ProxyStep& step) noexcept {
  glm::dvec3 proxy = step.path_volume[static_cast<std::size_t>(step.waypoint_count - 1)];
  if (step.has_contact && state.had_contact) {
    proxy = facets ? apply_facet_friction(frame, scene, hip_world, landing, *facets, step, state.is_sticking)
                   : apply_friction(frame, material_of(scene, step.shape, step.side), hip_world, landing,
                                    step, state.is_sticking);
    // Rounding may have moved the end of a leg that friction shortened: it is tested again.
    if (const int last = step.waypoint_count - 1; last > 0) {
      const glm::dvec3 begin = step.path_volume[static_cast<std::size_t>(last - 1)];
      if (is_blocked(begin, proxy)) {
        proxy = begin;
        --step.waypoint_count;
      }
    }
  } else if (step.has_contact) {
    state.is_sticking = true;
  }
  state.had_contact = step.has_contact;
  state.proxy_volume = proxy;
  step.proxy_world = frame.world_from_volume(proxy);
}

}  // namespace trephine::haptics
