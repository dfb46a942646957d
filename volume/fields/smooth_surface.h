// SmoothSurface: surface of the smooth solid of a shape less its cuts. Computes projections to this surface
// and distances from it.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "volume/base/axes.h"
#include "volume/cuts/version.h"
#include "volume/fields/quadratic_patch.h"
#include "volume/fields/soft_field.h"
#include "volume/scan/field.h"
#include "volume/scan/traversal.h"

namespace trephine::volume {

/// Point of the smooth surface.
struct SurfacePoint {
  glm::vec3 at_world;  ///< mm
  bool is_cut;         ///< on the surface of a cut, not of the scan
};

/// Borrows field, soft field and version. Queries are thread-safe. Only bisect() allocates.
class SmoothSurface {
 public:
  static constexpr int k_max_newton = 10;
  static constexpr int k_max_rim_steps = 24;

  /// `version` null: no cuts. `soft`: replaces the samples of the field; may be null.
  SmoothSurface(const Field& field, const Version* version, const SoftField* soft)
      : field_(field),
        soft_(soft),
        version_(version != nullptr && !version->is_uncut() ? version : nullptr),
        frame_(field.volume().frame),
        finest_(std::min({frame_.spacing().x, frame_.spacing().y, frame_.spacing().z})) {}

  bool has_cut() const { return version_ != nullptr; }
  bool is_near_cut(const SurfacePoint& p) const {
    return has_cut() && version_->is_near_cut(frame_.volume_from_world(glm::dvec3(p.at_world)));
  }
  /// Value and derivatives of the cut distance or of the shape's field, per voxel step.
  Jet jet(bool is_cut, const glm::dvec3& p_volume) const {
    if (is_cut) return cut_jet(*version_, p_volume);
    const glm::ivec3 v = voxel_of(p_volume);
    QuadraticPatch patch;
    if (soft_)
      soft_->load(v, patch);
    else
      patch.load(field_, v);
    return patch.jet(p_volume - glm::dvec3(v));
  }
  bool is_solid(const glm::dvec3& p_volume) const {
    if (jet(false, p_volume).value < 0) return false;
    return version_ == nullptr || jet(true, p_volume).value >= 0;
  }

  /// Follows the gradient from `from` (volume frame) to a surface point; false if no surface point is found
  /// within 1.5 cells. `cells`: number of cells per voxel along each axis.
  bool project(const glm::dvec3& from, const glm::dvec3& cells, SurfacePoint& out) const {
    bool is_found = false;
    double nearest = 1e300;
    for (const bool is_cut : {false, true}) {
      if (is_cut && !has_cut()) continue;
      glm::dvec3 p = from;
      bool is_near = true;
      for (int i = 0; i < 8 && is_near; ++i) {
        const Jet j = jet(is_cut, p);
        // This is the shortest step to the surface in mm. The shortest step in voxel units would have a wrong
        // direction in thick slices.
        const glm::dvec3 uphill = frame_.gradient_world_from_volume(j.gradient);
        const double square = glm::dot(uphill, uphill);
        if (!(square > 0)) {
          is_near = false;
          break;
        }
        const glm::dvec3 step = frame_.vector_volume_from_world((j.value / square) * uphill);
        p -= step;
        const glm::dvec3 moved = (p - from) * cells;
        is_near = glm::dot(moved, moved) < 1.5 * 1.5;
        if (glm::dot(step * cells, step * cells) < 1e-12) break;
      }
      if (!is_near) continue;
      // The point bounds the solid only if the other field (scan or cut) is also solid there.
      if (has_cut() && jet(!is_cut, p).value < 0) continue;
      const glm::dvec3 offset = (p - from) * cells;
      if (glm::dot(offset, offset) >= nearest) continue;
      nearest = glm::dot(offset, offset);
      out = {glm::vec3(frame_.world_from_volume(p)), is_cut};
      is_found = true;
    }
    return is_found;
  }

