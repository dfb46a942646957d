// Whole tools: times of contact with the surface of a shafted burr, compared with published voxel sampling
// and FCL.
#pragma once

#include <string>
#include <vector>

#include "apps/bench/measure.h"

namespace trephine::bench {

struct WholeToolRow {
  double spacing = 0;  ///< mm, of the tool's points
  std::size_t points = 0;
  double make_ms = 0;     ///< sampling of the tool
  StepTimes free_us;      ///< method shell, away from matter
  StepTimes slide_us;     ///< method shell: the tool slides over the skull, pressed by 4 mm
  StepTimes hole_us;      ///< method shell: the tool is levered in a burr hole
  StepTimes sampling_us;  ///< one sum of published forces (VoxelSampling), at the poses of the slide
  double tested = 0;      ///< share of points and nodes that it tests, of all points
  StepTimes fcl_us;  ///< one collision query of FCL (up to 100 contacts), at these poses; 0: not built in
};
struct WholeToolResult {
  int size[3] = {0, 0, 0};    ///< of the head phantom, voxels
  double voxmap_seconds = 0;  ///< to make the VoxMap
  double voxmap_mb = 0;
  std::vector<WholeToolRow> rows;
};
/// `is_quick`: a coarser phantom and fewer ticks.
WholeToolResult run_whole_tool_benchmark(bool is_quick);

/// Mean and noise (Kadlecek 2013, eq. 3.20) of the force of a dynamic tool in free
/// motion, by integrator: figure 3.16.
struct IntegratorRow {
  std::string name;
  double mean = 0, noise = 0;  ///< N
};
std::vector<IntegratorRow> compare_integrators();

/// The lever task of Kadlecek (2013): largest number of the tool's points in the interior of two plates,
/// through which a tool can pass.
struct LeverRow {
  bool is_limited;
  int points = 0;
  double turned = 0;  ///< degrees, of the tool, while the hand turned by 34
};
std::vector<LeverRow> run_lever_task();

}  // namespace trephine::bench
