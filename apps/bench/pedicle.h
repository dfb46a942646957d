// Pedicle screws and the probe: times of placing and judging screws, of their overlays, and of a servo step
// of the probe; and the force of the probe. Rows of `trephine-bench pedicle`.
#pragma once

#include <vector>

#include "apps/bench/measure.h"
#include "modules/pedicle/pedicle.h"

namespace trephine::bench {

struct PedicleResult {
  int width = 0, slices = 0;          ///< of the scan, voxels
  double place_ms = 0, judge_ms = 0;  ///< least of several screws, including the adoption of the result
  StepTimes overlays_ms;              ///< computation of all overlays, while a screw turns in
  /// Servo steps of a probe whose track grows, us: per-step minimum of identical runs.
  StepTimes probe_us;
};
/// Screws in L4 of the spine phantom; the probe in a block. `is_quick`: a scan with half the columns, rows
/// and slices.
PedicleResult run_pedicle_benchmark(bool is_quick);

/// Force of a probe that is pushed through a plate; one sample per tick.
struct InsertionTrace {
  std::vector<double> depth_mm;  ///< of the tip below the upper face of the plate
  std::vector<double> force_n;   ///< against the hand, along the shaft

  /// Mean force in steps of depth of `width` mm, from 0 to `end` mm. A step without a sample is NaN.
  std::vector<double> means(double width, double end) const;
};
constexpr double k_trace_plate_mm = 16;  ///< thickness of the plate
/// Pushes at 2 mm/s. Returns no samples if the scene cannot be prepared.
InsertionTrace trace_insertion(pedicle::Guide guide);

}  // namespace trephine::bench
