// Smooth field of a binary shape: labels and thresholded data have stair-steps, which are artefacts.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volume/field.h"
#include "volume/occupancy.h"
#include "volume/sample_brick.h"

namespace trephine::volume {

/// The bits of other shapes, on the grid of the volume, which must be as large. Into those of `whole` a shape
/// goes on for SoftField::k_overlap voxels wherever they meet: cuts between them stay closed. Into those of
/// `at_surface` only near its own voxels that have air next to them, so that nothing of it is touched where
/// the other, which covers it, lets a tool through.
struct SoftNeighbours {
  std::span<const Occupancy*const> whole = {}, at_surface = {};
  bool is_empty() const noexcept { return whole.empty() && at_surface.empty(); }
};

/// g = the solid blurred by a Gaussian of 1.5 voxels, less one half, with the sign of every voxel kept as it
/// is (in the manner of Whitaker 2000, "Reducing aliasing artifacts in iso-surfaces of binary volumes"):
/// where the blur would take a voxel to the other side by much - plates and rods of a voxel or two - the
/// shape stays as it is within two voxels. Samples in bricks that exist only near the surface; +-0.5
/// elsewhere; beyond the grid as Field is. Immutable; queries from any thread.
class SoftField {
 public:
  static constexpr double k_sigma = 1.5;
  static constexpr int k_reach = 4;        ///< voxels from the middle of the kernel
  static constexpr double k_least = 0.01;  ///< of |g| at a voxel
  static constexpr double k_conflict = 0.1;

  static constexpr int k_overlap = 4;  ///< voxels that a shape goes on into its neighbours

  /// Builds from the solid voxels alone. Shapes that meet leave no notch between their rounded edges: the
  /// samples are those of the shape with what it goes on into. threads 0 = all; the same bits for any number.
  static std::shared_ptr<const SoftField> build(const Occupancy& bits, int threads = 0,
                                                const SoftNeighbours& beside = {});
  /// Does a shape have but two values near its surface? A label does; so do thresholded intensities.
  static bool is_two_valued(const Field& field, const Occupancy& bits);

  double at(int x, int y, int z) const noexcept;
  /// Are all samples within one voxel of v air?
  bool is_air_around(const glm::ivec3& v) const noexcept;
  /// Samples around voxel v, anywhere.
  void load(const glm::ivec3& v, QuadraticPatch& patch) const noexcept;
  const glm::ivec3& size() const noexcept { return size_; }
  /// May the shape go on into others, up to k_overlap voxels beyond its own bits?
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
