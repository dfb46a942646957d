// Measuring in benchmarks: percentiles over steps of the per-step minimum of several identical runs.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

namespace trephine::bench {

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Nearest-rank percentiles, in the unit of the values: us, unless a name states another unit.
struct StepTimes {
  std::size_t count = 0;
  double mean = 0, p50 = 0, p99 = 0, p999 = 0, max = 0;
};

inline StepTimes times_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  StepTimes times;
  times.count = values.size();
  if (values.empty()) return times;
  for (const double value : values) times.mean += value / static_cast<double>(values.size());
  const auto at = [&](double p) {
    return values[static_cast<std::size_t>(std::ceil(p / 100 * static_cast<double>(values.size()))) - 1];
  };
  times.p50 = at(50), times.p99 = at(99), times.p999 = at(99.9), times.max = values.back();
  return times;
}

/// Collects the minimum of each step over identical runs.
class MinimumOfRuns {
 public:
  static constexpr int k_runs = 5;
  static constexpr std::size_t k_dropped = 100;  // first steps of a run

  void add(std::size_t step, double us) {
    if (step >= min_times_.size()) min_times_.resize(step + 1, 1e300);
    min_times_[step] = std::min(min_times_[step], us);
  }
  /// Percentiles over all added steps, without the first k_dropped.
  StepTimes result() const {
    std::vector<double> values;
    for (std::size_t i = k_dropped; i < min_times_.size(); ++i)
      if (min_times_[i] < 1e299) values.push_back(min_times_[i]);
    return times_of(std::move(values));
  }

 private:
  std::vector<double> min_times_;
};

}  // namespace trephine::bench
