#include "modules/fluoroscopy/mesh_crossings.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

namespace trephine::fluoroscopy {

using glm::dvec2;
using glm::dvec3;

namespace {

constexpr int k_fine_bits = 16;
constexpr double k_fine = 1 << k_fine_bits;  // steps per pixel

struct Corner {
  std::int64_t x, y;  // in steps
  double t;           // depth along the rays: 1 on the detector
};

__extension__ using Wide = __int128;

/// Returns twice the signed area of the triangle (a, b, (x, y)); exact for coordinates below 2^62.
Wide side(const Corner& a, const Corner& b, std::int64_t x, std::int64_t y) noexcept {
  return static_cast<Wide>(b.x - a.x) * (y - a.y) - static_cast<Wide>(b.y - a.y) * (x - a.x);
}

/// Returns true if a point on the edge a -> b belongs to the triangle of positive area that has this edge.
/// The result is the same for all triangles on that side of the edge, and the opposite for triangles on the
/// other side, as if the point were moved by (e, e^2) with an infinitesimal e.
bool owns_edge(const Corner& a, const Corner& b) noexcept { return b.y < a.y || (b.y == a.y && b.x > a.x); }

}  // namespace

bool for_crossings(const View& view, const ProjectedMesh& mesh,
                   const std::function<void(const Crossing&)>& use) {
  // Depth 1 is the detector's plane.
  const dvec3 axis = glm::cross(view.right, view.down);
  const double depth_of_plane = glm::dot(view.corner - view.source, axis);
  std::vector<Corner> corners(mesh.vertices_world.size());
  std::vector<std::uint8_t> is_used(corners.size(), 0);
  for (const std::uint32_t v : mesh.triangles) is_used[v] = 1;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!is_used[i]) continue;
    const dvec3 p = mesh.vertices_world[i] - view.source;
    const double t = glm::dot(p, axis) / depth_of_plane;
    if (!(t > 1e-6) || !(t < 1e6)) return false;
    const dvec3 on_plane = view.source + p / t - view.corner;
    const dvec2 at(glm::dot(on_plane, view.right) / glm::dot(view.right, view.right),
                   glm::dot(on_plane, view.down) / glm::dot(view.down, view.down));
    const auto steps = [](double pixels) {
      return static_cast<std::int64_t>(std::llround(std::clamp(pixels, -1e9, 1e9) * k_fine));
    };
    corners[i] = {steps(at.x), steps(at.y), t};
  }
  const auto first_pixel = [](std::int64_t low) {  // first pixel whose centre is not left of `low`
    return static_cast<int>(
        std::clamp<std::int64_t>((low + (1 << k_fine_bits) - 1) >> k_fine_bits, -1, 1 << 20));
  };
  const auto last_pixel = [](std::int64_t high) {
    return static_cast<int>(std::clamp<std::int64_t>(high >> k_fine_bits, -1, 1 << 20));
  };
  for (std::uint32_t n = 0; 3 * n + 2 < mesh.triangles.size(); ++n) {
    std::array<std::uint32_t, 3> index{mesh.triangles[3 * n], mesh.triangles[3 * n + 1],
                                       mesh.triangles[3 * n + 2]};
    std::array<const Corner*, 3> c{&corners[index[0]], &corners[index[1]], &corners[index[2]]};
    Wide area = side(*c[0], *c[1], c[2]->x, c[2]->y);
    if (area == 0) continue;
    // The image is viewed from the detector, with y down: a triangle that faces the detector, where rays
    // leave the mesh, is counter-clockwise in the image, and its area is negative.
    const int into = (area > 0) == (depth_of_plane < 0) ? 1 : -1;
    std::array<int, 3> order{0, 1, 2};
    if (area < 0) std::swap(order[1], order[2]), std::swap(c[1], c[2]), area = -area;
    const auto [x_low, x_high] = std::minmax({c[0]->x, c[1]->x, c[2]->x});
    const auto [y_low, y_high] = std::minmax({c[0]->y, c[1]->y, c[2]->y});
    const int column_low = std::max(view.open.column_low, first_pixel(x_low)),
              column_high = std::min(view.open.column_high - 1, last_pixel(x_high)),
              row_low = std::max(view.open.row_low, first_pixel(y_low)),
              row_high = std::min(view.open.row_high - 1, last_pixel(y_high));
    const bool owns_ab = owns_edge(*c[0], *c[1]), owns_bc = owns_edge(*c[1], *c[2]),
               owns_ca = owns_edge(*c[2], *c[0]);
    for (int row = row_low; row <= row_high; ++row)
      for (int column = column_low; column <= column_high; ++column) {
        const std::int64_t x = static_cast<std::int64_t>(column) << k_fine_bits,
                           y = static_cast<std::int64_t>(row) << k_fine_bits;
        const Wide area_c = side(*c[0], *c[1], x, y), area_a = side(*c[1], *c[2], x, y),
                   area_b = side(*c[2], *c[0], x, y);
        if (area_a < 0 || area_b < 0 || area_c < 0 || (area_c == 0 && !owns_ab) ||
            (area_a == 0 && !owns_bc) || (area_b == 0 && !owns_ca))
          continue;
        // In the image 1 / depth is linear.
        const std::array<double, 3> weight{static_cast<double>(area_a) / static_cast<double>(area) / c[0]->t,
                                           static_cast<double>(area_b) / static_cast<double>(area) / c[1]->t,
                                           static_cast<double>(area_c) / static_cast<double>(area) / c[2]->t};
        const double t = 1 / (weight[0] + weight[1] + weight[2]);
        Crossing crossing{column, row, n, std::min(t, 1.0), into, 0, 0, 0};
        std::array<double, 3> shares{};
        for (std::size_t k = 0; k < 3; ++k) shares[static_cast<std::size_t>(order[k])] = weight[k] * t;
        crossing.a = shares[0], crossing.b = shares[1], crossing.c = shares[2];
        use(crossing);
      }
  }
  return true;
}

}  // namespace trephine::fluoroscopy
