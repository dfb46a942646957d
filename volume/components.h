// Connected components of a shape, all at once.
#pragma once

#include <cstdint>
#include <vector>

#include "volume/occupancy.h"

namespace trephine::volume {

/// Joins runs of solid voxels along x where they touch runs of the neighbouring rows. The same numbers
/// for any count of threads. Cost: a pass over the bits, and what there is of runs.
class Components {
 public:
  /// Connectivity: voxels that share a face (6), or a corner at least (26).
  enum class Touch : std::uint8_t { faces, corners };
  Components(const Occupancy& bits, Touch touch, int threads = 0);
  /// Starts from the voxels; bits that are not needed otherwise are not kept.
  Components(const Volume& volume, const Shape& shape, Touch touch, int threads = 0);

  /// Voxels of each part; numbered by their first voxels, z before y before x.
  const std::vector<std::int64_t>& sizes() const noexcept { return sizes_; }
  std::size_t count() const noexcept { return sizes_.size(); }
  static constexpr int k_air = -1;
  /// To which part a voxel belongs. Inside the grid.
  int part_of(const glm::ivec3& v) const noexcept;
  /// Component of a voxel, as bits laid out like those of Occupancy: rows of words. Air gives
  /// none.
  std::vector<std::uint64_t> flood(const glm::ivec3& seed) const;

 private:
  struct Run {
    std::int32_t low, high;
  };
  std::size_t row_of(int y, int z) const noexcept {
    return static_cast<std::size_t>(y) + static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(z);
  }
  /// row_bits(y, z, scratch): the words of a row, in `scratch` or elsewhere.
  template <class RowBits>
  void find_runs(int threads, const RowBits& row_bits);
  void add_runs(const std::uint64_t* words, std::vector<Run>& runs) const;
  void join_runs(Touch touch, int threads);
  /// The runs of a row with those of another one.
  void join_rows(std::size_t row, std::size_t other, int reach) noexcept;
  int root_of(int run) noexcept;
  void number_parts();

  glm::ivec3 size_;
  std::size_t words_;
  std::vector<Run> runs_;             ///< by rising rows
  std::vector<std::uint32_t> first_;  ///< of each row, and the end
  std::vector<int> part_;             ///< of each run; while they are joined: an earlier run of the same part
  std::vector<std::int64_t> sizes_;
};

}  // namespace trephine::volume
