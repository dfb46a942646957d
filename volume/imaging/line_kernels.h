// LineKernels: inner loops of line integrals for packets of eight rays, in a variant for any x86-64 and one
// for AVX2. Both variants do the same operations per lane in the same order, without fused multiply-add, so
// that their results are bit-identical.
#pragma once

#include <cstdint>

namespace trephine::volume {

/// Volume as slabs perpendicular to axis d and spanned by axes a and b. Plain data: the wide variant is
/// compiled for newer CPUs and shares no inline code with the rest.
struct SlabVolume {
  const std::int16_t* voxels;
  std::int64_t stride_d;  ///< voxels from one slab to the next
  std::int32_t stride_a, stride_b;
  std::int32_t size_a, size_b;
  std::int32_t last;                ///< largest offset within a slab
  std::int32_t highest_weightless;  ///< intensities up to this have weight 0
  std::int32_t zero, knee_above;    ///< intensity above which weights increase; knee relative to `zero`
  float below, above;               ///< weight per step of intensity, below and above the knee
};

/// Eight rays that cross every slab. Descending coordinates along a and b are mirrored, so that all ascend
/// with d; voxel i is the interval [i, i + 1).
struct RayPacket {
  alignas(32) double a[8], b[8];                      ///< coordinates in the plane d = 0
  alignas(32) double slope_a[8], slope_b[8];          ///< voxels per slab, 0 to 1
  alignas(32) std::uint32_t step_a[8], step_b[8];     ///< slopes in units of 2^-32
  alignas(32) float per_a[8], per_b[8];               ///< 2^-31 / slope; 0 if the slope is 0
  alignas(32) std::int32_t mirror_a[8], mirror_b[8];  ///< -1 if mirrored, else 0
};

struct LineKernels {
  /// Adds to `sums` the integrals over `count` (at most 8) slabs from d = k on, in units of the slab width.
  /// `is_inside`: the rays stay more than a voxel inside the volume along a and b.
  void (*exact)(const SlabVolume& volume, const RayPacket& rays, int k, int count, bool is_inside,
                double* sums);
  /// Variant that interpolates weights in the middle plane of each slab.
  void (*joseph)(const SlabVolume& volume, const RayPacket& rays, int k, int count, bool is_inside,
                 double* sums);
};

extern const LineKernels k_line_kernels_any;
extern const LineKernels k_line_kernels_wide;  ///< requires AVX2
/// Returns the fastest variant that this CPU supports.
const LineKernels& best_line_kernels() noexcept;

}  // namespace trephine::volume
