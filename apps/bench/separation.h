// Detection of detached pieces after each stroke of a saw around a flap of the built-in head.
#pragma once

#include <string>
#include <vector>

namespace trephine::bench {

struct SeparationRow {
  double voxel_mm = 0, burr_mm = 0;
  int samples_a_voxel = 1;  ///< along an axis
  int strokes = 0, held = 0, detached = 0, pending = 0;
  double p50_ms = 0, p99_ms = 0;  ///< of one detection
  double complete_ms = 0;         ///< all parts of the whole volume recomputed
  int wrong = 0;                  ///< results that contradict those parts
};
std::vector<SeparationRow> run_separation_benchmark();

}  // namespace trephine::bench
