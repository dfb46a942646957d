// X-rays of a volume beside plastimatch's in one run: the rows behind `trephine bench xray`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "haptics/servo/servo_loop.h"
#include "tests/bench/measure.h"

namespace trephine::bench {

struct XrayRow {
  std::string volume;  ///< "shell" (skull-like, noisy air), "solid" (nothing is empty)
  int size = 0, pixels = 0, threads = 1;
  double filled = 0;                   ///< share of blocks that count
  double preparing_ms = 0;             ///< once a volume
  double exact_ms = 0, joseph_ms = 0;  ///< an image, the mean of 12 around
  /// plastimatch's exact: what 10 images more take, so that start-up and reading cancel. Nothing: not there.
  std::optional<double> peer_ms;
  /// Of its images, and of Joseph's, from ours: root mean square, as a share of the largest sum.
  std::optional<double> peer_rmse;
  double joseph_rmse = 0;
  long judged = 0;         ///< rays summed up again in exact arithmetic
  double worst_error = 0;  ///< of these, as LineIntegrals promises it below 1e-6
};
/// size^3 voxels to pixels^2.
std::vector<XrayRow> run_xray_benchmark(int size, int pixels);

/// X-rays of the built-in spine while a hand drills it at 1 kHz, for some seconds each.
struct XrayBesideServo {
  struct Part {
    std::string name;  ///< "none", "256, still", "256, turning", "1024, turning"
    StepTimes image;   ///< us, of an image, from state to line integrals
    haptics::ServoReport servo;
  };
  std::vector<Part> parts;
};
XrayBesideServo run_xray_beside_servo(double seconds);

}  // namespace trephine::bench
