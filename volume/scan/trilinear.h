// Trilinear interpolation in one cell. Element i of CellCorners is the value at corner (i & 1, i >> 1 & 1,
// i >> 2 & 1).
#pragma once

#include <array>
#include <cmath>
#include <glm/vec3.hpp>

namespace trephine::volume {

using CellCorners = std::array<double, 8>;

/// The cell that contains p (its lowest corner) and the position of p in it, each coordinate in [0, 1).
struct CellPoint {
  glm::ivec3 cell;
  glm::dvec3 at;
  explicit CellPoint(const glm::dvec3& p) noexcept {
    for (int a = 0; a < 3; ++a) {
      int low = static_cast<int>(p[a]);
      low -= p[a] < low;
      cell[a] = low;
      at[a] = p[a] - low;
    }
  }
};

inline double trilinear_value(const CellCorners& c, const glm::dvec3& f) noexcept {
  const double c00 = c[0] + f.x * (c[1] - c[0]), c10 = c[2] + f.x * (c[3] - c[2]);
  const double c01 = c[4] + f.x * (c[5] - c[4]), c11 = c[6] + f.x * (c[7] - c[6]);
  const double c0 = c00 + f.y * (c10 - c00), c1 = c01 + f.y * (c11 - c01);
  return c0 + f.z * (c1 - c0);
}

inline glm::dvec3 trilinear_gradient(const CellCorners& c, const glm::dvec3& f) noexcept {
  const double c00 = c[0] + f.x * (c[1] - c[0]), c10 = c[2] + f.x * (c[3] - c[2]);
  const double c01 = c[4] + f.x * (c[5] - c[4]), c11 = c[6] + f.x * (c[7] - c[6]);
  const double dx0 = (c[1] - c[0]) + f.y * ((c[3] - c[2]) - (c[1] - c[0]));
  const double dx1 = (c[5] - c[4]) + f.y * ((c[7] - c[6]) - (c[5] - c[4]));
  const double c0 = c00 + f.y * (c10 - c00), c1 = c01 + f.y * (c11 - c01);
  return {dx0 + f.z * (dx1 - dx0), (c10 - c00) + f.z * ((c11 - c01) - (c10 - c00)), c1 - c0};
}

}  // namespace trephine::volume
