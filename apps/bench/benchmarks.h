// Benchmarks of surfaces, steps and cuts: rows of `trephine-bench surface` and `trephine-bench step`.
#pragma once

#include <string>
#include <vector>

#include "apps/bench/measure.h"

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
  StepTimes surface_chunk;  ///< us, 32^3 chunks of the shell that contain surface
  StepTimes
      drilled_chunk;  ///< us, the chunk under a burr, remeshed each tick: two sheets of bone and the cut
};
/// Times the extraction of whole surfaces of size^3 int16, including the thresholding of the voxels, compared
/// with FlyingEdges3D in one run (least of three); and of single chunks.
SurfaceResult run_surface_benchmark(int size);

struct ScalingRow {
  int size = 0;
  double voxels_per_step = 0, cells_per_step = 0;
  StepTimes step;
};
struct StepResult {
  StepTimes implicit;  ///< us, sphere in a box of 120 mm with size^3 voxels, sigma 1.5, 100 mm/s
  double voxels_per_step = 0;
  std::vector<ScalingRow> fixed_density;  ///< spacing 120/512 mm, 50^3 and up
  StepTimes chain_corner;  ///< us, a rod of 16 balls of 6 mm in a corner of a mesh with edges of 0.5 mm
  StepTimes removal_tick;  ///< us, ball of 24 voxels in diameter at 50 mm/s, new version published
  StepTimes csg_tick;      ///< us, with OpenVDB's csgDifference; count 0: not built in
  StepTimes csg_tick_with_capsule;  ///< us, including the level set of the swept ball
  /// us, in bone covered with scratches of a ball of 2 voxels in diameter
  StepTimes removal_tick_over_scratches;
  /// A 4 mm burr with its round tip in voxels of 0.5 mm at 10 mm/s, ms: duration of an update of the offset
  /// field, and time from a cut until a field contains it, with updates one after another.
  StepTimes field_update_ms, hover_ms;
  /// ns, one read and one write of a device whose driver reports 4000 poses per second on another thread:
  /// alone, and with a map of the workspace and a pedal.
  StepTimes device_read, device_write, mapped_read, mapped_write;
};
StepResult run_step_benchmark(int size);

}  // namespace trephine::bench
