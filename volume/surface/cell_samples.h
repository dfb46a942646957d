// VoxelSamples and OffsetSamples: samples around one cell for surface nets and marching cubes, from the
// voxels of a shape or from the lattice of an offset field.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "volume/fields/offset_field.h"
#include "volume/surface/surface_net_vertices.h"

namespace trephine::volume {

/// Voxels of a shape with its cuts. Borrows field, version and bits; the source must have bits. Any thread;
/// allocates nothing.
class VoxelSamples {
 public:
  explicit VoxelSamples(const SurfaceSource& source) : source_(source), vertices_(source) {}

  /// Returns true if voxel v is solid; false outside the grid.
  bool is_solid(const glm::ivec3& v) const noexcept {
    return source_.field->volume().contains(v) && source_.bits->is_solid(v) &&
           (source_.version == nullptr || source_.version->is_kept(v));
  }
  /// Computes the vertices of a cell, one per patch of its case.
  void place(const glm::ivec3& cell, const NetCase& net, glm::vec3* out) const {
    vertices_.place(cell, net, out);
  }
  /// Position of the surface on the edge from solid voxel `solid` (0) to its free neighbour `air` (1): the
  /// first zero of the field or of the cut.
  float crossing(const glm::ivec3& solid, const glm::ivec3& air) const noexcept {
    const auto value = [this](const glm::ivec3& v) {
      return static_cast<float>(source_.field->at(v.x, v.y, v.z));
    };
    const float inside = value(solid), outside = value(air);
    float t = outside < 0 ? inside / (inside - outside) : 1;
    if (source_.version == nullptr || source_.version->is_uncut()) return t;
    return std::min(t, cut_crossing(*source_.version, solid, air));
  }

 private:
  SurfaceSource source_;
  NetVertices vertices_;
};

/// Bits of the solid corners of a cell, bit i at (i & 1, i >> 1 & 1, i >> 2 & 1).
template <class Samples>
int config_of(const Samples& samples, const glm::ivec3& cell) noexcept {
  int bits = 0;
  for (int i = 0; i < 8; ++i)
    bits |= static_cast<int>(samples.is_solid(cell + glm::ivec3(i & 1, i >> 1 & 1, i >> 2 & 1))) << i;
  return bits;
}

/// Computes the vertices of a cell, one per patch of its case: the mean of the crossings of its edges.
template <class Samples>
void place_between_crossings(const Samples& samples, const glm::ivec3& cell, const NetCase& net,
                             glm::vec3* out) noexcept {
  std::array<glm::vec3, 4> sum{};
  std::array<int, 4> count{};
  const int bits = config_of(samples, cell);
  for (int e = 0; e < 12; ++e) {
    if (!(net.edges >> e & 1)) continue;
    const int axis = e / 4, corner = net_edge_corner(e);
    const glm::ivec3 offset(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    glm::ivec3 low = cell + offset, high = low;
    ++high[axis];
    glm::vec3 p(offset);
    p[axis] = bits >> corner & 1 ? samples.crossing(low, high) : 1 - samples.crossing(high, low);
    const std::size_t patch = net.patch_of_edge[static_cast<std::size_t>(e)];
    sum[patch] += p;
    ++count[patch];
  }
  for (std::size_t k = 0; k < net.patch_count; ++k)
    out[k] = glm::vec3(cell) + sum[k] / static_cast<float>(count[k]);
}

/// Lattice of an offset field. Borrows the field. Any thread; allocates nothing.
class OffsetSamples {
 public:
  explicit OffsetSamples(const OffsetField& field) : field_(field) {}

  bool is_solid(const glm::ivec3& v) const noexcept { return field_.at(v.x, v.y, v.z) >= 0; }
  void place(const glm::ivec3& cell, const NetCase& net, glm::vec3* out) const noexcept {
    place_between_crossings(*this, cell, net, out);
  }
  float crossing(const glm::ivec3& solid, const glm::ivec3& air) const noexcept {
    const auto inside = static_cast<float>(field_.at(solid.x, solid.y, solid.z)),
               outside = static_cast<float>(field_.at(air.x, air.y, air.z));
    return inside / (inside - outside);
  }

 private:
  const OffsetField& field_;
};

}  // namespace trephine::volume
