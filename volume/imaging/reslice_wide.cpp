// Wide variant of reslicing, compiled with -mavx2: must not call inline code shared with other files.
#include <immintrin.h>

#include "volume/imaging/reslice.h"

namespace trephine::volume {

namespace {

__m256 between(__m256 a, __m256 b, __m256 share) {
  return _mm256_add_ps(a, _mm256_mul_ps(share, _mm256_sub_ps(b, a)));
}

/// Calls put(i, values) for each group of eight pixels.
template <bool is_of_sheet, class Put>
void sample_row(const ResliceRow& row, int count, const Put& put) {
  const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7),
                low_bits = _mm256_set1_epi32((1 << 20) - 1);
  const __m256 unit = _mm256_set1_ps(0x1p-20f);
  __m256i at[3], step[3];
  for (int a = 0; a < 3; ++a) {
    at[a] = _mm256_add_epi32(_mm256_set1_epi32(row.at[a]),
                             _mm256_mullo_epi32(lanes, _mm256_set1_epi32(row.step[a])));
    step[a] = _mm256_set1_epi32(8 * row.step[a]);
  }
  const __m256i stride_y = _mm256_set1_epi32(row.stride_y), stride_z = _mm256_set1_epi32(row.stride_z);
  const int* pairs = reinterpret_cast<const int*>(row.voxels);
  for (int i = 0; i < count; i += 8) {
    __m256 share[3];
    for (int a = 0; a < 3; ++a)
      share[a] = _mm256_mul_ps(_mm256_cvtepi32_ps(_mm256_and_si256(at[a], low_bits)), unit);
    __m256i offset = _mm256_add_epi32(_mm256_mullo_epi32(_mm256_srli_epi32(at[1], 20), stride_y),
                                      _mm256_mullo_epi32(_mm256_srli_epi32(at[2], 20), stride_z));
    if constexpr (!is_of_sheet) offset = _mm256_add_epi32(offset, _mm256_srli_epi32(at[0], 20));
    const auto along_x = [&](__m256i from) {
      if constexpr (is_of_sheet) return _mm256_i32gather_ps(row.sheet, from, 4);
      const __m256i pair = _mm256_i32gather_epi32(pairs, from, 2);
      return between(_mm256_cvtepi32_ps(_mm256_srai_epi32(_mm256_slli_epi32(pair, 16), 16)),
                     _mm256_cvtepi32_ps(_mm256_srai_epi32(pair, 16)), share[0]);
    };
    const __m256i next_z = _mm256_add_epi32(offset, stride_z);
    const __m256 near = between(along_x(offset), along_x(_mm256_add_epi32(offset, stride_y)), share[1]);
    const __m256 far = between(along_x(next_z), along_x(_mm256_add_epi32(next_z, stride_y)), share[1]);
    put(i, between(near, far, share[2]));
    for (int a = 0; a < 3; ++a) at[a] = _mm256_add_epi32(at[a], step[a]);
  }
}

template <class Put>
void sample(const ResliceRow& row, int count, const Put& put) {
  if (row.sheet != nullptr)
    sample_row<true>(row, count, put);
  else
    sample_row<false>(row, count, put);
}

}  // namespace

void reslice_row_wide(const ResliceRow& row, int count, float* values) {
  sample(row, count, [values](int i, __m256 v) { _mm256_storeu_ps(values + i, v); });
}

void reslice_row_wide(const ResliceRow& row, int count, std::int16_t* pixels) {
  const __m256 half = _mm256_set1_ps(0.5f);
  sample(row, count, [pixels, half](int i, __m256 v) {
    const __m256i whole = _mm256_cvttps_epi32(_mm256_floor_ps(_mm256_add_ps(v, half)));
    const __m128i packed = _mm_packs_epi32(_mm256_castsi256_si128(whole), _mm256_extracti128_si256(whole, 1));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(pixels + i), packed);
  });
}

}  // namespace trephine::volume
