// X-rays of a volume beside plastimatch's in one run: the rows behind `trephine bench xray`.
#pragma once

#include <optional>
#include <string>
#include <vector>

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

}  // namespace trephine::bench
