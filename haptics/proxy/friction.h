// friction_load(): Coulomb friction. The proxy rests where the pull of the hand is within the friction cone
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

/// Load on the friction of some walls, in mm of the spring's length from the proxy to the HIP. `along`: part
/// of the pull that is along the walls. `limit`: largest such part that their friction holds.
struct FrictionLoad {
  double along = 0, limit = 0;
  bool is_held() const noexcept { return along <= limit; }
  /// Returns true if the tool sticks. A slide ends on the border of the friction cone, and may continue in
  /// the next step. A tool that slid before therefore sticks only if the load is clearly inside the cone.
  bool is_at_rest(bool was_sticking) const noexcept {
    constexpr double k_rest = 0.98;
    return along <= (was_sticking ? 1 : k_rest) * limit;
  }
};

/// Splits a pull into pressures on the walls and a remainder along the walls. A pressure is a factor of a
/// wall's normal, at least 0; the remainder is the shortest possible. Each wall holds its own coefficient
/// times its own pressure, so that both walls of a groove count.
FrictionLoad friction_load(const HoldingWalls& walls, const glm::dvec3& pull) noexcept;

/// For methods on voxels: shortens step.path_volume, which ends at the frictionless proxy, so that the
/// tangential spring force stays within the cone of `material` at step.normal_world. Returns the new proxy: a
/// waypoint, or a point inside the last leg. The caller tests that leg again, since rounding may have moved
/// its end across a voxel's face. The legs up to waypoint `landing` lead to the surface and are not
/// shortened. Do not call in the first step of a contact.
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
/// at which the facets of its leg hold the pull. Shortens the path to that point and returns it. The caller
/// tests the last leg again, as above.
glm::dvec3 apply_facet_friction(const volume::Frame& frame, const TouchScene& scene,
                                const glm::dvec3& hip_world, int landing, const PathFacets& facets,
                                ProxyStep& step, bool& is_sticking) noexcept;

/// Returns the waypoint at which the path lands on the surface. It is 1 if the first leg leads to a surface
/// that is no longer at the proxy, for example after a cut: if the leg is longer than a tenth of a voxel,
/// which is twice the lift of method `implicit`. Else it is 0.
int landing_of_first_leg(const ProxyStep& step) noexcept;

/// Ends a step at its path's last waypoint: applies friction along the path, tests the leg that friction
/// shortened, and sets the state for the next step. `is_blocked(a, b)`: true if a wall stops the motion from
/// a to b (volume frame). `facets`: facets of the path's legs; null for methods on voxels.
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
