// SmoothWalls in creased cubes of offset fields: their sheets, and the steps where they end.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <tuple>

#include "haptics/walls/smooth_walls.h"

namespace trephine::haptics {

using glm::dvec3;
using glm::ivec3;

dvec3 SmoothWalls::above_step(const Wall& wall, const dvec3& p, const dvec3& out,
                              glm::bvec3& is_kept) noexcept {
  constexpr double k_free = 1e-6, k_most_square = 1;  // voxels, their square
  const ivec3 here = volume::voxel_of(p);
  dvec3 way = out;
  for (int a = 0; a < 3; ++a) {
    is_kept[a] = is_kept[a] || here[a] != wall.cube[a];
    if (is_kept[a]) way[a] = 0;
  }
  dvec3 q = p;
  for (int i = 0; i < 4; ++i) {
    const volume::ValueAndGradient s = value_and_gradient(wall, q);
    const double slack = k_free * glm::length(s.gradient), slope = -glm::dot(s.gradient, way);
    if (s.value + slack <= 0) return q;
    if (!(slope > 0)) return p;
    q += (s.value + 2 * slack) / slope * way;
    if (!(glm::dot(q - p, q - p) < k_most_square)) return p;
  }
  return p;
}

int SmoothWalls::sheets_near(int shape, volume::CreaseSheets::Mask sheets, const dvec3& p,
                             WallList& walls) noexcept {
  // Cones overlap: the nearest of several sheets with nearly the same normal counts.
  constexpr double k_same = 0.995;  // cosine
  struct Near {
    double depth;  // mm; negative in free space
    dvec3 normal;
    int sheet;
  };
  const ivec3 cube = volume::voxel_of(p);
  std::array<Near, std::tuple_size_v<WallList>> kept;
  std::size_t count = 0;
  for (volume::CreaseSheets::Mask rest = sheets; rest != 0; rest &= rest - 1) {
    const int sheet = std::countr_zero(rest);
    const volume::ValueAndGradient s = value_and_gradient({shape, false, false, 0, sheet, cube}, p);
    const dvec3 gradient = frame().gradient_world_from_volume(s.gradient);
    const double steepness = glm::length(gradient);
    if (!(steepness > 0)) continue;
    const Near near{s.value / steepness, gradient / steepness, sheet};
    std::size_t place = 0;
    while (place < count && glm::dot(kept[place].normal, near.normal) < k_same) ++place;
    if (place < count) {
      if (near.depth > kept[place].depth) kept[place] = near;
      continue;
    }
    if (count == kept.size()) {
      // Replaces the farthest.
      place = static_cast<std::size_t>(
          std::min_element(kept.begin(), kept.end(),
                           [](const Near& a, const Near& b) { return a.depth < b.depth; }) -
          kept.begin());
      if (near.depth <= kept[place].depth) continue;
    } else {
      ++count;
    }
    kept[place] = near;
  }
  for (std::size_t i = 0; i < count; ++i) walls[i] = {shape, false, false, 0, kept[i].sheet, cube};
  return static_cast<int>(count);
}

}  // namespace trephine::haptics
