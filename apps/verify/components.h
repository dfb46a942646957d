// Components: connected components of a shape.
#pragma once

#include <cstdint>
#include <vector>

#include "volume/scan/occupancy.h"

namespace trephine::verify {

/// Joins runs of solid voxels along x that touch runs of the neighbouring rows. The numbers of the parts do
/// not depend on the number of threads. Cost: a pass over the bits, and time proportional to the number of
/// runs.
class Components {
 public:
  /// Connectivity: voxels that share a face (6), or at least a corner (26).
  enum class Connectivity : std::uint8_t { faces, corners };
  Components(const volume::Occupancy& bits, Connectivity touch, int threads = 0);
  /// Computes the bits from the voxels row by row, without keeping them.
  Components(const volume::Volume& scan, const volume::Shape& shape, Connectivity touch, int threads = 0);

  /// Returns the number of voxels of each part; parts are numbered by first voxel, z before y before x.
  const std::vector<std::int64_t>& sizes() const noexcept { return sizes_; }
  std::size_t count() const noexcept { return sizes_.size(); }
  static constexpr int k_air = -1;
  /// Returns the part of a voxel inside the grid, or k_air.
  int part_of(const glm::ivec3& v) const noexcept;
  /// Returns the component of a voxel as bits in the layout of Occupancy: rows of words. Empty for air.
  std::vector<std::uint64_t> flood(const glm::ivec3& seed) const;

 private:
  struct Run {
    std::int32_t low, high;
  };
  std::size_t row_of(int y, int z) const noexcept {
    return static_cast<std::size_t>(y) + static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(z);
  }
  /// row_bits(y, z, scratch) returns the words of a row, in `scratch` or elsewhere.
  template <class RowBits>
  void find_runs(int threads, const RowBits& row_bits);
  void add_runs(const std::uint64_t* words, std::vector<Run>& runs) const;
  void join_runs(Connectivity touch, int threads);
  /// Joins the runs of a row with those of another row.
  void join_rows(std::size_t row, std::size_t other, int reach) noexcept;
  int root_of(int run) noexcept;
  void number_parts();

  glm::ivec3 size_;
  std::size_t words_;
  std::vector<Run> runs_;             ///< in the order of rows
  std::vector<std::uint32_t> first_;  ///< first run of each row, and the end
  std::vector<int> part_;             ///< part of each run; during joins: an earlier run of its part
  std::vector<std::int64_t> sizes_;   ///< voxels of each part
};

}  // namespace trephine::verify
