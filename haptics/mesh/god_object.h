// The god-object on facets (Zilles and Salisbury 1995): moves until facets stop it, then on as many of them
// as hold, up to three at once. For triangles of any origin: a caster says where a way first meets one.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "haptics/proxy/friction.h"
#include "volume/frame.h"

namespace trephine::haptics {

/// First crossing of a way with a facet that holds it.
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

/// The point nearest to `target` that all planes (at most three) allow; by trying which of them hold.
/// `target` itself when none does, and the point on the last plane alone when rounding leaves none.
glm::dvec3 nearest_allowed(const glm::dvec3& target, const std::array<HoldingPlane, 3>& planes,
                           int count) noexcept;

/// a b - c d with the right sign, whatever rounding does to the products.
double exact_determinant(double a, double b, double c, double d) noexcept;

/// The way a + t d, t in [0, 1], ready to be asked about many triangles.
class CrossingWay {
 public:
  CrossingWay(const glm::dvec3& a, const glm::dvec3& d) noexcept : a_(a), d_(d) {
    const glm::dvec3 size = glm::abs(d);
    z_ = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    x_ = z_ == 2 ? 0 : z_ + 1, y_ = x_ == 2 ? 0 : x_ + 1;
    is_way_ = size[z_] > 0;
    sx_ = d[x_] / d[z_], sy_ = d[y_] / d[z_];
    first_ = std::min(0.0, d[z_]) - k_beside * size[z_], last_ = std::max(0.0, d[z_]) + k_beside * size[z_];
  }
  /// Does it cross the triangle? Watertight at edges and vertices: corners are projected along the way, once
  /// and alike for all their triangles, and edges are decided exactly (after Woop, Benthin and Wald 2013;
  /// zero counts as inside). `facing` < 0: the way goes against the triangle's normal. Degenerate triangles
  /// are missed.
  bool crosses(const glm::dvec3& v0, const glm::dvec3& v1, const glm::dvec3& v2, double& t,
               double& facing) const noexcept {
    if (!is_way_) return false;
    const glm::dvec3 p = v0 - a_, q = v1 - a_, r = v2 - a_;
    // Most triangles of a box lie before the way or behind it.
    if (std::min({p[z_], q[z_], r[z_]}) > last_ || std::max({p[z_], q[z_], r[z_]}) < first_) return false;
    // Seen along the way, each corner is a point of a plane, rounded once and so the same for all its
    // triangles; which side of their edges the way passes is then decided exactly.
    const double px = p[x_] - sx_ * p[z_], py = p[y_] - sy_ * p[z_];
    const double qx = q[x_] - sx_ * q[z_], qy = q[y_] - sy_ * q[z_];
    const double rx = r[x_] - sx_ * r[z_], ry = r[y_] - sy_ * r[z_];
    const double u = determinant(rx, qy, ry, qx), v = determinant(px, ry, py, rx),
                 w = determinant(qx, py, qy, px);
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const glm::dvec3 normal = glm::cross(v1 - v0, v2 - v0);
    facing = glm::dot(d_, normal);
    if (facing == 0) return false;
    // A way that ends on the triangle and the next one, which begins there, must not both miss it for
    // rounding.
    const double slack =
        8 * std::numeric_limits<double>::epsilon() * glm::dot(glm::abs(v0) + glm::abs(a_), glm::abs(normal));
    const double at = glm::dot(p, normal) / facing, beside = slack / std::abs(facing);
    if (!(at >= -beside && at <= 1 + beside)) return false;
    t = std::clamp(at, 0.0, 1.0);
    return true;
  }

 private:
  static constexpr double k_beside = 1e-9;  // of the way: more than rounding
  static double determinant(double a, double b, double c, double d) noexcept {
    const double ab = a * b, cd = c * d, value = ab - cd;
    return std::abs(value) > 1e-15 * (std::abs(ab) + std::abs(cd)) ? value : exact_determinant(a, b, c, d);
  }

  glm::dvec3 a_, d_;
  int x_, y_, z_;
  double sx_, sy_, first_, last_;
  bool is_way_;
};

inline constexpr int k_max_facet_moves = 10;
inline constexpr double k_facet_gap = 1e-5;  ///< voxels (or of a mesh's shortest scale) kept before a facet

/// Moves from `start_volume` toward the HIP; waypoints go to result.path_volume, the last of them is the
/// frictionless proxy. `cast(a, b, hit)`: does the way from a to b (volume frame) meet a holding facet?
/// `gap_mm`: how far before facets the proxy stays. Returns the waypoint at which the first facet was met: 1
/// when the proxy fell on it from a tenth of a voxel or farther, else 0. `facets`: those of each leg.
template <class Cast>
int move_god_object(const volume::Frame& frame, const glm::dvec3& hip_world, const glm::dvec3& start_volume,
                    double gap_mm, Cast&& cast, PathFacets& facets, ProxyStep& result) noexcept {
  using glm::dvec3;
  const dvec3 hip = frame.volume_from_world(hip_world);
  dvec3 at = start_volume, goal = hip;
  result.add_waypoint(at);
  int best_count = 1;
  const dvec3 start_offset = frame.world_from_volume(at) - hip_world;
  double best = glm::dot(start_offset, start_offset);
  std::array<HoldingPlane, 3> planes;
  int count = 0, landing = 0;
  LegFacets leg;  // those of `planes`
  const auto set_facets = [&] { facets[static_cast<std::size_t>(result.waypoint_count - 1)] = leg; };
  set_facets();
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
      set_facets();
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
