// Matter removed from a scan, as the excess of an X-ray of the whole scan.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "volume/line_integrals.h"
#include "volume/version.h"

namespace trephine::fluoroscopy {

/// Does a scan show a body, with soft tissue around the bone, and not a dry specimen? What is removed from a
/// body is replaced by fluid and soft tissue; from a specimen, by air.
bool is_of_body(const volume::Volume& scan);

/// Blocks of 8 x 8 x 8 voxels of which something was removed: how much less each voxel counts now, times its
/// removed share. In a body, bone that was removed counts as water, and soft tissue stays as it is.
class RemovedMatter {
 public:
  static constexpr int k_edge = 8;
  struct Block {
    std::array<float, k_edge * k_edge * k_edge> weights{};  ///< x fastest; 0 beyond the grid
  };

  /// Goes on to a version of the volume of `lines`, frozen or not: only blocks in which bricks differ from
  /// those of the previous one are updated. The blocks (voxel >> 3) that changed.
  std::vector<glm::ivec3> update(const volume::LineIntegrals& lines,
                                 std::shared_ptr<const volume::Version> version, int threads);
  /// By rising place.
  using Blocks = std::map<std::array<int, 3>, Block>;  // z, y, x
  const Blocks& blocks() const noexcept { return blocks_; }
  static volume::VoxelBox box_of(const std::array<int, 3>& place) noexcept;
  /// Length of a ray (volume frame) within one block between two of its parameters.
  static double sum(const volume::Ray& ray, double from, double to, const std::array<int, 3>& place,
                    const Block& block) noexcept;
  /// The sum along the whole ray, interpolated between the voxels of each slab across `axis`, as
  /// volume::RaySum::joseph has it.
  static double interpolated_sum(const volume::Ray& ray, int axis, const std::array<int, 3>& place,
                                 const Block& block) noexcept;

 private:
  std::shared_ptr<const volume::Version> version_;
  double filled_with_ = -1;  ///< what a mm counts that takes the place of what was removed; -1: not known yet
  Blocks blocks_;
};

}  // namespace trephine::fluoroscopy
