// Detection of detached bodies after each stroke of a saw around a flap of the built-in head: rows of
// `trephine-bench separation`.
#pragma once

#include <string>
#include <vector>

namespace trephine::bench {

struct SeparationRow {
  double voxel_mm = 0, burr_mm = 0;
  int samples_per_voxel = 1;  ///< samples of the cut lattice, along an axis
  /// Number of strokes, and of their results of each kind (volume::Separation); `held`: connected.
  int strokes = 0, held = 0, detached = 0, pending = 0;
  double p50_ms = 0, p99_ms = 0;  ///< of one detection
  double complete_ms = 0;         ///< recomputing all parts of the whole volume (SolidParts), last stroke
  int wrong = 0;                  ///< results that contradict the recomputed parts
};
std::vector<SeparationRow> run_separation_benchmark();

}  // namespace trephine::bench
