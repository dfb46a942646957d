// LineKernels for AVX2, compiled with -mavx2: must not call inline code shared with other files.
#include <immintrin.h>

#include "volume/imaging/line_kernels.h"

namespace trephine::volume {

namespace {

struct Lanes {
  using F = __m256;
  using I = __m256i;
  static F all(float v) { return _mm256_set1_ps(v); }
  static I all(std::int32_t v) { return _mm256_set1_epi32(v); }
  static I load(const std::int32_t* p) { return _mm256_load_si256(reinterpret_cast<const __m256i*>(p)); }
  static I load(const std::uint32_t* p) { return _mm256_load_si256(reinterpret_cast<const __m256i*>(p)); }
  static F load(const float* p) { return _mm256_load_ps(p); }
  static I add(I a, I b) { return _mm256_add_epi32(a, b); }
  static I sub(I a, I b) { return _mm256_sub_epi32(a, b); }
  static I min(I a, I b) { return _mm256_min_epi32(a, b); }
  static I max(I a, I b) { return _mm256_max_epi32(a, b); }
  static I times(I a, std::int32_t b) { return b == 1 ? a : _mm256_mullo_epi32(a, _mm256_set1_epi32(b)); }
  static F add(F a, F b) { return _mm256_add_ps(a, b); }
  static F sub(F a, F b) { return _mm256_sub_ps(a, b); }
  static F mul(F a, F b) { return _mm256_mul_ps(a, b); }
  static F min(F a, F b) { return _mm256_min_ps(a, b); }
  static F max(F a, F b) { return _mm256_max_ps(a, b); }
  static F real(I a) { return _mm256_cvtepi32_ps(a); }
  static I bit_and(I a, I b) { return _mm256_and_si256(a, b); }
  static I bit_or(I a, I b) { return _mm256_or_si256(a, b); }
  static I bit_xor(I a, I b) { return _mm256_xor_si256(a, b); }
  /// a & ~b.
  static I bit_and_not(I a, I b) { return _mm256_andnot_si256(b, a); }
  static bool any(I mask) { return !_mm256_testz_si256(mask, mask); }
  static I less(F a, F b) { return _mm256_castps_si256(_mm256_cmp_ps(a, b, _CMP_LT_OQ)); }
  static F choose(I mask, F yes, F no) { return _mm256_blendv_ps(no, yes, _mm256_castsi256_ps(mask)); }
  static F keep_where(I mask, F v) { return _mm256_and_ps(_mm256_castsi256_ps(mask), v); }
  /// Mask of the lanes in which an unsigned sum wrapped around 2^32; `part`: either summand.
  static I has_wrapped(I sum, I part) {
    const I low = _mm256_set1_epi32(static_cast<int>(0x80000000u));
    return _mm256_cmpgt_epi32(_mm256_xor_si256(part, low), _mm256_xor_si256(sum, low));
  }
  /// Distance of a fraction (in 2^-32) to 1, in units of 2^-31.
  static I to_next(I fraction) {
    return _mm256_srli_epi32(_mm256_sub_epi32(_mm256_setzero_si256(), fraction), 1);
  }
  /// Fraction in 2^-32 as a float, 0 to 1.
  static F to_float(I fraction) {
    return _mm256_mul_ps(_mm256_cvtepi32_ps(_mm256_srli_epi32(fraction, 8)), _mm256_set1_ps(0x1p-24f));
  }
  static I is_above(I a, std::int32_t b) { return _mm256_cmpgt_epi32(a, _mm256_set1_epi32(b)); }
  /// Mask of the lanes with 0 <= a < b.
  static I is_below(I a, std::int32_t b) {
    return _mm256_andnot_si256(_mm256_cmpgt_epi32(_mm256_setzero_si256(), a),
                               _mm256_cmpgt_epi32(_mm256_set1_epi32(b), a));
  }
  static I gather(const std::int16_t* from, I offset) {
    const I pair = _mm256_i32gather_epi32(reinterpret_cast<const int*>(from), offset, 2);
    return _mm256_srai_epi32(_mm256_slli_epi32(pair, 16), 16);
  }
  /// Variant that never reads beyond offset `last`.
  static I gather_safely(const std::int16_t* from, I offset, std::int32_t last) {
    const I safe = _mm256_min_epi32(offset, _mm256_set1_epi32(last - 1));
    const I pair = _mm256_i32gather_epi32(reinterpret_cast<const int*>(from), safe, 2);
    const I shift = _mm256_and_si256(_mm256_cmpeq_epi32(safe, offset), _mm256_set1_epi32(16));
    return _mm256_srai_epi32(_mm256_sllv_epi32(pair, shift), 16);
  }
  /// Splits start + k slope into its floor and its fraction in 2^-32.
  static void split(const double* start, const double* slope, double k, I& whole, I& fraction) {
    const __m256d magic = _mm256_set1_pd(0x1.8p20), plane = _mm256_set1_pd(k);
    const auto words = [&](int i) {
      return _mm256_castpd_ps(_mm256_add_pd(
          magic,
          _mm256_add_pd(_mm256_loadu_pd(start + i), _mm256_mul_pd(plane, _mm256_loadu_pd(slope + i)))));
    };
    const __m256 low = words(0), high = words(4);
    const auto in_order = [](__m256 v) {
      return _mm256_permute4x64_epi64(_mm256_castps_si256(v), _MM_SHUFFLE(3, 1, 2, 0));
    };
    fraction = in_order(_mm256_shuffle_ps(low, high, _MM_SHUFFLE(2, 0, 2, 0)));
    whole = _mm256_sub_epi32(in_order(_mm256_shuffle_ps(low, high, _MM_SHUFFLE(3, 1, 3, 1))),
                             _mm256_set1_epi32(0x41380000));
  }
  static void add_to(double* sums, F v) {
    _mm256_storeu_pd(sums, _mm256_add_pd(_mm256_loadu_pd(sums), _mm256_cvtps_pd(_mm256_castps256_ps128(v))));
    _mm256_storeu_pd(sums + 4,
                     _mm256_add_pd(_mm256_loadu_pd(sums + 4), _mm256_cvtps_pd(_mm256_extractf128_ps(v, 1))));
  }
};

#include "volume/imaging/line_kernels_impl.h"

}  // namespace

const LineKernels k_line_kernels_wide{exact, joseph};

}  // namespace trephine::volume
