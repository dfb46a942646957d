// Whole tools: times of contact of a burr with its shaft by method shell (points on the surface of the tool),
// compared with published voxel sampling and FCL.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/bench/measure.h"

namespace trephine::bench {

struct WholeToolRow {
  double spacing = 0;  ///< mm, of the tool's points
  std::size_t points = 0;
  double make_ms = 0;     ///< to sample the surface of the tool
  StepTimes free_us;      ///< method shell, away from matter
  StepTimes slide_us;     ///< method shell: the tool slides over the skull, with the hand 4 mm deep
  StepTimes hole_us;      ///< method shell: the tool is levered in a burr hole
  StepTimes sampling_us;  ///< one sum of published forces (VoxelSampling), at the poses of the slide
  double tested = 0;      ///< points and nodes that the sampling tests, as a share of all points
  StepTimes layer_us;     ///< one sum of pressures (LayerContact), at the poses of the slide
  /// One collision query of FCL (up to 100 contacts), at the poses of the slide. Measured only for a spacing
  /// of 0.25 mm; count 0: not measured, or FCL is not built in.
  StepTimes fcl_us;
};
struct WholeToolResult {
  int size[3] = {0, 0, 0};    ///< of the head phantom, voxels
  double voxmap_seconds = 0;  ///< to make the VoxMap
  double voxmap_mb = 0;
  /// Look-ups of the voxels of a tool's points at the poses of the slide, in the order of the points: mean
  /// time, ns; with OpenVDB's tree, below 0 if OpenVDB is not built in.
  double voxmap_ns = 0, openvdb_ns = -1, openvdb_mb = -1;
  bool are_lookups_equal = true;
  std::vector<WholeToolRow> rows;
};
/// `is_quick`: a coarser phantom and fewer ticks.
WholeToolResult run_whole_tool_benchmark(bool is_quick);

/// Times of the forces at given poses for a tool of about 100,000 points.
struct DenseToolRow {
  std::string place;
  int size[3] = {0, 0, 0};  ///< of the volume, voxels
  std::size_t points = 0;
  double near = 0;        ///< mean share of the points in the layer or in matter
  StepTimes sampling_us;  ///< VoxelSampling
  StepTimes layer_us;     ///< LayerContact
};
/// A cylinder that lies on the head phantom, so that about 5 % of its points are near matter, and a cylinder
/// that fills a hole, so that all are. `is_quick`: coarser volumes.
std::vector<DenseToolRow> run_dense_tool_benchmark(bool is_quick);

/// Random passes of a rod at 1 m/s and 10 rad/s against a plate of one voxel.
struct PassRow {
  std::string method;  ///< "shell", or "published voxel sampling" for comparison
  long passes = 0;
  long through = 0;  ///< passes after which a part of the rod's axis is behind the plate
};
/// `passes`: of method shell; 1000 at most of the other.
std::vector<PassRow> run_plate_passes(long passes, const std::function<bool(double)>& progress);

}  // namespace trephine::bench
