// VoxelImages: six depth images of the remaining voxels of a shape, updated only in changed regions.
#pragma once

#include <array>
#include <vector>

#include "volume/scan/traversal.h"
#include "volume/surface/cell_samples.h"

namespace trephine::bench {

/// Orthographic cameras on the six faces of a volume, one pixel per row of voxels. The first solid voxels are
/// found by bit scans, 64 voxels at a time. Updates run on one thread; between updates, any thread may query.
class VoxelImages {
 public:
  /// Makes all six images.
  explicit VoxelImages(const volume::SurfaceSource& source);
  /// Updates to another state of the same shape, if the two states differ only in the box `changed`. Scans
  /// the rows through the box, from the first voxel that may have changed.
  void update(const volume::SurfaceSource& source, const volume::VoxelBox& changed);

  const glm::ivec3& size() const noexcept { return size_; }
  /// Returns the first solid voxel of the row along `axis` at (i, j) of the other two axes in order, from the
  /// low or the high side; -1: no such voxel.
  int first(int axis, bool from_high, int i, int j) const noexcept {
    return image(axis, from_high)[pixel(axis, i, j)].voxel;
  }
  /// Returns the position of the surface in front of the voxel first(), as a coordinate along `axis` in
  /// voxels.
  float surface(int axis, bool from_high, int i, int j) const noexcept {
    return image(axis, from_high)[pixel(axis, i, j)].at;
  }
  /// Returns the number of voxels that the last update read one by one.
  std::size_t query_count() const noexcept { return query_count_; }

 private:
  struct Pixel {
    int voxel = -1;
    float at = 0;
  };
  using Image = std::vector<Pixel>;
  const Image& image(int axis, bool from_high) const noexcept {
    return images_[static_cast<std::size_t>(2 * axis + from_high)];
  }
  std::size_t pixel(int axis, int i, int j) const noexcept {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(axis == 0 ? size_.y : size_.x) * static_cast<std::size_t>(j);
  }
  void scan_rows(const volume::SurfaceSource& source, bool from_high);
  void scan_across(const volume::SurfaceSource& source, int axis, bool from_high);
  void set_pixel(const volume::VoxelSamples& samples, int axis, bool from_high, const glm::ivec3& first,
                 Pixel& to);

  glm::ivec3 size_;
  std::array<Image, 6> images_;
  std::size_t query_count_ = 0;
};

}  // namespace trephine::bench
