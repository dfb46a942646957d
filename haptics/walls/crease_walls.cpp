// SmoothWalls in creased cubes of offset fields: the sheets of these cubes, and the steps of the solid at
// their faces.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>
#include <tuple>

#include "haptics/walls/smooth_walls.h"

namespace trephine::haptics {

using glm::dvec3;
using glm::ivec3;

dvec3 turned_away(dvec3 direction, std::span<const dvec3> normals) noexcept {
  constexpr double k_min = 0.1;  // cosine
  constexpr int k_max_turns = 12;
  for (int i = 0; i < k_max_turns && !normals.empty(); ++i) {
    const double size = glm::length(direction);
    const dvec3& worst = *std::max_element(
        normals.begin(), normals.end(),
        [&](const dvec3& a, const dvec3& b) { return glm::dot(direction, a) < glm::dot(direction, b); });
    if (glm::dot(direction, worst) < -k_min * size) break;
    direction -= size / (i + 1) * worst;
  }
  return direction;
}

dvec3 SmoothWalls::above_step(const Wall& wall, const dvec3& p, std::span<const dvec3> normals_world,
                              glm::bvec3& is_kept) noexcept {
  constexpr double k_free = 1e-6;     // voxels
  constexpr double k_max_square = 1;  // voxels^2
  // A wall is ignored if a smaller share of its gradient is along the free axes.
  constexpr double k_across = 0.05;
  const ivec3 here = volume::voxel_of(p);
  for (int a = 0; a < 3; ++a) is_kept[a] = is_kept[a] || here[a] != wall.cube[a];
  std::array<dvec3, 8> gradients;
  std::size_t count = 0;
  for (const dvec3& normal : normals_world) {
    dvec3 g = normal * frame().axes();
    const double whole = glm::length(g);
    for (int a = 0; a < 3; ++a)
      if (is_kept[a]) g[a] = 0;
    const double size = glm::length(g);
    if (size > k_across * whole && count < gradients.size()) gradients[count++] = g / size;
  }
  dvec3 direction(0);
  for (std::size_t k = 0; k < count; ++k) direction -= gradients[k];
  if (direction == dvec3(0) && count > 0) direction = -gradients[0];
  direction = turned_away(direction, std::span(gradients.data(), count));
  dvec3 q = p;
  for (int i = 0; i < 4; ++i) {
    const volume::ValueAndGradient s = value_and_gradient(wall, q);
    const double slack = k_free * glm::length(s.gradient), slope = -glm::dot(s.gradient, direction);
    if (s.value + slack <= 0) return q;
    if (!(slope > 0)) return p;
    q += (s.value + 2 * slack) / slope * direction;
    if (!(glm::dot(q - p, q - p) < k_max_square)) return p;
  }
  return p;
}

bool SmoothWalls::is_near_crease(int shape, const dvec3& p) const noexcept {
  const ivec3 cube = volume::voxel_of(p);
  for (int n = 0; n < 27; ++n)
    if (sheets_at(shape, cube + ivec3(n % 3, n / 3 % 3, n / 9) - 1) != 0) return true;
  return false;
}

int SmoothWalls::sheets_near(int shape, volume::CreaseSheets::Mask sheets, const dvec3& p,
                             WallList& walls) noexcept {
  // The cones of normals that define sheets overlap. Of several sheets with nearly the same normal, only the
  // nearest one counts.
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
      // Replaces the farthest sheet, which has the least depth.
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
