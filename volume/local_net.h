// The surface net around single cells, made when it is asked for: the triangles of the whole surface, bit for
// bit.
#pragma once

#include <array>

#include "volume/surface_net_vertices.h"
#include "volume/traversal.h"

namespace trephine::volume {

/// Two triangles (0, 1, 2) and (0, 2, 3) around one crossed grid edge; volume frame, seen from the free side
/// counter-clockwise (in a right-handed frame).
struct NetQuad {
  std::array<glm::vec3, 4> corners;
};

/// Any thread; allocates nothing. Borrows field, version and bits, which must be there.
class LocalNet {
 public:
  explicit LocalNet(const SurfaceSource& source) : source_(source), vertices_(source) {}

  /// Is voxel v solid? Outside the grid nothing is.
  bool is_solid(const glm::ivec3& v) const noexcept {
    return source_.field->volume().contains(v) && source_.bits->is_solid(v) &&
           (source_.version == nullptr || source_.version->is_kept(v));
  }
  /// Corners of a cell that are solid, bit i at (i & 1, i >> 1 & 1, i >> 2 & 1).
  int config(const glm::ivec3& cell) const noexcept {
    int bits = 0;
    for (int i = 0; i < 8; ++i)
      bits |= static_cast<int>(is_solid(cell + glm::ivec3(i & 1, i >> 1 & 1, i >> 2 & 1))) << i;
    return bits;
  }
  /// The quad around the crossed edge from voxel `low` one step along `axis`.
  NetQuad quad(const glm::ivec3& low, int axis) const noexcept;

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

 private:
  glm::vec3 vertex(const glm::ivec3& cell, int edge) const noexcept;
  SurfaceSource source_;
  NetVertices vertices_;
};

}  // namespace trephine::volume
