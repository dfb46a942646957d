// RemovedMatter: attenuation of the matter removed from a scan, to subtract from an X-ray of the whole scan.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "volume/cuts/version.h"
#include "volume/imaging/line_integrals.h"

namespace trephine::fluoroscopy {

/// Returns true if a scan shows a body, with soft tissue around the bone, and not a dry specimen. Matter
/// removed from a body is replaced by fluid and soft tissue; from a specimen, by air.
bool has_soft_tissue(const volume::Volume& scan);

/// Blocks of 8 x 8 x 8 voxels with removed matter: the decrease of each voxel's attenuation, 1/mm, times its
/// removed share. In a body, removed bone counts as water, and removed soft tissue as unchanged.
class RemovedMatter {
 public:
  static constexpr int k_edge = 8;
  struct Block {
    std::array<float, k_edge * k_edge * k_edge> weights{};  ///< x fastest; 0 beyond the grid
  };

  /// Updates to a version of the volume of `lines`, frozen or not: only the blocks with bricks that differ
  /// from those of the previous version. Returns the blocks (voxel >> 3) that changed.
  std::vector<glm::ivec3> update(const volume::LineIntegrals& lines,
                                 std::shared_ptr<const volume::Version> version, int threads);
  /// Sorted by position.
  using Blocks = std::map<std::array<int, 3>, Block>;  // z, y, x
  const Blocks& blocks() const noexcept { return blocks_; }
  static volume::VoxelBox box_of(const std::array<int, 3>& position) noexcept;
  /// Returns the sum of weights along a ray (volume frame) within one block, between two of its parameters.
  static double sum(const volume::Ray& ray, double from, double to, const std::array<int, 3>& position,
                    const Block& block) noexcept;
  /// Returns the sum along the whole ray, interpolated between the voxels of each slab across `axis`, as with
  /// volume::RaySum::joseph.
  static double interpolated_sum(const volume::Ray& ray, int axis, const std::array<int, 3>& position,
                                 const Block& block) noexcept;

 private:
  std::shared_ptr<const volume::Version> version_;
  double fill_attenuation_ = -1;  ///< attenuation of the fluid that replaces matter, 1/mm; -1: not known yet
  Blocks blocks_;
};

}  // namespace trephine::fluoroscopy
