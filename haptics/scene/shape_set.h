// ShapeSet: a set of items of a scene, such as its shapes.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace trephine::haptics {

/// Set of indices from 0 to k_max - 1. Plain data of 16 bytes.
class ShapeSet {
 public:
  static constexpr int k_max = 128;

  constexpr bool contains(int s) const noexcept { return words_[word(s)] >> (s & 63) & 1u; }
  constexpr void flip(int s) noexcept { words_[word(s)] ^= std::uint64_t{1} << (s & 63); }
  constexpr void set(int s, bool is_in) noexcept {
    if (contains(s) != is_in) flip(s);
  }
  constexpr bool is_empty() const noexcept { return (words_[0] | words_[1]) == 0; }
  friend constexpr ShapeSet operator|(ShapeSet a, const ShapeSet& b) noexcept {
    a.words_[0] |= b.words_[0], a.words_[1] |= b.words_[1];
    return a;
  }
  /// Returns the smallest member that is at least `s`; k_max if there is no such member.
  constexpr int next(int s) const noexcept {
    for (std::size_t w = word(s); s < k_max; s = static_cast<int>(64 * ++w))
      if (const std::uint64_t rest = words_[w] >> (s & 63); rest != 0) return s + std::countr_zero(rest);
    return k_max;
  }
  friend constexpr bool operator==(const ShapeSet&, const ShapeSet&) = default;

 private:
  static constexpr std::size_t word(int s) noexcept { return static_cast<std::size_t>(s) >> 6; }
  std::array<std::uint64_t, 2> words_{};
};

}  // namespace trephine::haptics
