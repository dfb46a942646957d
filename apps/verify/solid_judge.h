// winding(): independent judge of points inside a closed mesh, in integers, without projection.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace trephine::verify {

/// Triangles with integer coordinates below 2^31, counter-clockwise when viewed from outside.
struct IntegerMesh {
  std::vector<std::array<std::int64_t, 3>> corners;
  std::vector<std::uint32_t> triangles;
};

/// Returns the winding number of the surface around p + (e, e^2, e^3): the sum of the signs of the
/// tetrahedra, from one far point to each triangle, that contain that point.
int winding(const IntegerMesh& mesh, const std::array<std::int64_t, 3>& p);

}  // namespace trephine::verify
