// Coulomb friction: the pull of the hand on the proxy stays within the cone of the walls that hold it there.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// The walls that hold a tool at one place.
struct HoldingWalls {
  static constexpr int k_most = 6;
  int count = 0;
  std::array<glm::dvec3, k_most> normals;  ///< unit, world, into the solid
  std::array<double, k_most> friction;     ///< coefficients

  void add(const glm::dvec3& normal_into_solid, double coefficient) noexcept {
    if (count == k_most) return;
    normals[static_cast<std::size_t>(count)] = normal_into_solid;
    friction[static_cast<std::size_t>(count++)] = coefficient;
  }
};

/// The parts of a pull (mm of the spring's stretch, from the proxy to the HIP) at some walls: along them, and
/// how much of that their friction bears.
struct FrictionLoad {
  double along = 0, limit = 0;
  bool is_held() const noexcept { return along <= limit; }
  /// Does a tool that slid before stick again? A slide ends on the cone, from which it goes on in the next
  /// step: only what is clearly inside has come to rest.
  bool is_at_rest(bool was_sticking) const noexcept {
    constexpr double k_rest = 0.98;
    return along <= (was_sticking ? 1 : k_rest) * limit;
  }
};

/// Splits a pull into what presses on each wall (the least sum of normals, none of them pulling, that leaves
/// the shortest rest) and the rest, along all of them. Each wall bears its own coefficient times its own
/// press: in a groove both count.
FrictionLoad friction_load(const HoldingWalls& walls, const glm::dvec3& pull) noexcept;

/// For methods on voxels: shortens step.path_volume (its end is the frictionless proxy) so that the
/// tangential spring force stays within the cone of `material` at the normal of the path's end. Returns the
/// new proxy: a waypoint, or a point inside the last leg left, which the caller checks again, since rounding
/// may have moved it across a voxel's face. The legs up to waypoint `landing` led down to the surface and
/// stay. Call while contact lasts, not on its first step.
glm::dvec3 apply_friction(const volume::Frame& frame, const Material& material, const glm::dvec3& hip_world,
                          int landing, ProxyStep& step, bool& is_sticking) noexcept;

/// The facets on which a leg of a path lies.
struct LegFacets {
  int count = 0;
  static constexpr int k_most = 3;
  std::array<glm::dvec3, k_most> normals;  ///< unit, world, toward the tool
  std::array<int, k_most> shapes;
  std::array<Side, k_most> sides;

  void add(const glm::dvec3& normal, int shape, Side side) noexcept {
    if (count == k_most) {
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

/// For methods on facets, along which legs are straight: the first place of the path, from waypoint `landing`
/// on, at which the facets of its leg hold the pull. Shortens the path to it and returns it, to be checked
/// again as above.
glm::dvec3 apply_facet_friction(const volume::Frame& frame, const TouchScene& scene,
                                const glm::dvec3& hip_world, int landing, const PathFacets& facets,
                                ProxyStep& step, bool& is_sticking) noexcept;

/// The landing for methods whose first leg leads down to the surface where that fell away from under the
/// proxy: 1 when it is longer than a tenth of a voxel, twice what a step may lift the proxy; else 0.
int landing_of_first_leg(const ProxyStep& step) noexcept;

/// Ends a step at its path's last waypoint: friction along the way to it, a last look at the leg that
/// friction shortened, and the state for the next step. `is_blocked(a, b)`: does a wall stop the way from a
/// to b (volume frame)? `facets`: of the path's legs; null for methods on voxels.
template <class IsBlocked>
void end_with_friction(const volume::Frame& frame, const TouchScene& scene, const glm::dvec3& hip_world,
                       int landing, const PathFacets* facets, IsBlocked&& is_blocked, ProxyState& state,
                       ProxyStep& step) noexcept {
  glm::dvec3 proxy = step.path_volume[static_cast<std::size_t>(step.waypoint_count - 1)];
  if (step.has_contact && state.had_contact) {
    proxy = facets ? apply_facet_friction(frame, scene, hip_world, landing, *facets, step, state.is_sticking)
                   : apply_friction(frame, material_of(scene, step.shape, step.side), hip_world, landing,
                                    step, state.is_sticking);
    // A leg that friction shortened ends where rounding put it: look again.
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
