// Connected parts of a cut shape: which parts came off.
#pragma once

#include <cstdint>
#include <vector>

#include "volume/field.h"
#include "volume/occupancy.h"
#include "volume/traversal.h"
#include "volume/version.h"

namespace trephine::volume {

/// Samples of the cut lattice hang together with the 26 around them. Where a brick of cuts reaches into a
/// voxel its samples are asked, solid where the trilinear field is and nothing was removed; elsewhere all
/// samples of a voxel are what its centre is. On a lattice finer than the voxels that leaves half a voxel at
/// a surface undecided, so of what came off that way the voxels along surfaces are asked too, with two
/// around. Cost: a pass over the bits, or two, and what was cut.
class SolidParts {
 public:
  struct Part {
    std::int64_t samples = 0;
    VoxelBox box{glm::ivec3(0), glm::ivec3(-1)};  ///< of the voxels that hold any
    /// Removed matter ties it to a larger part (of two alike, one of a lower number): it came off that one.
    bool is_off = false;
  };

  /// `bits`: of the field's shape.
  SolidParts(const Field& field, const Occupancy& bits, const Version& version);

  /// By their first samples, z before y before x.
  const std::vector<Part>& parts() const noexcept { return parts_; }

  static constexpr int k_air = -1;
  /// To which part each of `count` lattice samples from (x, y, z) on belongs. Any thread.
  void row(int x, int y, int z, int count, int* parts) const noexcept;
  int part_of(const glm::ivec3& sample) const noexcept {
    int part = k_air;
    row(sample.x, sample.y, sample.z, 1, &part);
    return part;
  }

 private:
  /// Solid samples (or voxels) side by side along x.
  struct Run {
    int low, high;
    int part;  ///< while parts are found: its own number
    bool is_removed = false;
  };
  struct Runs {
    const Run *begin, *end;
  };
  void find_fine_voxels();
  bool ask_along_surfaces(const Occupancy& bits);
  void find_parts(const Field& field, const Occupancy& bits);
  void add_coarse_runs(const Occupancy& bits, int y, int z);
  void add_fine_runs(const Field& field, int y, int z);
  /// Parts of a row of voxels whose samples are not asked.
  Runs coarse(int y, int z) const noexcept;
  /// Parts of a row of the lattice, where samples are asked.
  Runs fine(int y, int z) const noexcept;
  template <class Join>
  void for_neighbours(Join&& join) const;
  void number_parts(std::vector<int>& of_run, std::vector<int>& of_whole);
  std::size_t row_index(int y, int z) const noexcept {
    return static_cast<std::size_t>(y) + static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(z);
  }
  bool is_in_grid(int y, int z) const noexcept { return y >= 0 && z >= 0 && y < size_.y && z < size_.z; }

  const Version* version_;  ///< while parts are found
  CutLattice lattice_;
  glm::ivec3 size_;
  std::size_t words_;                         ///< a row of voxels, 64 a word
  std::vector<std::uint64_t> is_fine_;        ///< a bit a voxel
  std::vector<Run> coarse_runs_, fine_runs_;  ///< those by rising rows
  std::vector<std::size_t> coarse_first_;     ///< of each row of voxels, and the end
  std::vector<int> block_;                    ///< of each row of voxels; -1: none of its samples is asked
  std::vector<std::size_t> fine_first_;       ///< of each lattice row of each block, and the end
  std::vector<Part> parts_;
};

}  // namespace trephine::volume
