// Entries and exits of a view's rays in closed meshes: every closed mesh is left as often as it is
// entered, on every ray, whatever its corners and edges are aimed at.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "modules/fluoroscopy/c_arm.h"

namespace trephine::fluoroscopy {

/// Triangles in the world, seen from outside counter-clockwise. Borrowed.
struct ProjectedMesh {
  std::span<const glm::dvec3> vertices_world;
  std::span<const std::uint32_t> triangles;  ///< three a triangle
};

/// A ray through a triangle.
struct Crossing {
  int column, row;
  std::uint32_t triangle;
  double t;        ///< 0 at the source, 1 at the detector; not beyond these
  int into;        ///< +1: the ray goes in, -1: it comes out
  double a, b, c;  ///< weights of the triangle's corners there
};

/// Calls use(crossing) for each triangle and each open pixel whose ray crosses it, triangle by triangle.
/// A pixel on the edge between triangles belongs to one side of it (corners are taken to 2^-16 of a pixel,
/// edges decided in whole numbers). False, and nothing is called: a triangle reaches the source's plane.
bool for_crossings(const View& view, const ProjectedMesh& mesh,
                   const std::function<void(const Crossing&)>& use);

}  // namespace trephine::fluoroscopy
