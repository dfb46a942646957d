// X-rays of a volume, compared with those of plastimatch in one run: rows of `trephine-bench xray`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/bench/measure.h"
#include "haptics/servo/servo_loop.h"

namespace trephine::bench {

struct XrayRow {
  std::string volume;  ///< "shell" (skull-like, noisy air), "solid" (no block is empty)
  int size = 0, pixels = 0, threads = 1;
  double filled = 0;                   ///< fraction of blocks that are not empty
  double preparing_ms = 0;             ///< to make the LineIntegrals, once per volume
  double exact_ms = 0, joseph_ms = 0;  ///< per image, mean of 12 directions around z
  /// Time of plastimatch per image with exact sums: a tenth of the difference between runs of 12 and of 2
  /// images, so that start-up and reading cancel. Empty: plastimatch is missing or failed.
  std::optional<double> peer_ms;
  /// Root mean square deviation from our exact sums, relative to the largest sum: of plastimatch's images,
  /// and of our sums by Joseph's method.
  std::optional<double> peer_rmse;
  double joseph_rmse = 0;
  long judged = 0;         ///< rays repeated in exact arithmetic
  double worst_error = 0;  ///< largest relative error of these rays, as LineIntegrals::integrate() defines it
};
/// Measures images of pixels^2 pixels of volumes of size^3 voxels.
std::vector<XrayRow> run_xray_benchmark(int size, int pixels);

/// Times of X-rays of the built-in spine, and of the servo, while a hand drills the spine at 1 kHz.
struct XrayServoLoad {
  struct Part {
    std::string name;  ///< pixels and motion: "none", "256, still", "256, turning", "1024, turning"
    StepTimes image;   ///< us per image: from reading the state to the finished line integrals
    haptics::ServoReport servo;
  };
  std::vector<Part> parts;
};
/// `seconds`: duration of each part.
XrayServoLoad run_servo_during_xray(double seconds);

}  // namespace trephine::bench
