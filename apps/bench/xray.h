// X-rays of a volume, compared with plastimatch's in one run: rows of `trephine-bench xray`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/bench/measure.h"
#include "haptics/servo/servo_loop.h"

namespace trephine::bench {

struct XrayRow {
  std::string volume;  ///< "shell" (skull-like, noisy air), "solid" (nothing is empty)
  int size = 0, pixels = 0, threads = 1;
  double filled = 0;                   ///< fraction of blocks that are not empty
  double preparing_ms = 0;             ///< once per volume
  double exact_ms = 0, joseph_ms = 0;  ///< per image, mean of 12 directions around z
  /// plastimatch's exact sums: difference for 10 more images, so that start-up and reading cancel. Empty:
  /// missing.
  std::optional<double> peer_ms;
  /// Deviation of plastimatch's images, and of Joseph's, from ours: root mean square, relative to the largest
  /// sum.
  std::optional<double> peer_rmse;
  double joseph_rmse = 0;
  long judged = 0;         ///< rays repeated in exact arithmetic
  double worst_error = 0;  ///< of these, error by the measure that LineIntegrals keeps below 1e-6
};
/// size^3 voxels to pixels^2.
std::vector<XrayRow> run_xray_benchmark(int size, int pixels);

/// X-rays of the built-in spine while a hand drills it at 1 kHz, for some seconds each.
struct XrayServoLoad {
  struct Part {
    std::string name;  ///< "none", "256, still", "256, turning", "1024, turning"
    StepTimes image;   ///< us per image, from state to line integrals
    haptics::ServoReport servo;
  };
  std::vector<Part> parts;
};
XrayServoLoad run_servo_during_xray(double seconds);

}  // namespace trephine::bench
