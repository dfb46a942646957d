// The inner loops of line integrals, eight rays side by side: for any x86-64 and for AVX2. The same
// operations in the same order in each lane, no fused multiply-add: both give the same bits.
#pragma once

#include <cstdint>

namespace trephine::volume {

/// A volume as the kernels see it: voxels in slabs across axis d, in which axes a and b lie. Plain data: the
/// wide variant is compiled for newer CPUs and shares no inline code with the rest.
struct SlabVolume {
  const std::int16_t* voxels;
  std::int64_t stride_d;  ///< voxels from one slab to the next
  std::int32_t stride_a, stride_b;
  std::int32_t size_a, size_b;
  std::int32_t last;              ///< the greatest offset within a slab
  std::int32_t none;              ///< up to this intensity nothing counts
  std::int32_t zero, knee_above;  ///< where the lower line begins; of the knee above that
  float below, above;             ///< what a step of intensity counts, below and above the knee
};

/// Eight rays that cross every slab. Coordinates along a and b are mirrored where they fall, so that they
/// rise with d; voxel i holds [i, i + 1).
struct RayPacket {
  alignas(32) double a[8], b[8];                      ///< where they cross the plane d = 0
  alignas(32) double slope_a[8], slope_b[8];          ///< a slab, 0 to 1
  alignas(32) std::uint32_t step_a[8], step_b[8];     ///< the same in 2^-32
  alignas(32) float per_a[8], per_b[8];               ///< 2^-31 / slope; 0 where that is 0
  alignas(32) std::int32_t mirror_a[8], mirror_b[8];  ///< -1 where mirrored, else 0
};

struct LineKernels {
  /// Adds to `sums` what the rays sum up in `count` (at most 8) slabs from d = k on, in slabs' widths.
  /// `is_inside`: they stay more than a voxel within the volume's sides.
  void (*exact)(const SlabVolume& volume, const RayPacket& rays, int k, int count, bool is_inside,
                double* sums);
  /// Variant that interpolates intensities in the middle plane of each slab.
  void (*joseph)(const SlabVolume& volume, const RayPacket& rays, int k, int count, bool is_inside,
                 double* sums);
};

extern const LineKernels k_line_kernels_any;
extern const LineKernels k_line_kernels_wide;  ///< needs AVX2
/// The fastest that this CPU runs.
const LineKernels& best_line_kernels() noexcept;

}  // namespace trephine::volume
