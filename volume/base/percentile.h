// Nearest-rank percentiles for reports and benchmarks.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace trephine {

/// Percentile p (0 to 100) of values in ascending order; 0 for an empty list.
template <class T>
double percentile(const std::vector<T>& sorted, double p) {
  if (sorted.empty()) return 0;
  constexpr double k_rounding = 1e-9;  // the product of 99.9 % and 1000 is a little above 999
  const auto rank =
      static_cast<std::size_t>(std::ceil(p / 100 * static_cast<double>(sorted.size()) - k_rounding));
  return static_cast<double>(sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1]);
}
/// Percentile p (0 to 100) of values in any order.
template <class T>
double percentile_of(std::vector<T> values, double p) {
  std::sort(values.begin(), values.end());
  return percentile(values, p);
}

}  // namespace trephine
