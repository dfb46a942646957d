// LocalNet: surface net of single cells, computed on demand. Its triangles are bit-identical to those of
// the surface net of all cells.
#pragma once

#include <array>
#include <utility>

#include "volume/surface/cell_samples.h"

namespace trephine::volume {

/// Two triangles (0, 1, 2) and (0, 2, 3) around one crossed grid edge, in voxel units, counter-clockwise
/// viewed from the free side (in a right-handed frame).
struct NetQuad {
  std::array<glm::vec3, 4> corners;

  /// Calls use(a, b, c) for both triangles.
  template <class Use>
  void triangles(Use&& use) const {
    use(corners[0], corners[1], corners[2]);
    use(corners[0], corners[2], corners[3]);
  }
};

/// Any thread; allocates nothing. `Samples`: see volume/surface/cell_samples.h.
template <class Samples>
class LocalNet {
 public:
  explicit LocalNet(const Samples& samples) : samples_(samples) {}

  int config(const glm::ivec3& cell) const noexcept { return config_of(samples_, cell); }

  /// Returns the patches of a cell. They separate solid corners on ambiguous faces; but if the cells on both
  /// sides of such a face would each have one patch that meets it twice (a pinch), they separate air corners
  /// there.
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

  /// Returns the quad around the crossed edge from voxel `low` one step along `axis`.
  NetQuad quad(const glm::ivec3& low, int axis) const noexcept {
    // The four cells around the edge, counter-clockwise viewed from its high end.
    const int first = (axis + 1) % 3, second = (axis + 2) % 3;
    NetQuad quad;
    const int corners[4] = {1 << first | 1 << second, 1 << second, 0, 1 << first};
    for (std::size_t i = 0; i < 4; ++i) {
      const int corner = corners[i];
      const glm::ivec3 cell = low - glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
      quad.corners[i] = vertex(cell, net_edge(axis, corner));
    }
    // The quad faces the high end if the low end is solid; else its order is reversed.
    if (!samples_.is_solid(low)) std::swap(quad.corners[1], quad.corners[3]);
    return quad;
  }

  /// Calls use(quad) for all quads that may intersect `cell`: those around its crossed edges, at most twelve.
  /// A quad is inside the four cells around its edge.
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
  /// Configuration for the table, which separates solid corners on ambiguous faces. Some samples join these
  /// corners, so that oblique walls of one layer stay closed. For such samples solid and air are exchanged in
  /// the configuration: it has the same crossed edges, but its patches separate air.
  std::size_t table_bits(const glm::ivec3& cell) const noexcept {
    int bits = config(cell);
    if constexpr (requires { samples_.joins_solid(); })
      if (samples_.joins_solid()) bits ^= 255;
    return static_cast<std::size_t>(bits);
  }
  /// Vertex of the patch that contains an edge of the cell.
  glm::vec3 vertex(const glm::ivec3& cell, int edge) const noexcept {
    const NetCase& net = case_of(cell);
    std::array<glm::vec3, 4> vertices;
    samples_.place(cell, net, vertices.data());
    return vertices[net.patch_of_edge[static_cast<std::size_t>(edge)]];
  }

  Samples samples_;
};

}  // namespace trephine::volume
