// The inner loops of removal, for four lanes (any x-86-64) and eight (AVX2). The same operations in the
// same order in each lane, no fused multiply-add: both give the same bits.
#pragma once

#include <cstdint>

namespace trephine::volume {

/// A sweep in single precision, mm relative to its start. Plain data: the wide variant is compiled for newer
/// CPUs and must share no inline code with the rest.
struct SweepShape {
  float radius, band, length;
  float along[3];             ///< unit direction, or 0
  float ax[3], ay[3], az[3];  ///< a step of the cut lattice
  float cell_reach;           ///< half a cell's diagonal, with a margin for rounding
  float allowance;            ///< what distances are less than to the ball, so that splines of them are not
};

/// A body of revolution (ToolBody) at some places, in single precision, mm. Plain data also.
struct BodyShape {
  struct Stamp {
    float at[3], axis[3];  ///< relative to where the sweep starts
  };
  bool is_drum;
  float radius, length;
  float growth, slope;                    ///< of a cone: radii a length, and how far the nearest ball leans
  float edge, bulge, half, corner, core;  ///< of a drum: its edge's middle, along from the middle and off
  float lean_cosine, lean_sine;           ///< of the side's normal there
};

/// The n^3 points of a cell, n = 4 or 8, x fastest: offsets from its sample in steps, and their squared
/// length in mm.
struct CellPoints {
  int n;
  alignas(32) float x[512];
  alignas(32) float y[512];
  alignas(32) float z[512];
  alignas(32) float squared[512];
};

/// A brick after one sweep, and what follows from the sweep's distances, as bits laid out like Brick::kept.
struct BrickSweep {
  alignas(32) float distance[512];  ///< the nearer of old and new, mm, within +-band
  std::uint64_t kept[8];            ///< that distance is > 0
  std::uint64_t touched[8];         ///< the cell may meet the swept ball
  std::uint64_t inside[8];          ///< the cell lies in it
  std::uint64_t ahead[8];           ///< the cell does not lie wholly behind the sweep's start
  std::uint64_t past_end[8];        ///< the cell lies wholly past its end, where the sweep is a ball
  bool is_in_band, is_nearer, is_hollow;
};

struct RemovalKernels {
  /// `corner`: the brick's first sample; `is_ball`: the brick's cells lie wholly past the sweep's
  /// end;
  /// `old`: the distances so far, or null.
  void (*sweep_brick)(const SweepShape& shape, const float corner[3], bool is_ball, const float* old,
                      BrickSweep& out);
  /// Points of the cell around sample c in the swept ball; n^3 bits. `is_ball`: the cell lies past
  /// the end.
  void (*sample)(const SweepShape& shape, const CellPoints& points, const float c[3], bool is_ball,
                 std::uint64_t* words);
  /// Both for a body at each of `count` places (at least 1); `shape` is what is common.
  void (*stamp_brick)(const SweepShape& shape, const BodyShape& body, const BodyShape::Stamp* stamps,
                      int count, const float corner[3], const float* old, BrickSweep& out);
  void (*sample_stamps)(const SweepShape& shape, const BodyShape& body, const BodyShape::Stamp* stamps,
                        int count, const CellPoints& points, const float c[3], std::uint64_t* words);
};

extern const RemovalKernels k_removal_kernels_4;
extern const RemovalKernels k_removal_kernels_8;  ///< needs AVX2
/// The widest that this CPU runs.
const RemovalKernels& best_removal_kernels() noexcept;

}  // namespace trephine::volume
