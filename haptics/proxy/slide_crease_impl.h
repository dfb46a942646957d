// Slide in creases: motion over the stair-steps at the border of creased cubes. Included by slide.cpp only.
#pragma once

#include "haptics/proxy/slide_impl.h"

namespace trephine::haptics {
namespace {

/// Turns the direction `out` away from all walls. If several sheets belong to one flank, the mean of the
/// normals may otherwise lead into a wall of another flank.
template <class Walls>
void Slide<Walls>::turn_away_from_walls(const Planes& planes, glm::dvec3& out) noexcept {
  if (planes.count < 3) return;
  std::array<glm::dvec3, k_max_planes> normals;
  for (int k = 0; k < planes.count; ++k) normals[static_cast<std::size_t>(k)] = planes[k].normal;
  out = turned_away(out, std::span(normals.data(), static_cast<std::size_t>(planes.count)));
}

/// Called after a wall stopped a motion at `at`. If the wall is a stair-step of the solid, moves the proxy to
/// the top of the stair-step. A sheet or a stair-step is stored in stopping_, so that it is one of the planes
/// of the next leg.
template <class Walls>
void Slide<Walls>::climb_step(const Wall& wall, const Planes& planes, glm::dvec3& at) noexcept {
  stopping_ = wall.is_step || wall.sheet >= 0 ? wall : Wall{};
  // The motion up may meet the faces of further cubes.
  constexpr int k_max_faces = 3;
  if (!wall.is_step || result_.waypoint_count + k_max_faces + 4 > k_max_waypoints) return;
  const ShapeSet inside = inside_;
  const int count = result_.waypoint_count;
  glm::bvec3 is_kept(false);
  glm::dvec3 p = at;
  Wall step = wall;
  for (int i = 0; i < k_max_faces; ++i) {
    Plane plane;
    plane_of(step, p, plane);
    std::array<glm::dvec3, k_max_planes + 1> normals{plane.normal};
    std::size_t normal_count = 1;
    for (int k = 0; k < planes.count; ++k)
      if (!planes[k].is_frozen) normals[normal_count++] = planes[k].normal;
    const glm::dvec3 above = walls_.above_step(step, p, std::span(normals.data(), normal_count), is_kept);
    if (above == p) break;
    const Reach reach = walls_.reach(p, above, inside_, landing());
    p += reach.t * (above - p);
    append(p);
    if (!reach.is_blocked) {
      at = p;
      record_if_nearest(at);
      return;
    }
    if (!reach.wall.is_step) break;
    step = reach.wall;
  }
  inside_ = inside;
  result_.waypoint_count = count;
}

/// After a climb to `at`, continues to the point `to` on the walls, over further stair-steps if necessary.
template <class Walls>
void Slide<Walls>::climb_to(const glm::dvec3& to, glm::dvec3& at) noexcept {
  constexpr int k_max_climbs = 3;
  for (int i = 0; i < k_max_climbs && result_.waypoint_count + 4 <= k_max_waypoints; ++i) {
    planes_at(at, k_touch * voxel_mm_, planes_);
    moved_planes_.copy_from(planes_);
    const glm::dvec3 from = at, from_world = frame_.world_from_volume(from),
                     to_world = frame_.world_from_volume(to);
    if (planes_.count == 0 || !update_planes(moved_planes_, to_world, to_world - from_world)) return;
    stopping_ = {};
    const bool has_arrived = advance(from, to, planes_, moved_planes_, at);
    record_if_nearest(at);
    if (has_arrived) set_touched(moved_planes_[0]);
    if (has_arrived || at == from || !stopping_.is_step) return;
  }
}

}  // namespace
}  // namespace trephine::haptics
