#include "haptics/servo/histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace trephine::haptics {

std::size_t Histogram::bucket_of(std::uint64_t ns) noexcept {
  if (ns < k_parts) return static_cast<std::size_t>(ns);
  const int octave = static_cast<int>(std::bit_width(ns)) - 6;  // so that ns >> octave is in [32, 64)
  const std::size_t bucket =
      static_cast<std::size_t>(octave) * k_parts + static_cast<std::size_t>(ns >> octave);
  return std::min<std::size_t>(bucket, 32 * k_parts - 1);
}

double Histogram::upper_edge_ns(std::size_t bucket) noexcept {
  if (bucket < 2 * k_parts) return static_cast<double>(bucket);
  const std::size_t octave = bucket / k_parts - 1;
  return static_cast<double>((bucket - octave * k_parts + 1) << octave) - 1;
}

std::uint64_t Histogram::count() const noexcept {
  std::uint64_t sum = 0;
  for (const auto& c : counts_) sum += c.load(std::memory_order_relaxed);
  return sum;
}

double Histogram::percentile_us(double p) const noexcept {
  const std::uint64_t total = count();
  if (total == 0) return 0;
  const auto rank = static_cast<std::uint64_t>(std::ceil(p / 100 * static_cast<double>(total)));
  std::uint64_t cumulative = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    cumulative += counts_[i].load(std::memory_order_relaxed);
    if (cumulative >= std::max<std::uint64_t>(rank, 1)) return std::min(upper_edge_ns(i) * 1e-3, max_us());
  }
  return max_us();
}

void Histogram::reset() noexcept {
  for (auto& c : counts_) c.store(0, std::memory_order_relaxed);
  max_.store(0, std::memory_order_relaxed);
}

}  // namespace trephine::haptics
