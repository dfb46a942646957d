// Crossings of a view's rays with closed meshes: every ray leaves a closed mesh as often as it enters it,
// even at corners and edges.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "modules/fluoroscopy/c_arm.h"

namespace trephine::fluoroscopy {

/// Triangles in the world frame, mm, counter-clockwise when viewed from outside. Borrowed.
struct ProjectedMesh {
  std::span<const glm::dvec3> vertices_world;
  std::span<const std::uint32_t> triangles;  ///< three indices per triangle
};

/// Crossing of a ray with a triangle.
struct Crossing {
  int column, row;
  std::uint32_t triangle;
  double t;        ///< 0 at the source, 1 at the detector and for all crossings beyond it
  int into;        ///< +1: the ray enters the mesh, -1: it leaves it
  double a, b, c;  ///< barycentric weights of the triangle's corners
};

/// Calls use(crossing) for each triangle and each open pixel whose ray crosses the triangle, in the order of
/// the triangles. A pixel centre on an edge belongs to the triangles on one side of the edge only: corners
/// are rounded to 2^-16 of a pixel, and edges are decided in integers. Returns false, without a call, if a
/// triangle reaches the plane through the source that is parallel to the detector.
bool for_crossings(const View& view, const ProjectedMesh& mesh,
                   const std::function<void(const Crossing&)>& use);

}  // namespace trephine::fluoroscopy
