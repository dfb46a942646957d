// Histogram: durations on a servo thread, counted without allocation and read on any thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace trephine::haptics {

/// Buckets have a width of 1 ns up to 64 ns, and of at most 3.2 % of the duration up to 68 s. Longer
/// durations count in the last bucket. Call add() on one thread. Other threads may read at the same time;
/// they get a recent state.
class Histogram {
 public:
  void add(std::uint64_t ns) noexcept {
    auto& bucket = counts_[bucket_of(ns)];
    bucket.store(bucket.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (ns > max_.load(std::memory_order_relaxed)) max_.store(ns, std::memory_order_relaxed);
  }
  std::uint64_t count() const noexcept;
  /// Returns the nearest-rank percentile in us (0 < p <= 100): the upper edge of its bucket, at most
  /// max_us(). 0 when empty.
  double percentile_us(double p) const noexcept;
  double max_us() const noexcept { return static_cast<double>(max_.load(std::memory_order_relaxed)) * 1e-3; }
  void reset() noexcept;

 private:
  static constexpr int k_parts = 32;  // buckets per octave
  static std::size_t bucket_of(std::uint64_t ns) noexcept;
  static double upper_edge_ns(std::size_t bucket) noexcept;
  std::array<std::atomic<std::uint64_t>, 32 * k_parts> counts_{};
  std::atomic<std::uint64_t> max_{0};
};

}  // namespace trephine::haptics
