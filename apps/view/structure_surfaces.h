// StructureSurfaces: whole surfaces of labelled structures, for pictures with translucent bone.
#pragma once

#include <future>
#include <map>
#include <memory>
#include <vector>

#include "apps/view/chunk_meshes.h"

namespace trephine::view {

/// Returns the box of the voxels of each label, by label value; low > high for labels without voxels.
std::vector<volume::VoxelBox> label_boxes(const volume::Volume& scan);

/// Returns a smooth, closed surface around the voxels in `box` that have a label and that a version keeps.
/// The surface has about k_structure_triangles triangles at most; it is empty if there are no such voxels. In
/// a box of more than 2.4e7 voxels, parts that are one voxel thick may vanish.
DrawMesh structure_surface(const volume::Volume& scan, const volume::Version& version, int label,
                           const volume::VoxelBox& box);
inline constexpr std::size_t k_structure_triangles = 150000;

/// Meshes structures on another thread, one after the other. No cost before the first request. Borrows the
/// scan. Call on the drawing thread only.
class StructureSurfaces {
 public:
  explicit StructureSurfaces(const volume::Volume& scan) : scan_(&scan) {}
  ~StructureSurfaces();
  StructureSurfaces(const StructureSurfaces&) = delete;
  StructureSurfaces& operator=(const StructureSurfaces&) = delete;

  struct Surface {
    int label = 0;
    DrawMesh mesh;
  };
  /// Requests the surface of a label in a version. Replaces a waiting request of the same label, but not one
  /// that is being computed.
  void request(int label, std::shared_ptr<const volume::Version> version);
  /// Returns true if a box contains a voxel of a label in the scan, removed or not.
  bool has_voxels(int label, const volume::VoxelBox& box);
  /// Returns the surfaces finished since the last call.
  std::vector<Surface> take();
  /// Waits until all requests are finished.
  void finish();
  bool is_complete() const { return !job_.valid() && waiting_.empty() && done_.empty(); }

 private:
  const volume::VoxelBox& box_of(int label);
  void start();
  void collect();

  const volume::Volume* scan_;
  std::vector<volume::VoxelBox> boxes_;  ///< by label value; empty before their first use
  std::map<int, std::shared_ptr<const volume::Version>> waiting_;
  std::future<Surface> job_;
  std::vector<Surface> done_;
};

}  // namespace trephine::view
