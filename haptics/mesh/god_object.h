// The god-object on facets (Zilles and Salisbury 1995): moves until facets stop it, then on as many of them
// as hold, up to three at once. For triangles of any origin: a caster says where a way first meets one.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "haptics/proxy/friction.h"
#include "volume/frame.h"

namespace trephine::haptics {

/// Where a way first meets a facet that holds it.
struct FacetHit {
  double t = 1;
  glm::dvec3 normal_world{0.0};  ///< unit, toward the side that the way came from
  int shape = -1;
  Side side = Side::none;
  std::uint32_t triangle = 0;  ///< of a mesh, as its tree counts
};

/// n . x >= offset, mm.
struct HoldingPlane {
  glm::dvec3 normal;
  double offset;
};

/// The point nearest to `wish` that all planes (at most three) allow; by trying which of them hold. `wish`
/// itself when none does, and the point on the last plane alone when rounding leaves none.
glm::dvec3 nearest_allowed(const glm::dvec3& wish, const std::array<HoldingPlane, 3>& planes,
                           int count) noexcept;

/// Does the way a + t d, t in [0, 1], cross the triangle? Watertight at edges and vertices: corners are
/// projected along the way, once and alike for all their triangles, and edges are decided exactly (after
/// Woop, Benthin and Wald 2013; zero counts as inside). `facing` < 0: the way goes against the triangle's
/// normal. Degenerate triangles are missed.
bool crosses_triangle(const glm::dvec3& a, const glm::dvec3& d, const glm::dvec3& v0, const glm::dvec3& v1,
                      const glm::dvec3& v2, double& t, double& facing) noexcept;

inline constexpr int k_max_facet_moves = 10;
inline constexpr double k_facet_gap = 1e-5;  ///< voxels (or of a mesh's shortest scale) kept before a facet

/// Moves from `start_volume` toward the HIP; waypoints go to result.path_volume, the last of them is the
/// frictionless proxy. `cast(a, b, hit)`: does the way from a to b (volume frame) meet a holding facet?
/// `gap_mm`: how far before facets the proxy stays. Returns the waypoint at which the first facet was met: 1
/// when the proxy fell on it from a tenth of a voxel or farther, else 0.
template <class Cast>
int move_god_object(const volume::Frame& frame, const glm::dvec3& hip_world, const glm::dvec3& start_volume,
                    double gap_mm, Cast&& cast, ProxyStep& result) noexcept {
  using glm::dvec3;
  const dvec3 hip = frame.volume_from_world(hip_world);
  dvec3 at = start_volume, goal = hip;
  result.add_waypoint(at);
  int best_count = 1;
  const dvec3 start_offset = frame.world_from_volume(at) - hip_world;
  double best = glm::dot(start_offset, start_offset);
  std::array<HoldingPlane, 3> planes;
  int count = 0, landing = 0;
  for (int i = 0; i < k_max_facet_moves; ++i) {
    ++result.counters.iterations;
    FacetHit hit;
    const bool is_blocked = cast(at, goal, hit);
    const dvec3 way = frame.vector_world_from_volume(goal - at);
    double free = 1;
    if (is_blocked) {
      const double approach = -glm::dot(way, hit.normal_world);
      free = approach > 0 ? std::max(0.0, hit.t - gap_mm / approach) : 0;
    }
    if (free > 0 && goal != at) {
      const dvec3 to = is_blocked ? at + free * (goal - at) : goal;
      result.add_waypoint(to);
      const dvec3 off = frame.world_from_volume(to) - hip_world;
      if (const double energy = glm::dot(off, off); energy < best) {
        best = energy;
        best_count = result.waypoint_count;
      }
    }
    if (!is_blocked) break;
    const dvec3 touched_world = frame.world_from_volume(at + hit.t * (goal - at));
    if (free > 0) at = at + free * (goal - at);
    if (i == 0) landing = landing_of_first_leg(result);
    result.set_contact(hit.shape, hit.side, hit.normal_world);
    // The facet joins those that hold; of more than three the oldest goes.
    if (count == 3) {
      planes[0] = planes[1];
      planes[1] = planes[2];
      --count;
    }
    planes[static_cast<std::size_t>(count++)] = {hit.normal_world,
                                                 glm::dot(hit.normal_world, touched_world) + gap_mm};
    goal = frame.volume_from_world(nearest_allowed(hip_world, planes, count));
  }
  result.waypoint_count = best_count;
  return landing;
}

}  // namespace trephine::haptics
