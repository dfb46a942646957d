// What a burr takes away of solid bone, against its closed form: ours, and the ways of others.
#pragma once

#include <string>
#include <vector>

#include "haptics/servo/servo_loop.h"
#include "tests/bench/measure.h"

namespace trephine::bench {

struct DrillingRow {
  std::string way, burr, voxels;
  double rate_hz = 0;
  double volume_error = 0;      ///< of the exact volume; negative: too little
  double surface_error_mm = 0;  ///< the largest, across its way, from the exact surface
  StepTimes tick;               ///< us
};
/// A burr of 4 mm goes through solid bone: 8 mm at 20 mm/s, and ours in shorter and slower strokes too.
std::vector<DrillingRow> run_drilling_benchmark(bool is_quick);

/// A servo at 1 kHz while a hand presses on bone and goes to and fro, for some seconds: with a burr that
/// drills, and without one.
struct ServoBesideDrilling {
  haptics::ServoReport touching, drilling;
  double removed_mm3 = 0;
};
ServoBesideDrilling run_servo_beside_drilling(double seconds);

}  // namespace trephine::bench
