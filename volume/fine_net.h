// The part of a surface net that lies near cuts on a lattice finer than the voxels, joined to the net of the
// voxels around it without a gap.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "volume/surface_net_cases.h"
#include "volume/surface_nets.h"
#include "volume/traversal.h"

namespace trephine::volume {

/// A voxel's cell (between eight voxel centres) is fine where a brick of the cut lattice reaches it; its
/// surface is that of the lattice's own cells. Polygons are dual to minimal edges, the shortest of those that
/// lie on each other (Ju et al. 2002, section 4): around each stand cells of either size. A coarse cell next
/// to fine ones has no cut, so its surface is that of the field alone, trilinear: its lattice samples cross
/// each coarse edge once at most, and each face as its corners say. Where that face is ambiguous the samples
/// inside it are read as if solid corners were apart, as the coarse case has it, so that both sides agree.
/// Closed and manifold as the net of the voxels is.
///
/// Borrows the source, whose version must be finer than its voxels. Questions from any thread, make() on one.
class FineNet {
 public:
  /// Vertices of the coarse net: the first of a cell's patches, and its case. Asked for coarse
  /// cells next to fine ones.
  struct CoarseVertex {
    std::uint32_t first;
    const NetCase* net;
  };
  using CoarseVertices = std::unordered_map<std::uint64_t, CoarseVertex>;

  /// Makes the net of the edges whose lowest voxel is in `owned`, and the cells around them.
  FineNet(const SurfaceSource& source, const VoxelBox& owned);

  bool is_empty() const noexcept { return blocks_.empty(); }
  bool is_fine(const glm::ivec3& cell) const noexcept { return blocks_.contains(key(cell)); }
  /// Fine cells, in no order.
  template <class Each>
  void for_fine_cells(Each&& each) const {
    for (const Block& block : storage_) each(block.cell);
  }
  /// Coarse cells that a fine one touches: those whose vertices make() asks for.
  bool is_beside(const glm::ivec3& cell) const noexcept { return beside_.contains(key(cell)); }
  static std::uint64_t key(const glm::ivec3& cell) noexcept {
    const auto part = [](int i) { return static_cast<std::uint64_t>(i + 1) & 0x1fffffu; };
    return part(cell.x) | part(cell.y) << 21 | part(cell.z) << 42;
  }

  /// The case of a coarse cell whose ambiguous face meets one patch twice, and is shared with a fine cell:
  /// turned as that face's own lattice cell is.
  const NetCase& coarse_case(const glm::ivec3& cell, int config) const;

  /// Adds the fine vertices (volume frame), numbered from `first_id` on, and all polygons around minimal
  /// edges of the lattice.
  void make(const CoarseVertices& coarse, std::uint32_t first_id, std::vector<glm::vec3>& vertices,
            std::vector<std::uint32_t>& triangles);

 private:
  /// One fine cell: its lattice samples, and the vertices of its lattice cells.
  struct Block {
    glm::ivec3 cell;
    std::array<double, 8> corners{};   ///< of the field
    std::vector<std::uint8_t> solid;   ///< (k + 1)^3 samples, x fastest
    std::vector<std::uint32_t> first;  ///< k^3 lattice cells: first vertex; only of cells in reach
  };
  struct Edge {
    glm::ivec3 low;  ///< lattice sample
    int axis;
  };

  void find_fine_cells(const VoxelBox& reach);
  void fill(Block& block) const;
  void keep_ambiguous_faces_apart(Block& block) const;
  std::array<double, 8> field_corners(const glm::ivec3& cell) const;
  void place(Block& block, std::uint32_t first_id, std::vector<glm::vec3>& vertices) const;
  const NetCase& case_of(const glm::ivec3& lattice_cell, int config) const;
  bool find_turned(const glm::ivec3& cell, int face, glm::ivec3& lattice_cell) const;
  int config_of(const glm::ivec3& lattice_cell) const;
  const Block* block_of(const glm::ivec3& lattice_cell) const;
  bool is_solid(const glm::ivec3& sample) const;
  bool exists(const glm::ivec3& cell) const noexcept;
  void add_polygon(const Edge& edge, const CoarseVertices& coarse,
                   std::vector<std::uint32_t>& triangles) const;
  std::uint32_t coarse_vertex(const glm::ivec3& cell, const Edge& edge, const CoarseVertices& coarse) const;
  glm::ivec3 cell_of(const glm::ivec3& lattice_cell) const noexcept;
  std::size_t sample_index(const glm::ivec3& in) const noexcept {
    return static_cast<std::size_t>(in.x + (k_.x + 1) * (in.y + (k_.y + 1) * in.z));
  }
  std::size_t lattice_index(const glm::ivec3& in) const noexcept {
    return static_cast<std::size_t>(in.x + k_.x * (in.y + k_.y * in.z));
  }

  SurfaceSource source_;
  const Volume& volume_;
  const Version& version_;
  const CutLattice& lattice_;
  VoxelBox owned_;
  glm::ivec3 k_, origin_;  ///< samples a voxel, and the sample on voxel 0
  std::vector<Block> storage_;
  std::unordered_map<std::uint64_t, std::size_t> blocks_;  ///< by cell
  std::unordered_set<std::uint64_t> beside_;               ///< coarse cells
};

}  // namespace trephine::volume
