// Error of the hole that a burr drills into solid bone, compared with the exact hole: our sweeps and other
// methods. Rows of `trephine-bench drill`.
#pragma once

#include <string>
#include <vector>

#include "apps/bench/measure.h"
#include "haptics/servo/servo_loop.h"

namespace trephine::bench {

struct DrillingRow {
  std::string method, burr, voxels;
  double rate_hz = 0;
  double volume_error = 0;      ///< relative to the exact volume; negative: too little
  double surface_error_mm = 0;  ///< largest distance from the exact surface, across the path
  StepTimes tick;               ///< us
};
/// A burr of 4 mm moves through solid bone: 8 mm at 20 mm/s; with our method also in shorter and slower
/// strokes.
std::vector<DrillingRow> run_drilling_benchmark(bool is_quick);

/// A servo at 1 kHz while a hand presses on bone and moves back and forth, for some seconds: with a burr that
/// drills, and without one.
struct DrillingServoLoad {
  haptics::ServoReport touching, drilling;
  double removed_mm3 = 0;
};
DrillingServoLoad run_servo_during_drilling(double seconds);

}  // namespace trephine::bench
