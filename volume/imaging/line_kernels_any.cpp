// LineKernels for any x86-64, as plain loops over the lanes.
#include <bit>

#include "volume/base/cpu.h"
#include "volume/imaging/line_kernels.h"

namespace trephine::volume {

namespace {

struct Lanes {
  struct F {
    float v[8];
  };
  struct I {
    std::int32_t v[8];
  };
  template <class To, class Each>
  static To each(const Each& value) {
    To to;
    for (int i = 0; i < 8; ++i) to.v[i] = value(i);
    return to;
  }
  static std::int32_t to_signed(std::uint32_t v) { return std::bit_cast<std::int32_t>(v); }
  static std::uint32_t to_unsigned(std::int32_t v) { return std::bit_cast<std::uint32_t>(v); }
  static std::int32_t mask(bool is_set) { return is_set ? -1 : 0; }

  static F all(float v) {
    return each<F>([&](int) { return v; });
  }
  static I all(std::int32_t v) {
    return each<I>([&](int) { return v; });
  }
  static I load(const std::int32_t* p) {
    return each<I>([&](int i) { return p[i]; });
  }
  static I load(const std::uint32_t* p) {
    return each<I>([&](int i) { return to_signed(p[i]); });
  }
  static F load(const float* p) {
    return each<F>([&](int i) { return p[i]; });
  }
  static I add(const I& a, const I& b) {
    return each<I>([&](int i) { return to_signed(to_unsigned(a.v[i]) + to_unsigned(b.v[i])); });
  }
  static I sub(const I& a, const I& b) {
    return each<I>([&](int i) { return to_signed(to_unsigned(a.v[i]) - to_unsigned(b.v[i])); });
  }
  static I min(const I& a, const I& b) {
    return each<I>([&](int i) { return a.v[i] < b.v[i] ? a.v[i] : b.v[i]; });
  }
  static I max(const I& a, const I& b) {
    return each<I>([&](int i) { return a.v[i] > b.v[i] ? a.v[i] : b.v[i]; });
  }
  static I times(const I& a, std::int32_t b) {
    return each<I>([&](int i) { return to_signed(to_unsigned(a.v[i]) * to_unsigned(b)); });
  }
  static F add(const F& a, const F& b) {
    return each<F>([&](int i) { return a.v[i] + b.v[i]; });
  }
  static F sub(const F& a, const F& b) {
    return each<F>([&](int i) { return a.v[i] - b.v[i]; });
  }
  static F mul(const F& a, const F& b) {
    return each<F>([&](int i) { return a.v[i] * b.v[i]; });
  }
  static F min(const F& a, const F& b) {
    return each<F>([&](int i) { return a.v[i] < b.v[i] ? a.v[i] : b.v[i]; });
  }
  static F max(const F& a, const F& b) {
    return each<F>([&](int i) { return a.v[i] > b.v[i] ? a.v[i] : b.v[i]; });
  }
  static F real(const I& a) {
    return each<F>([&](int i) { return static_cast<float>(a.v[i]); });
  }
  static I bit_and(const I& a, const I& b) {
    return each<I>([&](int i) { return a.v[i] & b.v[i]; });
  }
  static I bit_or(const I& a, const I& b) {
    return each<I>([&](int i) { return a.v[i] | b.v[i]; });
  }
  static I bit_xor(const I& a, const I& b) {
    return each<I>([&](int i) { return a.v[i] ^ b.v[i]; });
  }
  /// a & ~b.
  static I bit_and_not(const I& a, const I& b) {
    return each<I>([&](int i) { return a.v[i] & ~b.v[i]; });
  }
  static bool any(const I& mask) {
    std::int32_t bits = 0;
    for (const std::int32_t lane : mask.v) bits |= lane;
    return bits != 0;
  }
  static I less(const F& a, const F& b) {
    return each<I>([&](int i) { return mask(a.v[i] < b.v[i]); });
  }
  static F choose(const I& mask, const F& yes, const F& no) {
    return each<F>([&](int i) { return mask.v[i] ? yes.v[i] : no.v[i]; });
  }
  static F keep_where(const I& mask, const F& v) {
    return each<F>([&](int i) { return mask.v[i] ? v.v[i] : 0.0f; });
  }
  /// Mask of the lanes in which an unsigned sum wrapped around 2^32; `part`: either summand.
  static I has_wrapped(const I& sum, const I& part) {
    return each<I>([&](int i) { return mask(to_unsigned(sum.v[i]) < to_unsigned(part.v[i])); });
  }
  /// Distance of a fraction (in 2^-32) to 1, in units of 2^-31.
  static I to_next(const I& fraction) {
    return each<I>([&](int i) { return to_signed((0u - to_unsigned(fraction.v[i])) >> 1); });
  }
  /// Fraction in 2^-32 as a float, 0 to 1.
  static F to_float(const I& fraction) {
    return each<F>(
        [&](int i) { return static_cast<float>(to_signed(to_unsigned(fraction.v[i]) >> 8)) * 0x1p-24f; });
  }
  static I is_above(const I& a, std::int32_t b) {
    return each<I>([&](int i) { return mask(a.v[i] > b); });
  }
  /// Mask of the lanes with 0 <= a < b.
  static I is_below(const I& a, std::int32_t b) {
    return each<I>([&](int i) { return mask(a.v[i] >= 0 && a.v[i] < b); });
  }
  static I gather(const std::int16_t* from, const I& offset) {
    return each<I>([&](int i) { return static_cast<std::int32_t>(from[offset.v[i]]); });
  }
  static I gather_safely(const std::int16_t* from, const I& offset, std::int32_t) {
    return gather(from, offset);
  }
  /// Splits start + k slope into its floor and its fraction in 2^-32.
  static void split(const double* start, const double* slope, double k, I& whole, I& fraction) {
    for (int i = 0; i < 8; ++i) {
      const auto words = std::bit_cast<std::uint64_t>(0x1.8p20 + (start[i] + k * slope[i]));
      fraction.v[i] = to_signed(static_cast<std::uint32_t>(words));
      whole.v[i] = to_signed(static_cast<std::uint32_t>(words >> 32)) - 0x41380000;
    }
  }
  static void add_to(double* sums, const F& v) {
    for (int i = 0; i < 8; ++i) sums[i] += static_cast<double>(v.v[i]);
  }
};

#include "volume/imaging/line_kernels_impl.h"

}  // namespace

const LineKernels k_line_kernels_any{exact, joseph};

const LineKernels& best_line_kernels() noexcept {
  return uses_avx2() ? k_line_kernels_wide : k_line_kernels_any;
}

}  // namespace trephine::volume
