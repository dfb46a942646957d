#include "haptics/mesh/wall_thickness.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

#include "volume/base/parallel.h"

namespace trephine::haptics {

namespace {

constexpr double k_left_out = 0.001;  // share of the surface with the thinnest walls, which is left out

/// Sets of triangles that share corners (disjoint sets with path halving, Tarjan and van Leeuwen 1984).
class Parts {
 public:
  explicit Parts(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t root(std::uint32_t i) noexcept {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::uint32_t a, std::uint32_t b) noexcept { parent_[root(a)] = root(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

std::size_t count_shells(const MeshTree& surface) {
  std::map<std::tuple<double, double, double>, std::uint32_t> corners;  // one triangle per corner
  Parts parts(surface.triangle_count());
  for (std::uint32_t t = 0; t < surface.triangle_count(); ++t)
    for (const glm::dvec3& p : surface.corners(t))
      parts.unite(t, corners.try_emplace({p.x, p.y, p.z}, t).first->second);
  std::size_t count = 0;
  for (std::uint32_t t = 0; t < surface.triangle_count(); ++t) count += parts.root(t) == t;
  return count;
}

struct Wall {
  double thickness = 0, area = 0;  ///< area 0: no wall
  glm::dvec3 at{0.0};
};

/// Returns the wall below a triangle. `longest`: mm, upper bound of the thickness.
Wall wall_below(const MeshTree& surface, std::uint32_t triangle, double longest) {
  const auto [a, b, c] = surface.corners(triangle);
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double size = glm::length(normal), depth = 2 * surface.gap();
  if (!(size > 0)) return {};
  const glm::dvec3 middle = (a + b + c) / 3.0, start = middle - depth * normal / size;
  FacetHit hit;
  int visited = 0;
  if (!surface.cast(start, start - longest * normal / size, false, true, hit, visited)) return {};
  return {hit.t * longest + depth, size / 2, middle};
}

}  // namespace

WallFacts walls_of(const MeshTree& surface, double limit) {
  constexpr int k_block = 1024;
  WallFacts facts;
  facts.shells = count_shells(surface);
  const double longest = glm::distance(surface.low(), surface.high());
  std::vector<Wall> walls(surface.triangle_count());
  parallel_for(static_cast<int>(walls.size() / k_block) + 1, 0, [&](int block) {
    const std::size_t begin = static_cast<std::size_t>(block) * k_block;
    for (std::size_t t = begin; t < std::min(begin + k_block, walls.size()); ++t)
      walls[t] = wall_below(surface, static_cast<std::uint32_t>(t), longest);
  });
  std::erase_if(walls, [](const Wall& wall) { return wall.area == 0; });
  if (walls.empty()) return facts;
  double area = 0, thin_area = 0;
  for (const Wall& wall : walls) {
    area += wall.area;
    if (wall.thickness < limit) thin_area += wall.area;
  }
  facts.thin_share = thin_area / area;
  std::stable_sort(walls.begin(), walls.end(),
                   [](const Wall& a, const Wall& b) { return a.thickness < b.thickness; });
  double thinner = 0;
  const auto thinnest = std::find_if(walls.begin(), walls.end(), [&](const Wall& wall) {
    return (thinner += wall.area) > k_left_out * area;
  });
  const Wall& found = thinnest == walls.end() ? walls.back() : *thinnest;
  facts.thinnest = found.thickness;
  facts.thinnest_at = found.at;
  return facts;
}

}  // namespace trephine::haptics
