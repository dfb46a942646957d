// Slide: one servo step of the slide as a class. Included by slide.cpp only, so that it is compiled once and
// inlined.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <span>

#include "haptics/proxy/friction.h"
#include "haptics/proxy/slide.h"
#include "haptics/proxy/wall_steps.h"

namespace trephine::haptics {
namespace {

constexpr double k_gap = 1e-7;      // voxels: distance of a resting proxy from a wall
constexpr double k_touch = 2e-3;    // voxels: a nearer wall is touched
constexpr double k_landing = 1e-3;  // voxels: largest distance from a wall at the end of a straight motion
static_assert(k_landing < k_touch, "a motion that a wall stops must end where that wall is touched");
constexpr double k_settled = 2e-4;           // voxels: after a shorter Newton step the error is negligible
constexpr double k_exact = 1e-7;             // voxels: largest remaining error
constexpr int k_max_stages = 8;              // largest number of legs along the surface in a step
constexpr int k_max_newton = 8;              // largest number of Newton steps per stage
constexpr double k_stage = 1.5;              // voxels: longest leg along the surface
constexpr double k_shortest_stage = 0.01;    // voxels: a shorter leg is not tried
constexpr double k_same_normal = 1 - 1e-12;  // cosine between the normals of facets that count as one wall

/// Tangent plane of a wall that the slide left earlier in this step.
struct FrozenPlane {
  glm::dvec3 point_world, normal;
};

/// The slide of one servo step: from the last proxy toward the HIP, straight until walls stop the proxy, then
/// along the walls. An object is used for one step.
template <class Walls>
class Slide {
 public:
  /// `base`: the frame of the state and of the reported path; `walls` may use another frame.
  Slide(const TouchScene& scene, Walls& walls, const volume::Frame& base, ProxyState& state,
        const glm::dvec3& hip_world, ProxyStep& result) noexcept
      : scene_(scene),
        walls_(walls),
        frame_(walls_.frame()),
        base_(base),
        state_(state),
        hip_world_(hip_world),
        hip_(frame_.volume_from_world(hip_world)),
        result_(result) {
    const glm::dvec3 spacing = frame_.spacing();
    voxel_mm_ = std::min(std::min(spacing.x, spacing.y), spacing.z);
  }

  void run() noexcept;

