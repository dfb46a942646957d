// SoftField: smooth field of a binary shape, without the staircase artefacts of labels and thresholded data.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volume/fields/sample_brick.h"
#include "volume/scan/field.h"
#include "volume/scan/occupancy.h"

namespace trephine::volume {

/// Occupancies of neighbouring shapes, on a grid of the same size. A shape is extended by
/// SoftField::k_overlap voxels into the shapes of `whole` wherever they touch, so that no gap opens between
/// them in a cut. It is extended into the shapes of `at_surface` only near its own voxels that are next to
/// air: a tool that has passed into one of these shapes must not touch the extension inside it.
struct SoftNeighbours {
  std::span<const Occupancy*const> whole = {}, at_surface = {};
  bool is_empty() const noexcept { return whole.empty() && at_surface.empty(); }
};

/// g = the solid blurred by a Gaussian of 1.5 voxels, minus one half, with the sign of every voxel preserved
/// (after Whitaker 2000, "Reducing aliasing artifacts in iso-surfaces of binary volumes"). If the blur
/// gives a voxel the wrong sign and a magnitude above k_conflict (in plates and rods of one or two voxels),
/// the shape is not blurred within two voxels of it. Samples are stored in bricks near the surface. Elsewhere
/// in the grid g is +-0.5; beyond the grid it is defined as in Field. Immutable; queries from any thread.
class SoftField {
 public:
  static constexpr double k_sigma = 1.5;     ///< voxels
  static constexpr int k_reach = 4;          ///< radius of the kernel, voxels
  static constexpr double k_min = 0.01;      ///< least |g| at a voxel
  static constexpr double k_conflict = 0.1;  ///< |g| of wrong sign above which the blur is undone

  static constexpr int k_overlap = 4;  ///< extension of a shape into its neighbours, voxels

  /// Builds from the solid voxels of the shape, extended into its neighbours so that there is no notch
  /// between the rounded edges of touching shapes. threads 0 = all cores. The result is identical for any
  /// number of threads.
  static std::shared_ptr<const SoftField> build(const Occupancy& bits, int threads = 0,
                                                const SoftNeighbours& neighbours = {});
  /// Returns true if a shape has only two intensities near its surface, as labels and thresholded scans do.
  /// Compares only voxels that are neighbours along x. Returns false for intensities without a surface across
  /// x.
  static bool is_two_valued(const Field& field, const Occupancy& bits);

  /// g at a voxel centre, also beyond the grid.
  double at(int x, int y, int z) const noexcept;
  /// Returns true if all samples within one voxel of v are air.
  bool is_air_around(const glm::ivec3& v) const noexcept;
  /// Loads the samples around voxel v, which may be outside the grid.
  void load(const glm::ivec3& v, QuadraticPatch& patch) const noexcept;
  const glm::ivec3& size() const noexcept { return size_; }
  /// Returns true if the shape may extend up to k_overlap voxels beyond its own bits.
  bool is_extended() const noexcept { return is_extended_; }
  std::size_t bytes() const noexcept;

 private:
  std::size_t slot_index(int bx, int by, int bz) const noexcept {
    return static_cast<std::size_t>(bx + slots_size_.x * (by + slots_size_.y * bz));
  }
  glm::ivec3 size_{0}, slots_size_{0};
  bool is_extended_ = false;
  std::vector<SampleSlot> slots_;
};

}  // namespace trephine::volume
