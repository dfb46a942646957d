// RemovalKernels: inner loops of removal, with four lanes (any x86-64) and with eight (AVX2). Each lane does
// the same operations in the same order, without fused multiply-add: both variants give the same bits.
#pragma once

#include <cstdint>

namespace trephine::volume {

/// Sweep of a ball in single precision, mm relative to its start. Plain data without functions: the variant
/// with eight lanes is compiled for newer CPUs, and the linker could choose its copy of a shared inline
/// function for all callers.
struct SweepShape {
  float radius, band, length;
  float along[3];             ///< unit direction; 0 if the sweep has no length
  float ax[3], ay[3], az[3];  ///< one step of the cut lattice along x, y, z, mm
  float cell_reach;           ///< half a cell's diagonal, with a margin for rounding, mm
  float allowance;            ///< mm; subtracted from all distances, because splines of them are too large
};

/// Body of revolution (ToolBody) in single precision, mm; a stamp is one of its poses. Also plain data.
struct BodyShape {
  struct Stamp {
    float at[3], axis[3];  ///< origin relative to the start of the sweep, and unit axis
  };
  bool is_drum;
  float radius, length;
  /// Cone: change of the radius per length along the axis (growth); shift of the nearest ball's centre along
  /// the axis per distance of the point from the axis (slope).
  float growth, slope;
  /// Drum: radius of its rounded edges, curvature of its side (bulge), half its length, and the centre of the
  /// rounding: distance from the middle along the axis (corner), and from the axis (core).
  float edge, bulge, half, corner, core;
  float lean_cosine, lean_sine;  ///< drum: inclination of the side's normal at the edge
};

/// The n^3 points of a cell, n = 4 or 8, x fastest: offsets from its sample in steps, and their squared
/// length in mm^2.
struct CellPoints {
  int n;
  alignas(32) float x[512];
  alignas(32) float y[512];
  alignas(32) float z[512];
  alignas(32) float squared[512];
};

/// Result of a sweep for one brick: distances, and bits of its cells laid out as Brick::kept.
struct BrickSweep {
  alignas(32) float distance[512];  ///< smaller of old and new, mm, within +-band
  std::uint64_t kept[8];            ///< the distance is > 0
  std::uint64_t touched[8];         ///< the cell may meet the swept shape
  std::uint64_t inside[8];          ///< the cell is completely in the swept shape
  std::uint64_t ahead[8];           ///< the cell is not completely behind the sweep's start
  std::uint64_t past_end[8];        ///< the cell is completely past the sweep's end, in the last ball's range
  bool is_in_band;                  ///< a sample is nearer to the sweep than the band
  bool is_nearer;                   ///< a distance decreased, or there were no old distances
  bool is_hollow;                   ///< all samples are deeper than the band
};

struct RemovalKernels {
  /// `corner`: the brick's first sample. `is_ball`: all cells of the brick are completely past the sweep's
  /// end. `old`: previous distances, or null.
  void (*sweep_brick)(const SweepShape& shape, const float corner[3], bool is_ball, const float* old,
                      BrickSweep& out);
  /// Computes the points of the cell around sample c that are in the swept ball; n^3 bits. `is_ball`: the
  /// cell is past the end.
  void (*sample)(const SweepShape& shape, const CellPoints& points, const float c[3], bool is_ball,
                 std::uint64_t* words);
  /// Both operations for a body at `count` stamps (at least 1); `shape` has the common data.
  void (*stamp_brick)(const SweepShape& shape, const BodyShape& body, const BodyShape::Stamp* stamps,
                      int count, const float corner[3], const float* old, BrickSweep& out);
  void (*sample_stamps)(const SweepShape& shape, const BodyShape& body, const BodyShape::Stamp* stamps,
                        int count, const CellPoints& points, const float c[3], std::uint64_t* words);
};

extern const RemovalKernels k_removal_kernels_4;
extern const RemovalKernels k_removal_kernels_8;  ///< requires AVX2
/// Returns the widest variant that this CPU supports. Also declared in removal.h, for callers that do not
/// include this file.
const RemovalKernels& best_removal_kernels() noexcept;

}  // namespace trephine::volume
