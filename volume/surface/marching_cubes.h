// LocalCubes: marching cubes (Lorensen and Cline 1987) for single cells, with a generated table. On an
// ambiguous face both cells separate the solid corners, so that the surface has no holes (unlike the table of
// the paper; Duerst 1988). Corners and edges are numbered as in volume/surface/surface_net_cases.h.
#pragma once

#include <array>
#include <cstdint>

#include "volume/surface/cell_samples.h"

namespace trephine::volume {

/// Triangles of one configuration of a cell, as edge numbers, counter-clockwise viewed from the free side.
struct CubeCase {
  std::uint8_t triangle_count = 0;
  std::array<std::array<std::uint8_t, 3>, 8> triangles{};
};

/// Returns true if two edges are on one face of the cell, so that a diagonal between them would be in it.
constexpr bool share_a_face(int e, int f) {
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, side = face & 1;
    const auto is_on = [&](int edge) {
      return edge / 4 != axis && (net_edge_corner(edge) >> axis & 1) == side;
    };
    if (is_on(e) && is_on(f)) return true;
  }
  return false;
}

/// Builds the triangles of a configuration. On each face, each segment goes around a run of solid corners and
/// joins two crossed edges. The segments form loops, which are triangulated without a diagonal in a face.
constexpr CubeCase make_cube_case(int config) {
  std::array<int, 12> next{};
  for (int& n : next) n = -1;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, side = face & 1;
    // Corners around the face, counter-clockwise viewed from outside the cell.
    const int b = (axis + (side ? 1 : 2)) % 3, c = (axis + (side ? 2 : 1)) % 3, base = side << axis;
    const std::array<int, 4> corners{base, base | 1 << b, base | 1 << b | 1 << c, base | 1 << c};
    const auto is_solid = [&](std::size_t i) { return (config >> corners[i % 4] & 1) != 0; };
    const auto edge_after = [&](std::size_t i) {  // from corner i to the next
      const int differs = corners[i % 4] ^ corners[(i + 1) % 4];
      return net_edge(differs == 1 ? 0 : differs == 2 ? 1 : 2, corners[i % 4] & corners[(i + 1) % 4]);
    };
    // Joins both ends of each run of solid corners, so that loops are counter-clockwise around the solid,
    // viewed from the free side.
    for (std::size_t i = 0; i < 4; ++i) {
      if (!is_solid(i) || is_solid(i + 3)) continue;
      std::size_t last = i;
      while (is_solid(last + 1)) ++last;
      next[static_cast<std::size_t>(edge_after(i + 3))] = edge_after(last);
    }
  }
  CubeCase result;
  std::array<bool, 12> is_done{};
  for (int first = 0; first < 12; ++first) {
    if (next[static_cast<std::size_t>(first)] < 0 || is_done[static_cast<std::size_t>(first)]) continue;
    std::array<int, 12> loop{};
    std::size_t n = 0;
    for (int e = first; !is_done[static_cast<std::size_t>(e)]; e = next[static_cast<std::size_t>(e)]) {
      is_done[static_cast<std::size_t>(e)] = true;
      loop[n++] = e;
    }
    while (n >= 3) {
      std::size_t ear = 0;
      for (std::size_t i = 0; n > 3 && i < n; ++i)
        if (!share_a_face(loop[(i + n - 1) % n], loop[(i + 1) % n])) {
          ear = i;
          break;
        }
      result.triangles[result.triangle_count++] = {static_cast<std::uint8_t>(loop[(ear + n - 1) % n]),
                                                   static_cast<std::uint8_t>(loop[ear]),
                                                   static_cast<std::uint8_t>(loop[(ear + 1) % n])};
      for (std::size_t i = ear; i + 1 < n; ++i) loop[i] = loop[i + 1];
      --n;
    }
  }
  return result;
}

constexpr std::array<CubeCase, 256> make_cube_cases() {
  std::array<CubeCase, 256> cases{};
  for (int config = 0; config < 256; ++config)
    cases[static_cast<std::size_t>(config)] = make_cube_case(config);
  return cases;
}

inline constexpr std::array<CubeCase, 256> k_cube_cases = make_cube_cases();

/// Computes the triangles of single cells. A vertex depends only on its grid edge, so that neighbouring cells
/// have bit-identical vertices on their common face. Any thread; allocates nothing. `Samples`: see
/// volume/surface/cell_samples.h.
template <class Samples>
class LocalCubes {
 public:
  explicit LocalCubes(const Samples& samples) : samples_(samples) {}

  int config(const glm::ivec3& cell) const noexcept { return config_of(samples_, cell); }

  /// Calls use(a, b, c) for each triangle in `cell`.
  template <class Use>
  void triangles_of_cell(const glm::ivec3& cell, Use&& use) const noexcept {
    const CubeCase& cubes = k_cube_cases[static_cast<std::size_t>(config(cell))];
    for (std::size_t t = 0; t < cubes.triangle_count; ++t) {
      const auto& [a, b, c] = cubes.triangles[t];
      use(vertex(cell, a), vertex(cell, b), vertex(cell, c));
    }
  }

 private:
  glm::vec3 vertex(const glm::ivec3& cell, int edge) const noexcept {
    const int axis = edge / 4, corner = net_edge_corner(edge);
    const glm::ivec3 low = cell + glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    glm::ivec3 high = low;
    ++high[axis];
    glm::vec3 p(low);
    if (samples_.is_solid(low))
      p[axis] += samples_.crossing(low, high);
    else
      p[axis] = static_cast<float>(high[axis]) - samples_.crossing(high, low);
    return p;
  }

  Samples samples_;
};

}  // namespace trephine::volume
