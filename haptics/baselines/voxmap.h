// VoxMap: static objects as voxels in a tree of 8 x 8 x 8 children (McNeely, Puterbaugh and Troy 1999).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "haptics/mesh/mesh_tree.h"
#include "volume/scan/frame.h"
#include "volume/scan/occupancy.h"

namespace trephine::haptics::baselines {

/// Immutable. A node whose children all have one type is stored as that type ("aggregation").
class VoxMap {
 public:
  enum class Voxel : std::uint8_t {
    undefined,  ///< outside of the map
    free,
    surface,    ///< of an object
    interior,   ///< of an object
    proximity,  ///< free, within some layers of a surface
  };
  /// Method that finds the interior of a mesh.
  enum class Interior : std::uint8_t {
    walls,   ///< published method: six walls move inward through free space until a surface stops them, in
             ///< several passes
    parity,  ///< counts crossings along rows of voxels: exact for closed meshes
  };
  /// Largest number of passes of the walls.
  static constexpr int k_passes = 8;

  /// Solid voxels next to free ones are its surface. `layers`: of proximity voxels around surfaces. Cost:
  /// some passes over all voxels.
  static VoxMap of(const volume::Occupancy& solid, const volume::Frame& frame, int layers = 1);
  /// The surface consists of the voxels (edge: `voxel_mm`) that a triangle intersects by the separating axis
  /// test (Akenine-Möller 2001).
  static VoxMap of(const MeshTree& mesh, double voxel_mm, Interior interior, int layers = 1);

  Voxel at(const glm::ivec3& v) const noexcept { return cell_at(v).type; }
  /// A cube of voxels of one type that the tree stores as one value.
  struct Cell {
    Voxel type = Voxel::undefined;
    glm::ivec3 low{0};  ///< its first voxel
    int edge = 1;       ///< voxels
  };
  /// Returns the cell that contains a voxel; of type undefined outside of the map.
  Cell cell_at(const glm::ivec3& v) const noexcept;
  /// Returns true if all voxels of the box are of type `free`, or outside the map; proximity voxels are not.
  bool is_free(const glm::ivec3& low, const glm::ivec3& high) const noexcept;
  const glm::ivec3& size() const noexcept { return size_; }
  const volume::Frame& frame() const noexcept { return frame_; }
  double voxel_mm() const noexcept { return frame_.spacing().x; }
  std::size_t node_count() const noexcept { return nodes_.size() / 512; }
  std::size_t bytes() const noexcept { return nodes_.size() * sizeof(std::uint32_t) + leaves_.size(); }

 private:
  VoxMap(volume::Frame frame, const glm::ivec3& size) : frame_(frame), size_(size) {}
  /// Adds proximity voxels, and stores all in the tree.
  void build(std::vector<Voxel> voxels, int layers);

  bool is_free_in(std::uint32_t node, int level, const glm::ivec3& corner, const glm::ivec3& low,
                  const glm::ivec3& high) const noexcept;

  static constexpr std::uint32_t k_value = 0x80000000u;  // an aggregate: the low bits are its type

  volume::Frame frame_;
  glm::ivec3 size_{0};
  int levels_ = 1;  ///< number of levels of the tree, including the leaves
  std::uint32_t root_ = k_value;
  std::vector<std::uint32_t> nodes_;  ///< 512 children each: aggregates, or indices of nodes or leaves
  std::vector<std::uint8_t> leaves_;  ///< 512 voxels each
};

}  // namespace trephine::haptics::baselines
