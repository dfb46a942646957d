// The surface net around single cells, made when it is asked for: the triangles of the whole surface, bit for
// bit.
#pragma once

#include <array>
#include <utility>

#include "volume/cell_samples.h"

namespace trephine::volume {

/// Two triangles (0, 1, 2) and (0, 2, 3) around one crossed grid edge; in voxels, seen from the free side
/// counter-clockwise (in a right-handed frame).
struct NetQuad {
  std::array<glm::vec3, 4> corners;

  /// Calls use(a, b, c) for each.
  template <class Use>
  void triangles(Use&& use) const {
    use(corners[0], corners[1], corners[2]);
    use(corners[0], corners[2], corners[3]);
  }
};

/// Any thread; allocates nothing. `Samples`: see volume/cell_samples.h.
template <class Samples>
class LocalNet {
 public:
  explicit LocalNet(const Samples& samples) : samples_(samples) {}

  int config(const glm::ivec3& cell) const noexcept { return config_of(samples_, cell); }

  /// Patches of a cell; where two patches pinch at a face, both its cells know.
  const NetCase& case_of(const glm::ivec3& cell) const noexcept {
    const std::size_t bits = table_bits(cell);
    const NetCase* net = &k_net_cases[0][bits];
    if (net->pinch_face >= 0) {
      glm::ivec3 other = cell;
      other[net->pinch_face / 2] += net->pinch_face % 2 ? 1 : -1;
      if (k_net_cases[0][table_bits(other)].pinch_face == (net->pinch_face ^ 1)) net = &k_net_cases[1][bits];
    }
    return *net;
  }

  /// The quad around the crossed edge from voxel `low` one step along `axis`.
  NetQuad quad(const glm::ivec3& low, int axis) const noexcept {
    // The four cells around the edge, counter-clockwise seen from its high end.
    const int first = (axis + 1) % 3, second = (axis + 2) % 3;
    NetQuad quad;
    const int corners[4] = {1 << first | 1 << second, 1 << second, 0, 1 << first};
    for (std::size_t i = 0; i < 4; ++i) {
      const int corner = corners[i];
      const glm::ivec3 cell = low - glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
      quad.corners[i] = vertex(cell, net_edge(axis, corner));
    }
    // Solid at the low end faces its high end; else turned round.
    if (!samples_.is_solid(low)) std::swap(quad.corners[1], quad.corners[3]);
    return quad;
  }

  /// Calls use(quad) for every quad that the inside of `cell` may meet: those around its crossed edges, at
  /// most twelve. A quad lies in the four cells around its edge.
  template <class Use>
  void quads_of_cell(const glm::ivec3& cell, Use&& use) const noexcept {
    const int bits = config(cell);
    if (bits == 0 || bits == 255) return;
    for (int e = 0; e < 12; ++e) {
      const int axis = e / 4, corner = net_edge_corner(e);
      if ((bits >> corner & 1) == (bits >> (corner | 1 << axis) & 1)) continue;
      use(quad(cell + glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1), axis));
    }
  }
  /// Calls use(a, b, c) for each triangle.
  template <class Use>
  void triangles_of_cell(const glm::ivec3& cell, Use&& use) const noexcept {
    quads_of_cell(cell, [&](const NetQuad& quad) { quad.triangles(use); });
  }

 private:
  /// The table keeps solid corners apart on ambiguous faces. Samples that want them joined, so that leaning
  /// walls of one layer hold, are looked up as if air were solid: the same edges, the other patches.
  std::size_t table_bits(const glm::ivec3& cell) const noexcept {
    int bits = config(cell);
    if constexpr (requires { samples_.joins_solid(); })
      if (samples_.joins_solid()) bits ^= 255;
    return static_cast<std::size_t>(bits);
  }
  /// The vertex of the cell's patch that holds one of its edges.
  glm::vec3 vertex(const glm::ivec3& cell, int edge) const noexcept {
    const NetCase& net = case_of(cell);
    std::array<glm::vec3, 4> all;
    samples_.place(cell, net, all.data());
    return all[net.patch_of_edge[static_cast<std::size_t>(edge)]];
  }

  Samples samples_;
};

}  // namespace trephine::volume
