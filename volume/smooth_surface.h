// The surface of the smooth solid of a shape and its cuts: points on it, and distances to it.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "volume/field.h"
#include "volume/quadratic_patch.h"
#include "volume/soft_field.h"
#include "volume/traversal.h"
#include "volume/version.h"

namespace trephine::volume {

/// A point of the smooth surface.
struct SurfacePoint {
  glm::vec3 at_world;
  bool is_cut;
};

/// The smooth solid, evaluated anywhere. Borrows field, soft field and version; queries from any thread, no
/// allocation but in bisect().
class SmoothSurface {
 public:
  static constexpr int k_max_newton = 10;
  static constexpr int k_max_rim_steps = 24;

  /// `soft`: in place of the field's samples; null: none.
  SmoothSurface(const Field& field, const Version* version, const SoftField* soft)
      : field_(field),
        soft_(soft),
        version_(version != nullptr && !version->is_untouched() ? version : nullptr),
        frame_(field.volume().frame),
        finest_(std::min({frame_.spacing().x, frame_.spacing().y, frame_.spacing().z})) {}

  bool has_cut() const { return version_ != nullptr; }
  bool is_near_cut(const SurfacePoint& p) const {
    return has_cut() && version_->is_near_cut(frame_.volume_from_world(glm::dvec3(p.at_world)));
  }
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

  /// The surface point nearest to a place, along its gradient; false if it is not within 1.5 cells.
  /// `cells`: how many of them a voxel has along each axis.
  bool project(const glm::dvec3& from, const glm::dvec3& cells, SurfacePoint& out) const {
    bool is_found = false;
    double nearest = 1e300;
    for (const bool is_cut : {false, true}) {
      if (is_cut && !has_cut()) continue;
      glm::dvec3 p = from;
      bool is_near = true;
      for (int i = 0; i < 8 && is_near; ++i) {
        const Jet j = jet(is_cut, p);
        // The shortest way in the world: in voxels' own units it would lead along thick slices.
        const glm::dvec3 uphill = frame_.gradient_world_from_volume(j.gradient);
        const double square = glm::dot(uphill, uphill);
        if (!(square > 0)) {
          is_near = false;
          break;
        }
        const glm::dvec3 step = frame_.vector_volume_from_world((j.value / square) * uphill);
        p -= step;
        const glm::dvec3 off = (p - from) * cells;
        is_near = glm::dot(off, off) < 1.5 * 1.5;
        if (glm::dot(step * cells, step * cells) < 1e-12) break;
      }
      if (!is_near) continue;
      // On the surface of one field, and in the solid of the other.
      if (has_cut() && jet(!is_cut, p).value < 0) continue;
      const glm::dvec3 off = (p - from) * cells;
      if (glm::dot(off, off) >= nearest) continue;
      nearest = glm::dot(off, off);
      out = {glm::vec3(frame_.world_from_volume(p)), is_cut};
      is_found = true;
    }
    return is_found;
  }

  /// The place nearest to `from` where a cut meets the scan's surface, if one is within 1.5 of the longest
  /// steps of its cell.
  bool project_to_rim(const glm::dvec3& from, const glm::dvec3& cells, SurfacePoint& out) const {
    if (!has_cut() || !version_->is_near_cut(from)) return false;
    const glm::dvec3 steps = frame_.spacing() / cells;
    const double reach = 1.5 * std::max({steps.x, steps.y, steps.z});
    const glm::dvec3 from_world = frame_.world_from_volume(from);
    glm::dvec3 found(0);
    if (!(distance_to_rim(from_world, from_world, reach, found) < reach)) return false;
    out = {glm::vec3(found), true};
    return true;
  }

  /// Surface points between a solid place and a free one, by bisection: for what is too thin for gradients.
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

  /// Distance (mm) from x to the surface near `from`, never longer than to `from`. `is_found`: from there led
  /// a way to a nearest place, on either field or on the rim between them.
  double distance(const glm::dvec3& x_world, const SurfacePoint& from, bool& is_found) const {
    const glm::dvec3 start(from.at_world), off = x_world - start;
    const double longest = std::sqrt(glm::dot(off, off));
    glm::dvec3 reached = start, other = start;
    const std::optional<double> here = distance_within(x_world, from.is_cut, reached);
    // The other field may bound the solid nearer to x.
    const bool has_other = is_near_cut(from);
    const std::optional<double> there =
        has_other ? distance_within(x_world, !from.is_cut, other) : std::nullopt;
    double best = std::min({longest, here.value_or(longest), there.value_or(longest)});
    // The rim lies on both: it is nearest only where one of them has no nearest place that bounds the solid.
    if (has_other && !(here && there)) {
      glm::dvec3 rim(0);
      best = distance_to_rim(x_world, reached, distance_to_rim(x_world, start, best, rim), rim);
    }
    is_found = here || there || best < longest;
    return best;
  }