  /// Finds the point nearest to `from` (volume frame) on the rim, where a cut meets the scan's surface; false
  /// if it is farther than 1.5 times the longest edge of a cell.
  bool project_to_rim(const glm::dvec3& from, const glm::dvec3& cells, SurfacePoint& out) const {
    if (!has_cut() || !version_->is_near_cut(from)) return false;
    const glm::dvec3 steps = frame_.spacing() / cells;
    const double reach = 1.5 * std::max({steps.x, steps.y, steps.z});
    const glm::dvec3 from_world = frame_.world_from_volume(from);
    glm::dvec3 rim(0);
    if (!(distance_to_rim(from_world, from_world, reach, rim) < reach)) return false;
    out = {glm::vec3(rim), true};
    return true;
  }

  /// Finds the surface point between a solid point and a free point (volume frame) by bisection, and appends
  /// it. For structures that are too thin for project().
  void bisect(glm::dvec3 solid, glm::dvec3 free, std::vector<SurfacePoint>& points) const {
    if (!is_solid(solid) || is_solid(free)) return;
    for (int i = 0; i < 24; ++i) {
      const glm::dvec3 middle = 0.5 * (solid + free);
      (is_solid(middle) ? solid : free) = middle;
    }
    bool is_cut = false;
    if (has_cut()) is_cut = std::abs(jet(true, solid).value) * 100 < std::abs(jet(false, solid).value);
    points.push_back({glm::vec3(frame_.world_from_volume(solid)), is_cut});
  }

  /// Distance (mm) from x to the surface near `from`, at most the distance to `from` itself. `is_found`: true
  /// if the search that started at `from` found a nearest point on the scan's surface, on that of a cut or on
  /// the rim.
  double distance(const glm::dvec3& x_world, const SurfacePoint& from, bool& is_found) const {
    const glm::dvec3 start(from.at_world), offset = x_world - start;
    const double longest = std::sqrt(glm::dot(offset, offset));
    glm::dvec3 own_point = start, other_point = start;
    const std::optional<double> own = distance_within(x_world, from.is_cut, own_point);
    // The other field may bound the solid nearer to x.
    const bool has_other = is_near_cut(from);
    const std::optional<double> other =
        has_other ? distance_within(x_world, !from.is_cut, other_point) : std::nullopt;
    double best = std::min({longest, own.value_or(longest), other.value_or(longest)});
    // The rim is on both surfaces; it is nearest only if one of them has no nearest point that bounds the
    // solid.
    if (has_other && !(own && other)) {
      glm::dvec3 rim(0);
      best = distance_to_rim(x_world, own_point, distance_to_rim(x_world, start, best, rim), rim);
    }
    is_found = own || other || best < longest;
    return best;
  }

 private:
  /// Distance (mm) from x to the surface of one field near y, by Newton's method with curvature. y (world):
  /// start of the search; receives the last iterate. Returns nullopt if the search did not converge, or if
  /// its result does not bound the solid.
  std::optional<double> distance_within(const glm::dvec3& x_world, bool is_cut, glm::dvec3& y) const {
    for (int i = 0; i < k_max_newton; ++i) {
      const Jet j = jet(is_cut, frame_.volume_from_world(y));
      const glm::dvec3 gradient = frame_.gradient_world_from_volume(j.gradient);
      const double steepness = std::sqrt(glm::dot(gradient, gradient));
      if (!(steepness > 0)) break;
      const glm::dvec3 n = gradient / steepness, to_x = x_world - y;
      const double height = -j.value / steepness;
      // Two tangents, and the second derivatives along them.
      const glm::dvec3 u = glm::normalize(glm::cross(n, non_parallel_axis(n)));
      const glm::dvec3 w = glm::cross(n, u);
      const glm::dvec3 u_voxel = frame_.vector_volume_from_world(u),
                       w_voxel = frame_.vector_volume_from_world(w);
      const glm::dvec3 hessian_u = j.hessian_times(u_voxel), hessian_w = j.hessian_times(w_voxel);
      const double lambda = (glm::dot(to_x, n) - height) / steepness;
      double a = 1 + lambda * glm::dot(hessian_u, u_voxel), c = 1 + lambda * glm::dot(hessian_w, w_voxel);
      const double b = lambda * glm::dot(hessian_u, w_voxel), half = 0.5 * (a - c);
      const double least = 0.5 * (a + c) - std::sqrt(half * half + b * b);
      if (least < 0.5) a += 0.5 - least, c += 0.5 - least;
      const double ru = glm::dot(to_x, u), rw = glm::dot(to_x, w), share = 1 / (a * c - b * b);
      glm::dvec3 step = height * n + share * ((c * ru - b * rw) * u + (a * rw - b * ru) * w);
      const double length = std::sqrt(glm::dot(step, step)), limit = longest_step(is_cut);
      if (!(length < 1e300)) break;  // not finite
      if (length > limit) step *= limit / length;
      y += step;
      if (length < 1e-3 * finest_) {
        // Beyond the rim, the surface of a cut is in air and bounds no solid. Inside a cut, the surface of
        // the scan bounds no solid either.
        if (has_cut() && jet(!is_cut, frame_.volume_from_world(y)).value < 0) return {};
        const glm::dvec3 offset = x_world - y;
        return std::sqrt(glm::dot(offset, offset));
      }
    }
    return {};
  }

