// SSE2 variant of RemovalKernels, for any x86-64 CPU.
#include <emmintrin.h>

#include "volume/base/cpu.h"
#include "volume/cuts/removal_kernels.h"

namespace trephine::volume {

namespace {

struct Lanes {
  using V = __m128;
  static constexpr int k_count = 4;
  static V all(float v) { return _mm_set1_ps(v); }
  static V counting(int first) {
    return _mm_add_ps(_mm_setr_ps(0, 1, 2, 3), _mm_set1_ps(static_cast<float>(first)));
  }
  static V load(const float* p) { return _mm_loadu_ps(p); }
  static void store(float* p, V v) { _mm_storeu_ps(p, v); }
  static V add(V a, V b) { return _mm_add_ps(a, b); }
  static V sub(V a, V b) { return _mm_sub_ps(a, b); }
  static V mul(V a, V b) { return _mm_mul_ps(a, b); }
  static V min(V a, V b) { return _mm_min_ps(a, b); }
  static V max(V a, V b) { return _mm_max_ps(a, b); }
  static V root(V a) { return _mm_sqrt_ps(a); }
  static V divide(V a, V b) { return _mm_div_ps(a, b); }
  static V magnitude(V a) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), a); }
  /// Selects `yes` in lanes with a > 0, else `no`.
  static V where_positive(V a, V yes, V no) {
    const V chosen = _mm_cmplt_ps(_mm_setzero_ps(), a);
    return _mm_or_ps(_mm_and_ps(chosen, yes), _mm_andnot_ps(chosen, no));
  }
  static unsigned less(V a, V b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmplt_ps(a, b))); }
  static unsigned less_equal(V a, V b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(a, b))); }
};

#include "volume/cuts/removal_kernels_impl.h"

}  // namespace

const RemovalKernels k_removal_kernels_4{sweep_brick, sample, stamp_brick, sample_stamps};

const RemovalKernels& best_removal_kernels() noexcept {
  return uses_avx2() ? k_removal_kernels_8 : k_removal_kernels_4;
}

}  // namespace trephine::volume
