// What was taken from a scan, as what an X-ray of the whole scan has too much of.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "volume/line_integrals.h"
#include "volume/version.h"

namespace trephine::fluoroscopy {

/// Blocks of 8 x 8 x 8 voxels of which something was removed: what each voxel counts, times its removed
/// share.
class RemovedMatter {
 public:
  static constexpr int k_edge = 8;
  struct Block {
    std::array<float, k_edge * k_edge * k_edge> weights{};  ///< x fastest; 0 beyond the grid
  };

  /// Goes on to a version of the volume of `lines`, frozen or not: only blocks in which bricks differ from
  /// those of the one before are made anew. The blocks (voxel >> 3) that changed.
  std::vector<glm::ivec3> update(const volume::LineIntegrals& lines,
                                 std::shared_ptr<const volume::Version> version, int threads);
  /// By rising place.
  using Blocks = std::map<std::array<int, 3>, Block>;  // z, y, x
  const Blocks& blocks() const noexcept { return blocks_; }
  static volume::VoxelBox box_of(const std::array<int, 3>& place) noexcept;
  /// What a ray (volume frame) passes of one block between two of its parameters.
  static double sum(const volume::Ray& ray, double from, double to, const std::array<int, 3>& place,
                    const Block& block) noexcept;

 private:
  std::shared_ptr<const volume::Version> version_;
  Blocks blocks_;
};

}  // namespace trephine::fluoroscopy
