// MixHash: fast 64-bit hash of a sequence of words, to distinguish data; not cryptographic.
#pragma once

#include <bit>
#include <cstdint>

namespace trephine {

/// For each word: XOR, multiplication, and XOR of the high half into the low half. The result is equal on
/// every machine.
class MixHash {
 public:
  void add(std::uint64_t word) noexcept {
    state_ = (state_ ^ word) * 0x9e3779b97f4a7c15u;
    state_ ^= state_ >> 32;
  }
  /// Adds the bits of a double; -0 counts as 0.
  void add(double value) noexcept { add(std::bit_cast<std::uint64_t>(value + 0.0)); }
  std::uint64_t value() const noexcept { return state_; }

 private:
  std::uint64_t state_ = 0x243f6a8885a308d3u;
};

}  // namespace trephine