 private:
  /// Distance from x to the surface of one field near y, by Newton with its curvature. y: where it ended.
  /// Nothing where that bounds no solid, or was not found.
  std::optional<double> distance_within(const glm::dvec3& x_world, bool is_cut, glm::dvec3& y) const {
    for (int i = 0; i < k_max_newton; ++i) {
      const Jet j = jet(is_cut, frame_.volume_from_world(y));
      const glm::dvec3 gradient = frame_.gradient_world_from_volume(j.gradient);
      const double steepness = std::sqrt(glm::dot(gradient, gradient));
      if (!(steepness > 0)) break;
      const glm::dvec3 n = gradient / steepness, to_x = x_world - y;
      const double room = -j.value / steepness;
      // Two tangents, and the second derivatives along them.
      const glm::dvec3 u =
          glm::normalize(glm::cross(n, std::abs(n.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
      const glm::dvec3 w = glm::cross(n, u);
      const glm::dvec3 u_voxel = frame_.vector_volume_from_world(u),
                       w_voxel = frame_.vector_volume_from_world(w);
      const glm::dvec3 hessian_u = j.hessian_times(u_voxel), hessian_w = j.hessian_times(w_voxel);
      const double lambda = (glm::dot(to_x, n) - room) / steepness;
      double a = 1 + lambda * glm::dot(hessian_u, u_voxel), c = 1 + lambda * glm::dot(hessian_w, w_voxel);
      const double b = lambda * glm::dot(hessian_u, w_voxel), half = 0.5 * (a - c);
      const double least = 0.5 * (a + c) - std::sqrt(half * half + b * b);
      if (least < 0.5) a += 0.5 - least, c += 0.5 - least;
      const double ru = glm::dot(to_x, u), rw = glm::dot(to_x, w), share = 1 / (a * c - b * b);
      glm::dvec3 step = room * n + share * ((c * ru - b * rw) * u + (a * rw - b * ru) * w);
      const double length = std::sqrt(glm::dot(step, step)), limit = longest_step(is_cut);
      if (!(length < 1e300)) break;  // nothing to follow here
      if (length > limit) step *= limit / length;
      y += step;
      if (length < 1e-3 * finest_) {
        // A cut's surface goes on in the air beyond its rim, where it bounds nothing; so does the scan's
        // within a cut.
        if (has_cut() && jet(!is_cut, frame_.volume_from_world(y)).value < 0) return {};
        const glm::dvec3 rest = x_world - y;
        return std::sqrt(glm::dot(rest, rest));
      }
    }
    return {};
  }

  /// Distance (mm) from x to the curve near `from` where a cut meets the scan's surface: there both fields
  /// are 0; where that is goes to `found`. At most `most`, with `found` as it was.
  double distance_to_rim(const glm::dvec3& x_world, glm::dvec3 y, double most, glm::dvec3& found) const {
    const double close = 1e-3 * finest_;
    double last_along = 0, last_step = 0;
    for (int i = 0; i < k_max_rim_steps; ++i) {
      const glm::dvec3 p = frame_.volume_from_world(y);
      const Jet scan = jet(false, p), cut = jet(true, p);
      const glm::dvec3 a = frame_.gradient_world_from_volume(scan.gradient),
                       b = frame_.gradient_world_from_volume(cut.gradient);
      // The shortest step that makes both 0, and along the curve toward x.
      const double aa = glm::dot(a, a), bb = glm::dot(b, b), ab = glm::dot(a, b), det = aa * bb - ab * ab;
      if (!(det > 1e-6 * aa * bb)) return most;
      // On the rim, if not yet at its nearest place, which steps come to slowly where it bends around x.
      const glm::dvec3 rest = x_world - y;
      if (scan.value * scan.value < close * close * aa && cut.value * cut.value < close * close * bb)
        if (const double distance = std::sqrt(glm::dot(rest, rest)); distance < most)
          most = distance, found = y;
      const double s = (-scan.value * bb + cut.value * ab) / det,
                   t = (-cut.value * aa + scan.value * ab) / det;
      const glm::dvec3 along = glm::normalize(glm::cross(a, b)), back = s * a + t * b;
      // It is more than twice as far as `most`, as far as slopes show.
      if (i == 0) {
        const glm::dvec3 there = y + back - x_world, aside = there - glm::dot(there, along) * along;
        if (glm::dot(aside, aside) > 4 * most * most) return most;
      }
      // If the curve bends around x the rest along it falls by less than each step: by the secant.
      const double left = glm::dot(x_world - y, along);
      double onward = left;
      if (last_step != 0)
        if (const double fall = (last_along - left) / last_step; fall > 0.1 && fall < 1) onward = left / fall;
      glm::dvec3 step = back + onward * along;
      const double length = std::sqrt(glm::dot(step, step)), limit = longest_step(true);
      if (!(length < 1e300)) return most;
      const double share = length > limit ? limit / length : 1;
      last_along = left, last_step = share * onward;
      y += share * step;
      if (length < close) return most;
    }
    return most;
  }

  /// Longest Newton step (mm): beyond its band the distance to a cut is flat.
  double longest_step(bool is_cut) const {
    const double usual = 1.5 * finest_;
    return is_cut && version_ ? std::min(usual, 2 * version_->band_mm()) : usual;
  }

  const Field& field_;
  const SoftField* soft_;
  const Version* version_;
  const Frame& frame_;
  double finest_;  ///< of the spacing, mm
};

}  // namespace trephine::volume
