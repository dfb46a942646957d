#include "volume/scan/field.h"

#include "volume/scan/trilinear.h"

namespace trephine::volume {

namespace {

/// Reads g at the corners of a cell; without bounds checks if the whole cell is inside the grid.
CellCorners corners_of(const Field& field, const glm::ivec3& c) noexcept {
  const Volume& v = field.volume();
  CellCorners g;
  const bool is_inside =
      c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x + 1 < v.size.x && c.y + 1 < v.size.y && c.z + 1 < v.size.z;
  if (is_inside) {
    const std::size_t i = v.index(c.x, c.y, c.z);
    const std::size_t row = static_cast<std::size_t>(v.size.x),
                      slice = row * static_cast<std::size_t>(v.size.y);
    const std::size_t at[4] = {i, i + row, i + slice, i + slice + row};
    for (std::size_t k = 0; k < 4; ++k) {
      g[2 * k] = field.at_index(at[k]);
      g[2 * k + 1] = field.at_index(at[k] + 1);
    }
  } else {
    for (int k = 0; k < 8; ++k)
      g[static_cast<std::size_t>(k)] = field.at(c.x + (k & 1), c.y + (k >> 1 & 1), c.z + (k >> 2 & 1));
  }
  return g;
}

}  // namespace

double Field::value(const glm::dvec3& p) const noexcept {
  const CellPoint q(p);
  return trilinear_value(corners_of(*this, q.cell), q.at);
}

glm::dvec3 Field::gradient(const glm::dvec3& p) const noexcept {
  const CellPoint q(p);
  return trilinear_gradient(corners_of(*this, q.cell), q.at);
}

glm::dvec3 Field::smooth_gradient(const glm::dvec3& p) const noexcept {
  const CellPoint q(p);
  const glm::ivec3 c = q.cell;
  const Volume& v = *volume_;

  // The 4 x 4 x 4 neighbourhood; samples on its edges are never used.
  double g[4][4][4];
  const bool is_inside =
      c.x >= 1 && c.y >= 1 && c.z >= 1 && c.x + 2 < v.size.x && c.y + 2 < v.size.y && c.z + 2 < v.size.z;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 4; ++j) {
      const bool is_edge = (k == 0 || k == 3) && (j == 0 || j == 3);
      if (is_edge) continue;
      if (is_inside) {
        const std::size_t row = v.index(c.x - 1, c.y + j - 1, c.z + k - 1);
        for (std::size_t i = 0; i < 4; ++i) g[k][j][i] = at_index(row + i);
      } else {
        for (int i = 0; i < 4; ++i) g[k][j][i] = at(c.x + i - 1, c.y + j - 1, c.z + k - 1);
      }
    }

  // Interpolates the differences over the cell; the factor 1/2 below makes them per voxel step.
  CellCorners dx, dy, dz;
  for (int n = 0; n < 8; ++n) {
    const int i = (n & 1) + 1, j = (n >> 1 & 1) + 1, k = (n >> 2 & 1) + 1;
    const auto m = static_cast<std::size_t>(n);
    dx[m] = g[k][j][i + 1] - g[k][j][i - 1];
    dy[m] = g[k][j + 1][i] - g[k][j - 1][i];
    dz[m] = g[k + 1][j][i] - g[k - 1][j][i];
  }
  return 0.5 * glm::dvec3(trilinear_value(dx, q.at), trilinear_value(dy, q.at), trilinear_value(dz, q.at));
}

}  // namespace trephine::volume
