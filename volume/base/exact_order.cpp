#include "volume/base/exact_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace trephine {

namespace {

__extension__ typedef __int128 Int128;

/// A double as sign * mantissa * 2^exponent, with an odd mantissa or 0. Decoded from the bits, so that a CPU
/// mode that flushes denormals to 0 has no effect.
struct Parts {
  std::uint64_t mantissa;
  int exponent;
  bool is_negative;
  explicit Parts(double value) noexcept {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const int biased = static_cast<int>(bits >> 52 & 0x7ff);
    mantissa = bits & ((1ull << 52) - 1);
    if (biased > 0) mantissa |= 1ull << 52;
    exponent = std::max(biased, 1) - 1075;
    is_negative = bits >> 63;
    if (mantissa != 0) {
      const int zeros = std::countr_zero(mantissa);
      mantissa >>= zeros;
      exponent += zeros;
    }
  }
  /// Returns the smallest exponent of a power of two above |value|.
  int top() const noexcept { return exponent + static_cast<int>(std::bit_width(mantissa)); }
};

/// Fixed-size integer in two's complement: coordinates in units of 2^-1074, products in units of 2^-2148.
template <int Words>
struct Wide {
  std::array<std::uint64_t, Words> word{};

  static Wide from(const Parts& p) noexcept {
    Wide w;
    if (p.mantissa == 0) return w;
    const int shift = p.exponent + 1074;
    const auto at = static_cast<std::size_t>(shift / 64);
    const int bit = shift % 64;
    w.word[at] = p.mantissa << bit;
    if (bit > 0 && at + 1 < Words) w.word[at + 1] = p.mantissa >> (64 - bit);
    return p.is_negative ? w.negated() : w;
  }
  bool is_negative() const noexcept { return word.back() >> 63; }
  bool is_zero() const noexcept {
    for (const std::uint64_t w : word)
      if (w != 0) return false;
    return true;
  }
  Wide negated() const noexcept {
    Wide r;
    std::uint64_t carry = 1;
    for (std::size_t i = 0; i < Words; ++i) {
      r.word[i] = ~word[i] + carry;
      carry = carry != 0 && r.word[i] == 0 ? 1 : 0;
    }
    return r;
  }
  friend Wide operator-(const Wide& a, const Wide& b) noexcept {
    Wide r;
    std::uint64_t borrow = 0;
    for (std::size_t i = 0; i < Words; ++i) {
      const std::uint64_t d = a.word[i] - b.word[i];
      r.word[i] = d - borrow;
      borrow = (a.word[i] < b.word[i] || d < borrow) ? 1 : 0;
    }
    return r;
  }
};

constexpr int k_words = 18;  // 31 + 1074 bits, a sign bit, and one carry bit for a difference
using Coordinate = Wide<k_words>;
using Product = Wide<2 * k_words>;

Product multiply(const Coordinate& a, const Coordinate& b) noexcept {
  const bool is_negative = a.is_negative() != b.is_negative();
  const Coordinate u = a.is_negative() ? a.negated() : a, v = b.is_negative() ? b.negated() : b;
  Product r;
  for (std::size_t i = 0; i < k_words; ++i) {
    if (u.word[i] == 0) continue;
    std::uint64_t carry = 0;
    for (std::size_t j = 0; j < k_words; ++j) {
      __extension__ typedef unsigned __int128 UInt128;
      const UInt128 t = static_cast<UInt128>(u.word[i]) * v.word[j] + r.word[i + j] + carry;
      r.word[i + j] = static_cast<std::uint64_t>(t);
      carry = static_cast<std::uint64_t>(t >> 64);
    }
    r.word[i + k_words] = carry;
  }
  return is_negative ? r.negated() : r;
}

}  // namespace

int compare_crossings_exactly(double a0, double a1, double h_a, double b0, double b1, double h_b) noexcept {
  const std::array<Parts, 6> p{Parts(a0), Parts(a1), Parts(h_a), Parts(b0), Parts(b1), Parts(h_b)};
  int low = 0, high = 0;
  bool is_first = true;
  for (const Parts& x : p) {
    if (x.mantissa == 0) continue;
    low = is_first ? x.exponent : std::min(low, x.exponent);
    high = is_first ? x.top() : std::max(high, x.top());
    is_first = false;
  }

  // Multiplication by both denominators gives the result without a division:
  // sign((h_a - a0)(b1 - b0) - (h_b - b0)(a1 - a0)) sign(a1 - a0) sign(b1 - b0).
  // Numbers whose bits span at most 60 places fit in 128-bit integers; others use Wide.
  int sign = 0;
  if (high - low <= 60) {
    const auto whole = [low](const Parts& x) {
      const Int128 magnitude = x.mantissa == 0 ? 0 : static_cast<Int128>(x.mantissa) << (x.exponent - low);
      return x.is_negative ? -magnitude : magnitude;
    };
    const Int128 left = (whole(p[2]) - whole(p[0])) * (whole(p[4]) - whole(p[3]));
    const Int128 right = (whole(p[5]) - whole(p[3])) * (whole(p[1]) - whole(p[0]));
    sign = left < right ? -1 : left > right ? 1 : 0;
  } else {
    const auto wide = [](const Parts& x) { return Coordinate::from(x); };
    const Product left = multiply(wide(p[2]) - wide(p[0]), wide(p[4]) - wide(p[3]));
    const Product right = multiply(wide(p[5]) - wide(p[3]), wide(p[1]) - wide(p[0]));
    const Product difference = left - right;
    sign = difference.is_zero() ? 0 : difference.is_negative() ? -1 : 1;
  }
  if ((a1 < a0) != (b1 < b0)) sign = -sign;
  return sign;
}

}  // namespace trephine
