// Pedicle screws and the probe: times of placing, judging, drawing and of a servo step.
#pragma once

#include "apps/bench/measure.h"

namespace trephine::bench {

struct PedicleResult {
  int width = 0, slices = 0;          ///< of the scan, voxels
  double place_ms = 0, judge_ms = 0;  ///< least of several screws, with the adoption of the result
  StepTimes overlays_ms;              ///< overlays of the module, while a screw turns in
  /// Servo steps of a probe whose track grows, us: per-step minimum of identical runs.
  StepTimes probe_us;
};
/// Screws in L4 of the spine phantom; the probe in a plate. `is_quick`: a scan of half the width.
PedicleResult run_pedicle_benchmark(bool is_quick);

}  // namespace trephine::bench
