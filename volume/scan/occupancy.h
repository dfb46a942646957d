// Occupancy: one bit per voxel, set if its centre is solid for a shape of the base volume. Built only for
// shapes that need it.
#pragma once

#include <bit>
#include <cstdint>

#include "volume/base/buffer.h"
#include "volume/scan/shape.h"

namespace trephine::volume {

/// Stores 64 voxels along x per word, and one byte per block of 4 x 4 x 4 voxels: the chessboard distance
/// (in blocks) to the nearest block with a solid voxel, 0 for such a block, at most 64. Removal of matter
/// requires no update: the bits are those of the base volume, and the distances remain lower bounds.
class Occupancy {
 public:
  Occupancy() = default;
  /// Cost: one pass over the volume, limited by memory bandwidth. threads 0 = all cores.
  static Occupancy build(const Volume& volume, const Shape& shape, int threads = 0);

  /// Requires v inside the grid.
  bool is_solid(const glm::ivec3& v) const noexcept {
    return words_[word_index(v.y, v.z) + static_cast<std::size_t>(v.x >> 6)] >> (v.x & 63) & 1u;
  }
  /// Returns the words_per_row() words of row (y, z); bits beyond the row are 0.
  const std::uint64_t* row(int y, int z) const noexcept { return words_.data() + word_index(y, z); }
  int words_per_row() const noexcept { return words_per_row_; }
  /// Chessboard distance in blocks for the block of voxel v; 0 = this block contains a solid voxel.
  int empty_distance(const glm::ivec3& v) const noexcept {
    return distance_[static_cast<std::size_t>(v.x >> 2) +
                     static_cast<std::size_t>(blocks_.x) *
                         (static_cast<std::size_t>(v.y >> 2) +
                          static_cast<std::size_t>(blocks_.y) * static_cast<std::size_t>(v.z >> 2))];
  }

  std::size_t count_solid() const noexcept;
  const glm::ivec3& size() const noexcept { return size_; }
  bool is_empty() const noexcept { return words_.is_empty(); }
  std::size_t bytes() const noexcept { return words_.bytes() + distance_.bytes(); }

 private:
  std::size_t word_index(int y, int z) const noexcept {
    return static_cast<std::size_t>(words_per_row_) *
           (static_cast<std::size_t>(y) + static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(z));
  }
  void build_distance(int threads);

  glm::ivec3 size_{0}, blocks_{0};
  int words_per_row_ = 0;
  Buffer<std::uint64_t> words_;
  Buffer<std::uint8_t> distance_;
};

/// Writes the bits of one row of a volume to `words` (ceil(size.x / 64) of them).
void threshold_row(const Volume& volume, const Shape& shape, int y, int z, std::uint64_t* words);

}  // namespace trephine::volume
