// move_god_object(): god-object on facets (Zilles and Salisbury 1995). It moves until facets stop it, then
// along up to three facets at once. The facets may be from any source: a function finds the first facet on a
// motion.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "haptics/mesh/facet_hit.h"
#include "haptics/proxy/friction.h"
#include "volume/scan/frame.h"

namespace trephine::haptics {

/// Allowed half space normal . x >= offset; x in mm, world frame.
struct HoldingPlane {
  glm::dvec3 normal;
  double offset;
};

/// Returns the point nearest to `target` that is in all of the first `count` half spaces (at most three).
/// Tests sets of active planes. If rounding leaves no such point, returns the projection of `target` on the
/// last plane.
glm::dvec3 nearest_allowed(const glm::dvec3& target, const std::array<HoldingPlane, 3>& planes,
                           int count) noexcept;

/// Returns a b - c d with the correct sign, whatever the rounding of the products.
double exact_determinant(double a, double b, double c, double d) noexcept;

/// The motion a + t d, t in [0, 1], prepared for tests with many triangles.
class TriangleCrossing {
 public:
  TriangleCrossing(const glm::dvec3& a, const glm::dvec3& d) noexcept : a_(a), d_(d) {
    const glm::dvec3 size = glm::abs(d);
    z_ = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    x_ = z_ == 2 ? 0 : z_ + 1, y_ = x_ == 2 ? 0 : x_ + 1;
    has_length_ = size[z_] > 0;
    sx_ = d[x_] / d[z_], sy_ = d[y_] / d[z_];
    first_ = std::min(0.0, d[z_]) - k_margin * size[z_], last_ = std::max(0.0, d[z_]) + k_margin * size[z_];
  }
  /// Returns true if the motion crosses the triangle, and sets `t` to the parameter of the crossing. The test
  /// is watertight at edges and vertices (after Woop, Benthin and Wald 2013): a motion through an edge or a
  /// vertex crosses at least one of the adjacent triangles. `direction_dot_normal` < 0: the motion goes
  /// against the triangle's normal. Degenerate triangles are never crossed.
  bool crosses(const glm::dvec3& v0, const glm::dvec3& v1, const glm::dvec3& v2, double& t,
               double& direction_dot_normal) const noexcept {
    if (!has_length_) return false;
    const glm::dvec3 p = v0 - a_, q = v1 - a_, r = v2 - a_;
    // Most triangles are before the start or beyond the end of the motion, along its longest axis.
    if (std::min({p[z_], q[z_], r[z_]}) > last_ || std::max({p[z_], q[z_], r[z_]}) < first_) return false;
    // Projects each corner along the motion to a 2D point. The point is rounded identically in all triangles
    // with this corner. Then decides exactly on which side of each edge the motion passes; a motion
    // through the edge itself counts as inside.
    const double px = p[x_] - sx_ * p[z_], py = p[y_] - sy_ * p[z_];
    const double qx = q[x_] - sx_ * q[z_], qy = q[y_] - sy_ * q[z_];
    const double rx = r[x_] - sx_ * r[z_], ry = r[y_] - sy_ * r[z_];
    const double u = determinant(rx, qy, ry, qx), v = determinant(px, ry, py, rx),
                 w = determinant(qx, py, qy, px);
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const glm::dvec3 normal = glm::cross(v1 - v0, v2 - v0);
    direction_dot_normal = glm::dot(d_, normal);
    if (direction_dot_normal == 0) return false;
    // If one motion ends on the triangle and the next motion begins there, rounding must not let both miss
    // the triangle.
    const double slack =
        8 * std::numeric_limits<double>::epsilon() * glm::dot(glm::abs(v0) + glm::abs(a_), glm::abs(normal));
    const double at = glm::dot(p, normal) / direction_dot_normal,
                 tolerance = slack / std::abs(direction_dot_normal);
    if (!(at >= -tolerance && at <= 1 + tolerance)) return false;
    t = std::clamp(at, 0.0, 1.0);
    return true;
  }

