// One bit a voxel: is its centre solid for a shape of the base volume? Made only for shapes that someone
// needs.
#pragma once

#include <bit>
#include <cstdint>

#include "volume/buffer.h"
#include "volume/shape.h"

namespace trephine::volume {

/// Rows of 64 voxels along x, one word each, and one byte a block of 4 x 4 x 4 voxels: the chessboard
/// distance (in blocks) to the nearest block with a solid voxel, 0 for such a block. Removal keeps both
/// valid.
class Occupancy {
 public:
  Occupancy() = default;
  /// Cost: one pass over the volume, limited by memory. threads 0 = all cores.
  static Occupancy build(const Volume& volume, const Shape& shape, int threads = 0);

  /// v must lie inside the grid.
  bool is_solid(const glm::ivec3& v) const noexcept {
    return words_[word_index(v.y, v.z) + static_cast<std::size_t>(v.x >> 6)] >> (v.x & 63) & 1u;
  }
  /// The words of row (y, z), `words_per_row()` of them; bits beyond the row are 0.
  const std::uint64_t* row(int y, int z) const noexcept { return words_.data() + word_index(y, z); }
  int words_per_row() const noexcept { return words_per_row_; }
  /// Chessboard distance in blocks for the block of voxel v; 0 = this block holds something solid.
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

/// The bits of one row of a volume, 64 at a time, written to `words` (ceil(size.x / 64) of them).
void threshold_row(const Volume& volume, const Shape& shape, int y, int z, std::uint64_t* words);

}  // namespace trephine::volume
