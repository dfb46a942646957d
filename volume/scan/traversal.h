// VoxelWalk: exact voxel traversal (Amanatides and Woo 1987) in the half-voxel shifted frame: voxel i is the
// half-open cube [i - 0.5, i + 0.5), so (0.5, 0, 0) belongs to the higher voxel.
//
// A segment through lattice planes, edges or corners is traced as if it were moved by (e, e^2, e^3), e -> 0+.
// The moved segment passes through no edge or corner, its voxels are 6-connected, and the reverse segment
// visits the same voxels. No tolerance affects the result: crossings are ordered by floating point with an
// error bound, and by exact arithmetic within the bound.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

#include "volume/base/exact_order.h"

namespace trephine::volume {

/// Coordinates of a traversal must be finite and below this magnitude (voxels).
inline constexpr double k_traversal_limit = 1 << 30;

/// Returns the voxel that contains p (volume frame). Exact, unlike floor(p + 0.5), which can round up just
/// below a plane.
inline glm::ivec3 voxel_of(const glm::dvec3& p) noexcept {
  glm::ivec3 v;
  for (int a = 0; a < 3; ++a) {
    // floor() by truncation and correction, which avoids a call on CPUs without a floor instruction.
    const double shifted = p[a] + 0.5;
    int k = static_cast<int>(shifted);
    k -= shifted < k;
    k -= p[a] < k - 0.5;
    k += p[a] >= k + 0.5;
    v[a] = k;
  }
  return v;
}

/// A crossed voxel face: its axis and the direction of travel along it.
struct VoxelFace {
  int axis = -1;  ///< 0 x, 1 y, 2 z; -1: no face, the segment starts in the voxel
  int step = 0;   ///< -1 or +1
};

/// A voxel on the segment start + t (end - start).
struct VoxelVisit {
  glm::ivec3 voxel;
  double t_enter;  ///< in [0, 1]
  double t_exit;   ///< in [t_enter, 1]
  VoxelFace face;  ///< face of entry
};

/// Box of the voxels low .. high, both included.
struct VoxelBox {
  glm::ivec3 low, high;
  bool contains(const glm::ivec3& v) const noexcept {
    return v.x >= low.x && v.y >= low.y && v.z >= low.z && v.x <= high.x && v.y <= high.y && v.z <= high.z;
  }
};

/// Computes the order in which a segment crosses lattice planes. Positions: volume frame, magnitudes below
/// k_traversal_limit.
class Segment {
 public:
  Segment(const glm::dvec3& start, const glm::dvec3& end) noexcept
      : start_(start), end_(end), first_(voxel_of(start)), last_(voxel_of(end)) {
    for (int a = 0; a < 3; ++a) {
      step_[a] = end[a] > start[a] ? 1 : end[a] < start[a] ? -1 : 0;
      inverse_[a] = step_[a] != 0 ? 1.0 / (end[a] - start[a]) : 0.0;
    }
  }

  const glm::ivec3& first() const noexcept { return first_; }
  const glm::ivec3& last() const noexcept { return last_; }
  int step(int axis) const noexcept { return step_[axis]; }
  const glm::dvec3& start() const noexcept { return start_; }
  const glm::dvec3& end() const noexcept { return end_; }

  /// Plane through which the segment leaves voxel index k along `axis`.
  double exit_plane(int axis, int k) const noexcept { return k + 0.5 * step_[axis]; }
  /// Parameter at which the segment crosses `plane`; accurate to 2 ulp, without errors that accumulate.
  double parameter(int axis, double plane) const noexcept { return (plane - start_[axis]) * inverse_[axis]; }

  /// Returns true if plane_a is crossed before plane_b. Requires axis_a != axis_b and motion along both.
  bool precedes(int axis_a, double plane_a, int axis_b, double plane_b) const noexcept {
    return precedes(axis_a, plane_a, parameter(axis_a, plane_a), axis_b, plane_b, parameter(axis_b, plane_b));
  }
  bool precedes(int axis_a, double plane_a, double t_a, int axis_b, double plane_b,
                double t_b) const noexcept {
    // Each parameter carries at most 4 roundings of 2^-53.
    constexpr double k_bound = 0x1p-50;
    const double gap = t_a - t_b, tolerance = k_bound * (std::abs(t_a) + std::abs(t_b));
    if (gap < -tolerance) return true;
    if (gap > tolerance) return false;
    return precedes_exactly(axis_a, plane_a, axis_b, plane_b);
  }

  /// Voxel index along `axis` immediately after the segment crosses `plane` of another axis.
  int index_after(int axis, int crossed_axis, double plane) const noexcept {
    if (step_[axis] == 0 || first_[axis] == last_[axis]) return first_[axis];
    const double t = parameter(crossed_axis, plane);
    const int low = std::min(first_[axis], last_[axis]), high = std::max(first_[axis], last_[axis]);
    const double guess = std::floor(start_[axis] + t * (end_[axis] - start_[axis]) + 0.5);
    int k = static_cast<int>(guess < low ? low : guess > high ? high : guess);
    while (k != last_[axis] && precedes(axis, exit_plane(axis, k), crossed_axis, plane)) k += step_[axis];
    while (k != first_[axis] && !precedes(axis, exit_plane(axis, k - step_[axis]), crossed_axis, plane))
      k -= step_[axis];
    return k;
  }

 private:
  /// Breaks ties by the perturbation (e, e^2, e^3): the direction along the lower axis decides.
  bool precedes_exactly(int a, double plane_a, int b, double plane_b) const noexcept {
    const int order = compare_crossings_exactly(start_[a], end_[a], plane_a, start_[b], end_[b], plane_b);
    if (order != 0) return order < 0;
    return a < b ? step_[a] > 0 : step_[b] < 0;
  }