 private:
  static constexpr double k_margin = 1e-9;  // share of the motion, larger than rounding errors
  static double determinant(double a, double b, double c, double d) noexcept {
    const double ab = a * b, cd = c * d, value = ab - cd;
    return std::abs(value) > 1e-15 * (std::abs(ab) + std::abs(cd)) ? value : exact_determinant(a, b, c, d);
  }

  glm::dvec3 a_, d_;
  int x_, y_, z_;
  double sx_, sy_, first_, last_;
  bool has_length_;
};

/// Largest number of straight motions in a step.
inline constexpr int k_max_facet_moves = 10;
/// Gap before facets, as a share of the shortest edge of a voxel or a depth pixel.
inline constexpr double k_facet_gap = 1e-5;

/// Moves from `start_volume` toward the HIP. Adds waypoints to result.path_volume; the last one is the
/// frictionless proxy. `cast(a, b, hit)` finds the first blocking facet on the motion from a to b (volume
/// frame). `gap_mm`: distance that the proxy keeps from facets. `facets`: output, the facets along which each
/// leg leads. Returns the waypoint at which the proxy landed on the first facet: 1 if the first leg was
/// longer than a tenth of a voxel, else 0.
template <class Cast>
int move_god_object(const volume::Frame& frame, const glm::dvec3& hip_world, const glm::dvec3& start_volume,
                    double gap_mm, Cast&& cast, PathFacets& facets, ProxyStep& result) noexcept {
  using glm::dvec3;
  const dvec3 hip = frame.volume_from_world(hip_world);
  dvec3 current = start_volume, goal = hip;
  result.add_waypoint(current);
  int best_count = 1;
  const dvec3 start_offset = frame.world_from_volume(current) - hip_world;
  double best = glm::dot(start_offset, start_offset);
  std::array<HoldingPlane, 3> planes;
  int count = 0, landing = 0;
  LegFacets leg;  // facets of `planes`
  const auto set_facets = [&] { facets[static_cast<std::size_t>(result.waypoint_count - 1)] = leg; };
  set_facets();
  for (int i = 0; i < k_max_facet_moves; ++i) {
    ++result.counters.iterations;
    FacetHit hit;
    const bool is_blocked = cast(current, goal, hit);
    const dvec3 motion_world = frame.vector_world_from_volume(goal - current);
    double free = 1;
    if (is_blocked) {
      const double approach = -glm::dot(motion_world, hit.normal_world);
      free = approach > 0 ? std::max(0.0, hit.t - gap_mm / approach) : 0;
    }
    if (free > 0 && goal != current) {
      const dvec3 to = is_blocked ? current + free * (goal - current) : goal;
      result.add_waypoint(to);
      set_facets();
      const dvec3 off = frame.world_from_volume(to) - hip_world;
      if (const double energy = glm::dot(off, off); energy < best) {
        best = energy;
        best_count = result.waypoint_count;
      }
    }
    if (!is_blocked) break;
    const dvec3 touched_world = frame.world_from_volume(current + hit.t * (goal - current));
    if (free > 0) current = current + free * (goal - current);
    if (i == 0) landing = landing_of_first_leg(result);
    result.set_contact(hit.shape, hit.side, hit.normal_world);
    // Adds the facet to the active ones; if there are three, the oldest is dropped.
    if (count == 3) {
      planes[0] = planes[1];
      planes[1] = planes[2];
      --count;
    }
    leg.add(hit.normal_world, hit.shape, hit.side);
    set_facets();
    planes[static_cast<std::size_t>(count++)] = {hit.normal_world,
                                                 glm::dot(hit.normal_world, touched_world) + gap_mm};
    goal = frame.volume_from_world(nearest_allowed(hip_world, planes, count));
  }
  result.waypoint_count = best_count;
  return landing;
}

}  // namespace trephine::haptics
