// winding(): independent judge of whether a point is inside a closed mesh. Computes in integers, without
// projecting triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace trephine::verify {

/// Triangles, counter-clockwise when viewed from outside. The absolute values of the coordinates are below
/// 2^31.
struct IntegerMesh {
  std::vector<std::array<std::int64_t, 3>> corners;
  std::vector<std::uint32_t> triangles;
};

/// Returns the winding number of the surface around p + (e, e^2, e^3), for an infinitesimal e > 0. Each
/// triangle and one fixed far point form a tetrahedron. The winding number is the sum of the orientations (1
/// or -1) of the tetrahedra that contain p + (e, e^2, e^3).
int winding(const IntegerMesh& mesh, const std::array<std::int64_t, 3>& p);

}  // namespace trephine::verify