  /// Distance (mm) from x to the rim near y (world). The rim is the curve on which both fields are 0. `rim`
  /// receives the nearest point of this curve. Returns `bound` and leaves `rim` unchanged if the rim is not
  /// nearer than `bound`.
  double distance_to_rim(const glm::dvec3& x_world, glm::dvec3 y, double bound, glm::dvec3& rim) const {
    const double tolerance = 1e-3 * finest_;
    double last_along = 0, last_step = 0;
    for (int i = 0; i < k_max_rim_steps; ++i) {
      const glm::dvec3 p = frame_.volume_from_world(y);
      const Jet scan = jet(false, p), cut = jet(true, p);
      const glm::dvec3 a = frame_.gradient_world_from_volume(scan.gradient),
                       b = frame_.gradient_world_from_volume(cut.gradient);
      // Each step is the shortest step to the zero of both fields, plus a step along the curve toward x.
      const double aa = glm::dot(a, a), bb = glm::dot(b, b), ab = glm::dot(a, b), det = aa * bb - ab * ab;
      if (!(det > 1e-6 * aa * bb)) return bound;
      // Records every iterate on the rim, because convergence to the nearest point is slow where the rim
      // bends around x.
      const glm::dvec3 to_x = x_world - y;
      if (scan.value * scan.value < tolerance * tolerance * aa &&
          cut.value * cut.value < tolerance * tolerance * bb)
        if (const double distance = std::sqrt(glm::dot(to_x, to_x)); distance < bound)
          bound = distance, rim = y;
      const double s = (-scan.value * bb + cut.value * ab) / det,
                   t = (-cut.value * aa + scan.value * ab) / det;
      const glm::dvec3 along = glm::normalize(glm::cross(a, b)), correction = s * a + t * b;
      // Gives up if the linearized rim is more than twice as far as the bound.
      if (i == 0) {
        const glm::dvec3 estimate = y + correction - x_world,
                         perpendicular = estimate - glm::dot(estimate, along) * along;
        if (glm::dot(perpendicular, perpendicular) > 4 * bound * bound) return bound;
      }
      // Secant step: if the curve bends around x, the remaining length decreases by less than each step.
      const double remaining = glm::dot(x_world - y, along);
      double advance = remaining;
      if (last_step != 0)
        if (const double rate = (last_along - remaining) / last_step; rate > 0.1 && rate < 1)
          advance = remaining / rate;
      glm::dvec3 step = correction + advance * along;
      const double length = std::sqrt(glm::dot(step, step)), limit = longest_step(true);
      if (!(length < 1e300)) return bound;
      const double share = length > limit ? limit / length : 1;
      last_along = remaining, last_step = share * advance;
      y += share * step;
      if (length < tolerance) return bound;
    }
    return bound;
  }

  /// Longest Newton step (mm); shorter for cuts, whose distance is constant beyond the band.
  double longest_step(bool is_cut) const {
    const double usual = 1.5 * finest_;
    return is_cut && version_ ? std::min(usual, 2 * version_->band_mm()) : usual;
  }

  const Field& field_;
  const SoftField* soft_;
  const Version* version_;
  const Frame& frame_;
  double finest_;  ///< smallest spacing, mm
};

}  // namespace trephine::volume
