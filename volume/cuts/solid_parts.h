// SolidParts: connected parts of a cut shape, including those that cuts detached.
#pragma once

#include <cstdint>
#include <vector>

#include "volume/cuts/version.h"
#include "volume/scan/field.h"
#include "volume/scan/occupancy.h"
#include "volume/scan/traversal.h"

namespace trephine::volume {

/// Solid samples of the cut lattice are connected to their 26 neighbours. In voxels that overlap a brick of
/// cuts, each sample is evaluated: it is solid if the trilinear field is solid and the sample is not removed.
/// In other voxels all samples equal the centre, so that on a lattice finer than the voxels a surface is
/// displaced by up to half a voxel. Therefore each sample is also evaluated in the surface voxels of detached
/// parts, up to two voxels around the boxes of these parts. Cost: one or two passes over the bits and over
/// the cut bricks.
class SolidParts {
 public:
  struct Part {
    std::int64_t samples = 0;
    VoxelBox box{glm::ivec3(0), glm::ivec3(-1)};  ///< voxels with samples of the part
    /// True if the part is detached: removed matter connects it to a larger part (or one of equal size and
    /// lower number).
    bool is_detached = false;
  };

  /// `bits`: occupancy of the field's shape.
  SolidParts(const Field& field, const Occupancy& bits, const Version& version);

  /// Parts in the order of their first samples (x fastest).
  const std::vector<Part>& parts() const noexcept { return parts_; }

  static constexpr int k_air = -1;
  /// Writes the index in parts() for each of `count` lattice samples along x, the first at (x, y, z); k_air
  /// for samples outside parts. Any thread.
  void row(int x, int y, int z, int count, int* parts) const noexcept;
  /// Returns the index in parts() of the part that contains a lattice sample, or k_air.
  int part_of(const glm::ivec3& sample) const noexcept {
    int part = k_air;
    row(sample.x, sample.y, sample.z, 1, &part);
    return part;
  }

 private:
  /// Run of solid samples (or voxels) along x.
  struct Run {
    int low, high;
    int part;  ///< during the search: number of the run; then: index in parts()
    bool is_removed = false;
  };
  struct Runs {
    const Run *begin, *end;
  };
  void find_fine_voxels();
  bool refine_surfaces(const Occupancy& bits);
  void find_parts(const Field& field, const Occupancy& bits);
  void add_coarse_runs(const Occupancy& bits, int y, int z);
  void add_fine_runs(const Field& field, int y, int z);
  /// Runs of a row of voxels whose samples are not evaluated.
  Runs coarse_row(int y, int z) const noexcept;
  /// Runs of a row of the lattice, in voxels whose samples are evaluated.
  Runs fine_row(int y, int z) const noexcept;
  template <class Join>
  void for_neighbours(Join&& join) const;
  void number_parts(std::vector<int>& part_of_run, std::vector<int>& whole_of_run);
  std::size_t row_index(int y, int z) const noexcept {
    return static_cast<std::size_t>(y) + static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(z);
  }
  bool is_in_grid(int y, int z) const noexcept { return y >= 0 && z >= 0 && y < size_.y && z < size_.z; }

  const Version* version_;  ///< set only during construction
  CutLattice lattice_;
  glm::ivec3 size_;                           ///< voxels
  std::size_t words_;                         ///< words per row of voxels
  std::vector<std::uint64_t> is_fine_;        ///< one bit per voxel: its samples are evaluated
  std::vector<Run> coarse_runs_, fine_runs_;  ///< in ascending rows
  std::vector<std::size_t> coarse_first_;     ///< first run of each row of voxels, and the end
  std::vector<int> fine_row_index_;           ///< per row of voxels: index in fine_first_; -1: no fine voxel
  std::vector<std::size_t> fine_first_;       ///< first run of each lattice row with fine voxels, and the end
  std::vector<Part> parts_;
};

}  // namespace trephine::volume
