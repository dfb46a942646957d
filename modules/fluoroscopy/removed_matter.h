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

/// Returns true if a scan in Hounsfield units has more voxels of soft tissue than of bone: it shows a patient
/// and not a dry specimen. Matter removed from a patient is replaced by fluid and soft tissue; matter removed
/// from a specimen, by air.
bool has_soft_tissue(const volume::Volume& scan);

/// Blocks of 8 x 8 x 8 voxels with removed matter: the decrease of each voxel's attenuation, 1/mm, times its
/// removed share. In a scan with soft tissue, removed matter counts as water, and matter that attenuates less
/// than water counts as not removed.
class RemovedMatter {
 public:
  static constexpr int k_edge = 8;
  struct Block {
    std::array<float, k_edge * k_edge * k_edge> weights{};  ///< x fastest; 0 beyond the grid
  };

  /// Updates the blocks to a version, frozen or not, of the volume of `lines`. Computes only the blocks with
  /// bricks that differ from those of the previous version. Returns the blocks (voxel >> 3) that changed.
  std::vector<glm::ivec3> update(const volume::LineIntegrals& lines,
                                 std::shared_ptr<const volume::Version> version, int threads);
  /// Sorted by position.
  using Blocks = std::map<std::array<int, 3>, Block>;  // z, y, x
  const Blocks& blocks() const noexcept { return blocks_; }
  static volume::VoxelBox box_of(const std::array<int, 3>& position) noexcept;
  /// Returns the integral of the weights of one block over the parameter of a ray (volume frame), between the
  /// parameters `from` and `to`.
  static double sum(const volume::Ray& ray, double from, double to, const std::array<int, 3>& position,
                    const Block& block) noexcept;
  /// Returns this integral over the whole ray, with weights interpolated between the voxels of each slab
  /// across `axis`, as with volume::RaySum::joseph.
  static double interpolated_sum(const volume::Ray& ray, int axis, const std::array<int, 3>& position,
                                 const Block& block) noexcept;

 private:
  std::shared_ptr<const volume::Version> version_;
  double fill_attenuation_ = -1;  ///< attenuation of the fluid that replaces matter, 1/mm; -1: not known yet
  Blocks blocks_;
};

}  // namespace trephine::fluoroscopy
