// FineNet: part of a surface net near cuts on a lattice finer than the voxels, joined without gaps to the net
// of the surrounding voxels.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "volume/scan/traversal.h"
#include "volume/surface/surface_net_cases.h"
#include "volume/surface/surface_nets.h"

namespace trephine::volume {

/// A cell between eight voxel centres is fine if a brick that is not hollow overlaps it. The surface in a
/// fine cell is that of its lattice cells; other cells are coarse. Polygons are dual to minimal edges, the
/// shortest of overlapping edges (Ju et al. 2002, section 4), with cells of either size around them. A coarse
/// cell next to fine ones has no cut, so its surface is that of the trilinear field: the surface crosses each
/// coarse edge at most once, and the corners of each face determine the curves on the face. Samples inside an
/// ambiguous face are modified to separate the solid corners, as the coarse cell does, so that both sides
/// agree. The joined net is closed and manifold, like the net of the voxels.
///
/// Borrows the source; the lattice of its version must be finer than its voxels. Any thread may query; only
/// one thread may call make().
class FineNet {
 public:
  /// Vertices of a coarse cell: index of the first patch's vertex, and the cell's case.
  struct CoarseVertex {
    std::uint32_t first;
    const NetCase* net;
  };
  /// Vertices of coarse cells next to fine ones, by key().
  using CoarseVertices = std::unordered_map<std::uint64_t, CoarseVertex>;

  /// Prepares the net of the edges whose lowest voxel is in `owned`, and of the cells around them.
  FineNet(const SurfaceSource& source, const VoxelBox& owned);

  bool is_empty() const noexcept { return blocks_.empty(); }
  bool is_fine(const glm::ivec3& cell) const noexcept { return blocks_.contains(key(cell)); }
  /// Calls each(cell) for the fine cells, in unspecified order.
  template <class Each>
  void for_fine_cells(Each&& each) const {
    for (const Block& block : storage_) each(block.cell);
  }
  /// Returns true for coarse cells next to fine ones, whose vertices make() needs.
  bool is_external(const glm::ivec3& cell) const noexcept { return adjacent_.contains(key(cell)); }
  static std::uint64_t key(const glm::ivec3& cell) noexcept {
    const auto part = [](int i) { return static_cast<std::uint64_t>(i + 1) & 0x1fffffu; };
    return part(cell.x) | part(cell.y) << 21 | part(cell.z) << 42;
  }

  /// Case of a coarse cell that shares its pinching face with a fine cell. The case is flipped if a lattice
  /// cell at that face is flipped.
  const NetCase& coarse_case(const glm::ivec3& cell, int config) const;

  /// Appends the fine vertices (volume frame), numbered from `first_id` on, and the polygons around all
  /// minimal edges of the lattice, as triangles.
  void make(const CoarseVertices& coarse, std::uint32_t first_id, std::vector<glm::vec3>& vertices,
            std::vector<std::uint32_t>& triangles);

 private:
  /// Fine cell with its lattice samples and the vertices of its lattice cells.
  struct Block {
    glm::ivec3 cell;
    std::array<double, 8> corners{};   ///< values of the field
    std::vector<std::uint8_t> solid;   ///< (k + 1)^3 samples, x fastest; empty if not needed
    std::vector<std::uint32_t> first;  ///< first vertex of each of k^3 lattice cells; empty if not needed
  };
  struct Edge {
    glm::ivec3 low;  ///< lattice sample
    int axis;
  };

  void find_fine_cells(const VoxelBox& reach);
  void fill(Block& block) const;
  void separate_ambiguous_faces(Block& block) const;
  std::array<double, 8> field_corners(const glm::ivec3& cell) const;
  void place_vertices(Block& block, std::uint32_t first_id, std::vector<glm::vec3>& vertices) const;
  const NetCase& case_of(const glm::ivec3& lattice_cell, int config) const;
  bool find_flipped(const glm::ivec3& cell, int face, glm::ivec3& lattice_cell) const;
  int config_of(const glm::ivec3& lattice_cell) const;
  const Block* block_of(const glm::ivec3& lattice_cell) const;
  bool is_solid(const glm::ivec3& sample) const;
  bool exists(const glm::ivec3& cell) const noexcept;
  void add_polygon(const Edge& edge, const CoarseVertices& coarse,
                   std::vector<std::uint32_t>& triangles) const;
  std::uint32_t coarse_vertex(const glm::ivec3& cell, const Edge& edge, const CoarseVertices& coarse) const;
  glm::ivec3 cell_of(const glm::ivec3& lattice_cell) const noexcept;
  /// Index of a sample at an offset from the lowest one of its fine cell.
  std::size_t sample_index(const glm::ivec3& offset) const noexcept {
    return static_cast<std::size_t>(offset.x + (k_.x + 1) * (offset.y + (k_.y + 1) * offset.z));
  }
  /// Index of a lattice cell at an offset from the lowest one of its fine cell.
  std::size_t lattice_index(const glm::ivec3& offset) const noexcept {
    return static_cast<std::size_t>(offset.x + k_.x * (offset.y + k_.y * offset.z));
  }

  SurfaceSource source_;
  const Volume& volume_;
  const Version& version_;
  const CutLattice& lattice_;
  VoxelBox owned_;
  glm::ivec3 k_, origin_;  ///< samples per voxel, and the sample at the centre of voxel 0
  std::vector<Block> storage_;
  std::unordered_map<std::uint64_t, std::size_t> blocks_;  ///< index in storage_ by key of the cell
  std::unordered_set<std::uint64_t> adjacent_;             ///< keys of coarse cells next to fine ones
};

}  // namespace trephine::volume