 private:
  double energy(const glm::dvec3& p) const noexcept {
    const glm::dvec3 d = frame_.vector_world_from_volume(hip_ - p);
    return glm::dot(d, d);
  }
  /// Returns the largest distance (mm) from a wall at the end of a straight motion. It is equal for all axes
  /// and walls.
  double landing() const noexcept { return k_landing * voxel_mm_; }
  bool has_own_frame() const noexcept { return &frame_ != &base_; }
  /// Converts a point from the walls' frame to the volume's frame.
  glm::dvec3 in_volume(const glm::dvec3& p) const noexcept {
    if (!has_own_frame()) return p;
    return base_.volume_from_world(p == hip_ ? hip_world_ : frame_.world_from_volume(p));
  }
  /// Converts the path to the volume's frame. Its start is exactly the proxy of the last step.
  void report_path() noexcept {
    if (!has_own_frame()) return;
    for (int i = 0; i < result_.waypoint_count; ++i) {
      glm::dvec3& p = result_.path_volume[static_cast<std::size_t>(i)];
      p = i == 0 && p == start_ ? start_volume_ : in_volume(p);
    }
  }
  void append(const glm::dvec3& p) noexcept {
    if (result_.waypoint_count < k_max_waypoints)
      result_.path_volume[static_cast<std::size_t>(result_.waypoint_count++)] = p;
  }
  /// Records the waypoint and the solids around it if it is the nearest so far.
  void record_if_nearest(const glm::dvec3& p) noexcept {
    const double e = energy(p);
    if (e < best_energy_) {
      best_energy_ = e;
      best_count_ = result_.waypoint_count;
      best_inside_ = inside_;
    }
  }
  /// Returns true if a wall is a sheet of a creased cube, or a stair-step at a face of such a cube.
  static bool is_creased(const Planes& planes) noexcept {
    for (int k = 0; k < planes.count; ++k)
      if (!planes[k].is_frozen && (planes[k].wall.sheet >= 0 || planes[k].wall.is_step)) return true;
    return false;
  }
  bool has_friction(const Wall& wall) const noexcept {
    const Material& material = material_of(scene_, wall.shape, side_of(wall.is_back));
    return material.static_friction > 0 || material.dynamic_friction > 0;
  }
  void set_touched(const Plane& plane) noexcept {
    result_.shape = plane.wall.shape;
    result_.side = side_of(plane.wall.is_back);
    result_.normal_world = -plane.normal;
  }
  /// Returns true if Newton's method has converged. Convergence is quadratic: after steps of lengths q and p
  /// the remaining error is about p^3 / q^2. The arguments are p^2 and q^2.
  bool has_converged(double square, double square_before) const noexcept {
    const double unit = voxel_mm_ * voxel_mm_;
    if (square < k_settled * k_settled * unit) return true;
    return square < k_short_step * k_short_step * unit &&
           square * square * square < k_exact * k_exact * unit * square_before * square_before;
  }
  /// Returns the shapes with p in their solid.
  ShapeSet solids_at(const glm::dvec3& p) noexcept {
    ShapeSet found;
    for (int s = walls_.next_shape(0); s < ShapeSet::k_max; s = walls_.next_shape(s + 1))
      if (walls_.is_solid(s, p)) found.flip(s);
    return found;
  }
  bool begin() noexcept;
  void planes_at(const glm::dvec3& p, double within, Planes& planes) noexcept;
  void plane_of(const Wall& wall, const glm::dvec3& p, Plane& plane) noexcept;
  double max_square_to_walls() const noexcept { return 16 * k_stage * k_stage * voxel_mm_ * voxel_mm_; }
  bool update_planes(Planes& planes, const glm::dvec3& at, const glm::dvec3& p) noexcept;
  bool add_flanks(const glm::dvec3& p_world, const Plane& plane, double coefficient,
                  HoldingWalls& holding) noexcept;
  FrictionLoad load_at(const glm::dvec3& p_world, const Planes& planes, bool is_static) noexcept;
  bool slide_by(const glm::dvec3& from_world, const glm::dvec3& slide, double share, glm::dvec3& to,
                Planes& planes) noexcept;
  void move_back(const glm::dvec3& from, glm::dvec3& to, Planes& planes) noexcept;
  bool is_held_by_friction(const glm::dvec3& from, const Planes& first, glm::dvec3& to,
                           Planes& planes) noexcept;
  glm::dvec3 apply_path_friction() noexcept;
  bool solve(const glm::dvec3& from, double limit, glm::dvec3& to, Planes& planes, bool& is_settled) noexcept;
  bool advance(const glm::dvec3& from, const glm::dvec3& to, const Planes& first, const Planes& last,
               glm::dvec3& at) noexcept;
  bool is_short_motion_free(const Plane& first, const Plane& last, const glm::dvec3& from,
                            const glm::dvec3& middle, const glm::dvec3& to,
                            const volume::QuadraticPatch::HessianBound& bound) noexcept;
  double share_less_rounding(double t, const glm::dvec3& at) const noexcept;
  void freeze(const glm::dvec3& p, const Plane& plane) noexcept;
  void turn_away_from_walls(const Planes& planes, glm::dvec3& out) noexcept;
  void climb_step(const Wall& wall, const Planes& planes, glm::dvec3& at) noexcept;
  void climb_to(const glm::dvec3& to, glm::dvec3& at) noexcept;
  void finish() noexcept;

  const TouchScene& scene_;
  Walls& walls_;
  const volume::Frame &frame_, &base_;  ///< frame of the walls, for all points here; frame of the volume
  ProxyState& state_;
  const glm::dvec3 hip_world_, hip_;
  glm::dvec3 start_{0.0},
      start_volume_{0.0};  ///< proxy of the last step, in the walls' frame and in the volume's
  ProxyStep& result_;
  double voxel_mm_;
  ShapeSet inside_, best_inside_;
  int best_count_ = 1, landing_ = 0;
  double best_energy_ = 1e300;
  Planes planes_, moved_planes_;
  std::array<FrozenPlane, 3> frozen_;
  int frozen_count_ = 0;
  Wall stopping_;  ///< the sheet or stair-step that stopped the last motion; shape -1: no such wall
  bool is_friction_applied_ = false;  ///< friction was applied to a stage
  bool is_in_solid_ = false;          ///< the point of the last planes_at() was in a solid
};

}  // namespace
}  // namespace trephine::haptics
