#include "haptics/proxy/implicit_proxy.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "haptics/walls/barrier.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_margin = 0x1p-10;  // voxels: distance that the proxy keeps from a wall
constexpr double k_lift = 0.05;       // voxels: lift along the normal, to climb the stair-steps of a slope

/// Returns the point of the motion just before the wall. It is clamped to the cube of the last free voxel.
dvec3 stop_before(const dvec3& start, const dvec3& end, const MotionEnd& hit) noexcept {
  dvec3 p = start + hit.t * (end - start);
  for (int a = 0; a < 3; ++a)
    p[a] = std::clamp(p[a], hit.before[a] - 0.5 + k_margin, hit.before[a] + 0.5 - k_margin);
  return p;
}

/// Returns `end` if no wall blocks the motion from `start` to it, else a nearer point that is proven free by
/// a traversal, or `start`.
template <class Grid>
dvec3 guarded_move(const TouchScene& scene, const Grid& grid, const dvec3& start, dvec3 end,
                   const ShapeSet& passable, ShapeSet& inside, ProxyCounters& counters) noexcept {
  for (int attempt = 0; attempt < 3; ++attempt) {
    ShapeSet after = inside;
    const MotionEnd barrier = find_barrier(scene, grid, start, end, passable, after, counters);
    if (!barrier.is_blocked) {
      inside = after;
      return end;
    }
    end = start + (0.5 * barrier.t) * (end - start);
  }
  return start;
}

template <class Grid>
void step_on_cubes(const TouchScene& scene, const Grid& grid, int iterations, const ProxyInput& input,
                   ProxyState& state, ProxyStep& result) noexcept {
  if (begin_on_cubes(scene, grid, input.hip_world, state, result)) return;
  const volume::Frame& frame = grid.frame();
  const dvec3 hip = frame.volume_from_world(input.hip_world);
  dvec3 start = state.proxy_volume, target = hip;
  result.add_waypoint(start);
  ShapeSet inside = state.inside;
  int best_count = 1;
  double best_energy = 1e300;
  // Records the newest waypoint, and returns true, if it is nearer to the HIP than all earlier ones.
  const auto record_if_nearer = [&](const dvec3& p) {
    const double energy = squared_mm(frame, p, hip);
    if (energy >= best_energy) return false;
    best_energy = energy;
    best_count = result.waypoint_count;
    return true;
  };
  for (int i = 0; i < iterations; ++i) {
    ++result.counters.iterations;
    const MotionEnd barrier =
        find_barrier(scene, grid, start, target, state.around.passable, inside, result.counters);
    if (!barrier.is_blocked) {
      result.add_waypoint(target);
      record_if_nearer(target);
      break;
    }

    // Moves to the wall, within the last free voxel. If this voxel is not that of the start, the clamped
    // point may be off the traversed motion and is tested.
    dvec3 p = stop_before(start, target, barrier);
    if (volume::voxel_of(start) != barrier.before)
      p = guarded_move(scene, grid, start, p, state.around.passable, inside, result.counters);
    // Finds the normal of the wall, toward the proxy. The face's normal replaces an interpolated normal
    // toward the HIP, which would pull the proxy through the wall.
    dvec3 normal = grid.normal(static_cast<std::size_t>(barrier.shape), p, result.counters.cells);
    if (barrier.is_back) normal = -normal;
    const dvec3 p_world = frame.world_from_volume(p);
    if (glm::dot(input.hip_world - p_world, normal) >= 0) normal = voxel_face_normal(frame, barrier.face);
    if (!result.has_contact) result.set_contact(barrier.shape, side_of(barrier.is_back), normal);
    // Lifts the point off the wall along the normal, as far as the motion is free.
    result.add_waypoint(p);
    const dvec3 direction = frame.vector_volume_from_world(normal);
    const dvec3 lifted = p + (k_lift / glm::length(direction)) * direction;
    start = volume::voxel_of(lifted) == volume::voxel_of(p)
                ? lifted
                : guarded_move(scene, grid, p, lifted, state.around.passable, inside, result.counters);
    result.add_waypoint(start);
    if (record_if_nearer(start)) result.set_contact(barrier.shape, side_of(barrier.is_back), normal);
    const double depth = glm::dot(input.hip_world - p_world, normal);
    if (depth >= 0) break;  // the HIP is on the free side of this wall: no slide
    target = frame.volume_from_world(input.hip_world - depth * normal);
  }

  // Ends at the nearest candidate, with friction along the path to it.
  result.waypoint_count = best_count;
  end_on_cubes(scene, grid, input.hip_world, landing_of_first_leg(result), state, result);
}

}  // namespace

ImplicitProxy::ImplicitProxy(int iterations) noexcept
    : iterations_(std::clamp(iterations, 1, k_max_iterations)) {}

Status ImplicitProxy::prepare(const TouchScene& scene) {
  if (Status error = check_burr_opens_voxels(scene)) return error;
  return check_touchable(scene, info());
}

ProxyStep ImplicitProxy::step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                              const ProxyInput& input) const noexcept {
  return step_on_grid(scene, touch_state, state, input,
                      [&](const auto& grid, ProxyState& on_grid, ProxyStep& result) {
                        step_on_cubes(scene, grid, iterations_, input, on_grid, result);
                      });
}

}  // namespace trephine::haptics
