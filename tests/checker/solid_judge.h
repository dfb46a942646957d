// An independent judge of what lies within a closed mesh: whole numbers, no projection, no floating point.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace trephine::checker {

/// Corners with whole coordinates below 2^31, three a triangle, seen from outside counter-clockwise.
struct WholeMesh {
  std::vector<std::array<std::int64_t, 3>> corners;
  std::vector<std::uint32_t> triangles;
};

/// How often the surface goes around p + (e, e^2, e^3): the sum of the signs of those tetrahedra, from one
/// far place to each triangle, in which that lies.
int winding(const WholeMesh& mesh, const std::array<std::int64_t, 3>& p);

}  // namespace trephine::checker
