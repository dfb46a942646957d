// The benchmarks behind `trephine bench`; every figure in docs/performance.md comes from here.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/measure.h"

namespace trephine::bench {

struct SurfaceRow {
  std::string volume;  ///< "shell" (skull-like) or "gyroid"
  int size = 0, threads = 0;
  double our_ms = 0, peer_ms = 0;
  std::size_t our_triangles = 0, peer_triangles = 0;
};
struct SurfaceResult {
  std::size_t drilled_chunk_vertices = 0;  ///< of the largest chunk under the burr
  std::vector<SurfaceRow> rows;
  StepTimes surface_chunk;  ///< any 32^3 chunk of the shell that holds surface, us
  StepTimes
      drilled_chunk;  ///< the one under a burr, remade after each tick: two sheets of bone and the cut, us
};
/// Whole surfaces of size^3 int16, bits included, beside FlyingEdges3D in one run (least of three), and dirty
/// chunks.
SurfaceResult run_surface_benchmark(int size);

struct ScalingRow {
  int size = 0;
  double voxels_a_step = 0, cells_a_step = 0;
  StepTimes step;
};
struct StepResult {
  StepTimes implicit;  ///< size^3 sphere in 120 mm, sigma 1.5, 100 mm/s, contact steps
  double voxels_a_step = 0;
  std::vector<ScalingRow> fixed_density;  ///< spacing 120/512 mm, 50^3 and up
  StepTimes removal_tick;                 ///< ball of 12 voxels at 50 mm/s, new version published
  StepTimes csg_tick;                     ///< the same by OpenVDB's csgDifference; count 0: was not there
  StepTimes csg_tick_with_capsule;        ///< and with the making of the swept ball's level set
  StepTimes removal_tick_over_scratches;  ///< the same where a ball of one voxel went all over before
  /// A 4 mm burr with its round tip in voxels of 0.5 mm at 10 mm/s, ms: how long an update of the offset
  /// field takes, and from a cut until the field that knows it is there, updates one after another.
  StepTimes field_update_ms, hover_ms;
};
StepResult run_step_benchmark(int size);

}  // namespace trephine::bench