  glm::dvec3 start_, end_, inverse_;
  glm::ivec3 first_, last_, step_;
};

/// Walks a segment voxel by voxel inside a box.
class VoxelWalk {
 public:
  /// Starts at the first voxel of the segment inside `box`; is_done() is true if there is no such voxel.
  VoxelWalk(const Segment& segment, const VoxelBox& box) noexcept : segment_(segment), box_(box) {
    voxel_ = segment.first();
    last_index_ = segment.last();
    if (!box.contains(voxel_) && !enter_box()) is_done_ = true;
    for (int a = 0; a < 3; ++a) refresh(a);
    choose_exit();
  }

  bool is_done() const noexcept { return is_done_; }
  const glm::ivec3& voxel() const noexcept { return voxel_; }
  double t_enter() const noexcept { return t_enter_; }
  double t_exit() const noexcept {
    return exit_axis_ < 0 ? 1.0 : std::min(1.0, std::max(t_enter_, t_next_[exit_axis_]));
  }
  const VoxelFace& face() const noexcept { return face_; }
  VoxelVisit visit() const noexcept { return {voxel_, t_enter_, t_exit(), face_}; }

  /// Moves to the next voxel; is_done() becomes true when the segment ends or leaves the box.
  void advance() noexcept {
    if (exit_axis_ < 0) {
      is_done_ = true;
      return;
    }
    const int a = exit_axis_;
    voxel_[a] += segment_.step(a);
    if (voxel_[a] < box_.low[a] || voxel_[a] > box_.high[a]) is_done_ = true;
    enter(a, t_next_[a]);
    refresh(a);
    choose_exit();
  }

  /// Moves to the first voxel after the region `skip`, which contains the current voxel.
  void advance_past(const VoxelBox& skip) noexcept {
    // Finds the first plane at which the segment leaves the region.
    int axis = -1;
    double plane = 0;
    for (int a = 0; a < 3; ++a) {
      const int step = segment_.step(a);
      if (step == 0) continue;
      const int edge = step > 0 ? skip.high[a] : skip.low[a];
      if (step > 0 ? last_index_[a] <= edge : last_index_[a] >= edge) continue;
      const double candidate = segment_.exit_plane(a, edge);
      if (axis < 0 || segment_.precedes(a, candidate, axis, plane)) {
        axis = a;
        plane = candidate;
      }
    }
    if (axis < 0) {
      is_done_ = true;
      return;
    }
    jump(axis, plane);
    if (!box_.contains(voxel_)) is_done_ = true;
    for (int a = 0; a < 3; ++a) refresh(a);
    choose_exit();
  }

 private:
  void enter(int axis, double t) noexcept {
    t_enter_ = std::min(1.0, std::max(t_enter_, t));
    face_ = {axis, segment_.step(axis)};
  }
  void refresh(int a) noexcept {
    next_plane_[a] = segment_.exit_plane(a, voxel_[a]);
    t_next_[a] = voxel_[a] == last_index_[a] ? 2.0 : segment_.parameter(a, next_plane_[a]);
  }
  void choose_exit() noexcept {
    int best = voxel_[0] != last_index_[0] ? 0 : -1;
    for (int a = 1; a < 3; ++a) {
      if (voxel_[a] == last_index_[a]) continue;
      if (best < 0 ||
          segment_.precedes(a, next_plane_[a], t_next_[a], best, next_plane_[best], t_next_[best]))
        best = a;
    }
    exit_axis_ = best;
  }
  /// Moves to the voxel immediately after `plane` of `axis`.
  void jump(int axis, double plane) noexcept {
    for (int b = 0; b < 3; ++b)
      if (b != axis) voxel_[b] = segment_.index_after(b, axis, plane);
    voxel_[axis] = static_cast<int>(plane + 0.5 * segment_.step(axis));
    enter(axis, segment_.parameter(axis, plane));
  }
  /// Moves to the last of the entry planes of the box. Returns false if the segment misses the box.
  bool enter_box() noexcept {
    int axis = -1;
    double plane = 0;
    for (int a = 0; a < 3; ++a) {
      const int k = segment_.first()[a];
      if (k >= box_.low[a] && k <= box_.high[a]) continue;
      const int step = segment_.step(a), edge = k < box_.low[a] ? box_.low[a] : box_.high[a];
      const bool is_toward =
          k < box_.low[a] ? step > 0 && last_index_[a] >= edge : step < 0 && last_index_[a] <= edge;
      if (!is_toward) return false;
      const double candidate = segment_.exit_plane(a, edge - step);
      if (axis < 0 || segment_.precedes(axis, plane, a, candidate)) {
        axis = a;
        plane = candidate;
      }
    }
    jump(axis, plane);
    return box_.contains(voxel_);
  }

  Segment segment_;
  VoxelBox box_;
  glm::ivec3 voxel_, last_index_;
  glm::dvec3 t_next_, next_plane_;
  double t_enter_ = 0;
  VoxelFace face_;
  int exit_axis_ = -1;
  bool is_done_ = false;
};

/// Calls visit(const VoxelVisit&) for every voxel of the segment inside the box, in order; stops when visit()
/// returns false.
template <class Visit>
void traverse(const glm::dvec3& start, const glm::dvec3& end, const VoxelBox& box, Visit&& visit) {
  for (VoxelWalk walk(Segment(start, end), box); !walk.is_done(); walk.advance())
    if (!visit(walk.visit())) return;
}

}  // namespace trephine::volume
