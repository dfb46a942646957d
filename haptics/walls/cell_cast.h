// cast_on_cells(): first crossing of a motion with a surface, by triangles that are made cell by cell.
#pragma once

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "haptics/mesh/god_object.h"
#include "volume/scan/traversal.h"

namespace trephine::haptics {

/// Casts a motion against a surface in cells: cubes between the points of a lattice of `size`.
/// `surface.triangles_of_cell(cell, use)` makes the triangles that the inside of a cell may meet,
/// counter-clockwise in the lattice as viewed from the free side. `empty_box(point)`: a box of points around
/// `point` without solids near them; low > high if unknown. `is_hit`: the motion meets another object at
/// hit.t, and only a nearer hit counts. For a nearer hit, sets all members of `hit` except the shape, and
/// returns true.
template <class Surface, class EmptyBox>
bool cast_on_cells(const Surface& surface, const volume::Frame& frame, const glm::ivec3& size,
                   const EmptyBox& empty_box, const glm::dvec3& a, const glm::dvec3& b, bool is_front,
                   bool is_back, bool is_hit, FacetHit& hit, ProxyCounters& counters) noexcept {
  using glm::dvec3;
  using glm::ivec3;
  bool is_nearer = false;
  const dvec3 motion = b - a;
  const TriangleCrossing crossing(a, motion);
  // A cell begins at a lattice point, but a voxel of the traversal begins half a step before its centre. The
  // motion is shifted by this half step.
  const volume::VoxelBox box{ivec3(-1), size - 1};
  volume::VoxelWalk walk(volume::Segment(a - 0.5, b - 0.5), box);
  while (!walk.is_done()) {
    const ivec3& cell = walk.voxel();
    ++counters.cells;
    // Triangles may extend beyond their cell, so a later cell may have a nearer hit. A hit before this cell
    // is final.
    if ((is_hit || is_nearer) && hit.t < walk.t_enter()) return is_nearer;
    // The far corners of a cell are one point further, so a box of points contains one cell less per axis.
    volume::VoxelBox empty = empty_box(cell);
    empty.high -= 1;
    if (glm::all(glm::lessThanEqual(empty.low, cell)) && glm::all(glm::lessThanEqual(cell, empty.high))) {
      walk.advance_past(empty);
      continue;
    }
    surface.triangles_of_cell(cell, [&](const glm::vec3& i, const glm::vec3& j, const glm::vec3& k) {
      ++counters.triangles;
      const dvec3 p(i), q(j), r(k);
      double t = 0, direction_dot_normal = 0;
      if (!crossing.crosses(p, q, r, t, direction_dot_normal) || ((is_hit || is_nearer) && t >= hit.t))
        return;
      const bool is_from_free = direction_dot_normal < 0;
      if (is_from_free ? !is_front : !is_back) return;
      // The cross product is converted as a covector, so that the normal points to the free side also if the
      // lattice is left-handed.
      const dvec3 normal = glm::normalize(frame.gradient_world_from_volume(glm::cross(q - p, r - p)));
      hit = {t, is_from_free ? normal : -normal, hit.shape, side_of(!is_from_free)};
      is_nearer = true;
    });
    walk.advance();
  }
  return is_nearer;
}

/// Returns true if p is behind such a surface. The first triangle between p and a free corner of its cell
/// decides.
template <class Surface>
bool is_behind_cells(const Surface& surface, const glm::dvec3& p) noexcept {
  using glm::dvec3;
  const glm::ivec3 cell(glm::floor(p));
  const int bits = surface.config(cell);
  if (bits == 0 || bits == 255) return bits == 255;
  int corner = 0;
  while (bits >> corner & 1) ++corner;
  const dvec3 motion = dvec3(cell + glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1)) - p;
  const TriangleCrossing crossing(p, motion);
  double nearest = 2, nearest_facing = 0;
  surface.triangles_of_cell(cell, [&](const glm::vec3& i, const glm::vec3& j, const glm::vec3& k) {
    double t = 0, direction_dot_normal = 0;
    if (crossing.crosses(dvec3(i), dvec3(j), dvec3(k), t, direction_dot_normal) && t < nearest)
      nearest = t, nearest_facing = direction_dot_normal;
  });
  return nearest <= 1 && nearest_facing > 0;
}

}  // namespace trephine::haptics
