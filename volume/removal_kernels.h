// The two inner loops of removal, for four lanes (any x-86-64) and eight (AVX2). The same operations in the
// same order in each lane, no fused multiply-add: both give the same bits.
#pragma once

#include <cstdint>

namespace trephine::volume {

/// A sweep in single precision, mm relative to its start. Plain data: the wide variant is compiled for newer
/// CPUs and must share no inline code with the rest.
struct SweepShape {
  int n;  ///< samples along a voxel's edge, 4 or 8
  float radius, band, length;
  float along[3];             ///< unit direction, or 0
  float ax[3], ay[3], az[3];  ///< a voxel step
  float voxel_reach;          ///< half a voxel's diagonal, with a margin for rounding
  /// Of each sample of a voxel (x fastest): its offsets in voxels, and the squared length of the offset in
  /// mm.
  alignas(32) float offset_x[512];
  alignas(32) float offset_y[512];
  alignas(32) float offset_z[512];
  alignas(32) float offset_squared[512];
};

/// A brick after one sweep, and what follows from the sweep's distances, as bits laid out like Brick::kept.
struct BrickSweep {
  alignas(32) float distance[512];  ///< the nearer of old and new, mm, within +-band
  std::uint64_t kept[8];            ///< that distance is > 0
  std::uint64_t touched[8];         ///< the voxel's cube may meet the swept ball
  std::uint64_t inside[8];          ///< the voxel's cube lies in it
  std::uint64_t ahead[8];           ///< the cube does not lie wholly behind the sweep's start
  std::uint64_t past_end[8];        ///< the cube lies wholly past its end, where the sweep is a ball
  bool is_in_band, is_nearer, is_hollow;
};

struct RemovalKernels {
  /// `corner`: centre of the brick's first voxel; `is_ball`: the brick lies wholly past the sweep's end;
  /// `old`: the distances so far, or null.
  void (*sweep_brick)(const SweepShape& shape, const float corner[3], bool is_ball, const float* old,
                      BrickSweep& out);
  /// Which samples of the voxel centred at c lie in the swept ball; n^3 bits. `is_ball`: the voxel lies past
  /// the end.
  void (*sample)(const SweepShape& shape, const float c[3], bool is_ball, std::uint64_t* words);
};

extern const RemovalKernels k_removal_kernels_4;
extern const RemovalKernels k_removal_kernels_8;  ///< needs AVX2
/// The widest that this CPU runs.
const RemovalKernels& best_removal_kernels() noexcept;

}  // namespace trephine::volume
