// AVX2 variant of RemovalKernels, compiled with -mavx2. It must not call inline functions that other files
// also call, because the linker could choose the AVX2 copy for all callers.
#include <immintrin.h>

#include "volume/cuts/removal_kernels.h"

namespace trephine::volume {

namespace {

struct Lanes {
  using V = __m256;
  static constexpr int k_count = 8;
  static V all(float v) { return _mm256_set1_ps(v); }
  static V counting(int first) {
    return _mm256_add_ps(_mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7), _mm256_set1_ps(static_cast<float>(first)));
  }
  static V load(const float* p) { return _mm256_loadu_ps(p); }
  static void store(float* p, V v) { _mm256_storeu_ps(p, v); }
  static V add(V a, V b) { return _mm256_add_ps(a, b); }
  static V sub(V a, V b) { return _mm256_sub_ps(a, b); }
  static V mul(V a, V b) { return _mm256_mul_ps(a, b); }
  static V min(V a, V b) { return _mm256_min_ps(a, b); }
  static V max(V a, V b) { return _mm256_max_ps(a, b); }
  static V root(V a) { return _mm256_sqrt_ps(a); }
  static V divide(V a, V b) { return _mm256_div_ps(a, b); }
  static V magnitude(V a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a); }
  /// Selects `yes` in lanes with a > 0, else `no`.
  static V where_positive(V a, V yes, V no) {
    const V chosen = _mm256_cmp_ps(_mm256_setzero_ps(), a, _CMP_LT_OQ);
    return _mm256_or_ps(_mm256_and_ps(chosen, yes), _mm256_andnot_ps(chosen, no));
  }
  static unsigned less(V a, V b) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ)));
  }
  static unsigned less_equal(V a, V b) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LE_OQ)));
  }
};

#include "volume/cuts/removal_kernels_impl.h"

}  // namespace

const RemovalKernels k_removal_kernels_8{sweep_brick, sample, stamp_brick, sample_stamps};

}  // namespace trephine::volume
