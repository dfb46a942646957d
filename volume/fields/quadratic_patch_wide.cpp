// QuadraticPatch in four lanes, compiled with -mavx2. This file must not call inline functions that other
// files also call, because the linker could choose the AVX2 copy for all callers. The functions do the same
// operations in the same order as quadratic_patch.h, and so give the same bits.
#include <immintrin.h>

namespace trephine::volume {

namespace {

/// Weights of three samples for the value and the derivative at u (quadratic B-splines).
struct Spline {
  double value[3], derivative[3];
};

inline Spline spline_at(double u) noexcept {
  return {{0.5 * (0.5 - u) * (0.5 - u), 0.75 - u * u, 0.5 * (0.5 + u) * (0.5 + u)},
          {u - 0.5, -2 * u, u + 0.5}};
}

inline __m256d sum3(const double w[3], __m256d a, __m256d b, __m256d c) noexcept {
  const __m256d ab =
      _mm256_add_pd(_mm256_mul_pd(_mm256_set1_pd(w[0]), a), _mm256_mul_pd(_mm256_set1_pd(w[1]), b));
  return _mm256_add_pd(ab, _mm256_mul_pd(_mm256_set1_pd(w[2]), c));
}

inline __m256d lanes_of(const double w[3]) noexcept { return _mm256_set_pd(0, w[2], w[1], w[0]); }

/// Returns the sums p0 + p2, p1 + p3 of the products p = a x, followed by the same sums for b y.
inline __m256d two_dots(__m256d a, __m256d x, __m256d b, __m256d y) noexcept {
  const __m256d p = _mm256_mul_pd(a, x), q = _mm256_mul_pd(b, y);
  return _mm256_add_pd(_mm256_permute2f128_pd(p, q, 0x20), _mm256_permute2f128_pd(p, q, 0x31));
}

/// Stores a0 + a1, a2 + a3, b0 + b1, b2 + b3.
inline void store_four(double* out, __m256d a, __m256d b) noexcept {
  const __m256d sums = _mm256_hadd_pd(a, b);  // a0 + a1, b0 + b1, a2 + a3, b2 + b3
  _mm256_storeu_pd(out, _mm256_permute4x64_pd(sums, _MM_SHUFFLE(3, 1, 2, 0)));
}

inline __m256d second_difference(__m256d a, __m256d b, __m256d c) noexcept {
  return _mm256_add_pd(_mm256_sub_pd(_mm256_sub_pd(a, b), b), c);
}

inline __m256d magnitude(__m256d a) noexcept { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a); }

/// Differences b - a, c - b of a row a, b, c in the first two lanes.
inline __m256d step(__m256d row) noexcept {
  return _mm256_sub_pd(_mm256_permute4x64_pd(row, _MM_SHUFFLE(3, 3, 2, 1)), row);
}

inline double larger(double a, double b) noexcept { return a < b ? b : a; }

}  // namespace

/// `rows`: nine rows of four doubles, [z][y]; `out`: value, gradient.
void value_and_gradient_of_patch_wide(const double* rows, const double p[3], double out[4]) noexcept {
  const Spline x = spline_at(p[0]), y = spline_at(p[1]), z = spline_at(p[2]);
  __m256d value_z[3], slope_z[3];
  for (int j = 0; j < 3; ++j) {
    const __m256d a = _mm256_loadu_pd(rows + 4 * j), b = _mm256_loadu_pd(rows + 4 * (3 + j)),
                  c = _mm256_loadu_pd(rows + 4 * (6 + j));
    value_z[j] = sum3(z.value, a, b, c);
    slope_z[j] = sum3(z.derivative, a, b, c);
  }
  const __m256d c = sum3(y.value, value_z[0], value_z[1], value_z[2]),
                cy = sum3(y.derivative, value_z[0], value_z[1], value_z[2]),
                cz = sum3(y.value, slope_z[0], slope_z[1], slope_z[2]);
  const __m256d x_value = lanes_of(x.value), x_slope = lanes_of(x.derivative);
  store_four(out, two_dots(c, x_value, c, x_slope), two_dots(cy, x_value, cz, x_value));
}

/// `out`: value, gradient, hessian_diagonal, hessian_mixed.
void jet_of_patch_wide(const double* rows, const double p[3], double out[10]) noexcept {
  const Spline x = spline_at(p[0]), y = spline_at(p[1]), z = spline_at(p[2]);
  __m256d value_z[3], slope_z[3], curve_z[3];
  for (int j = 0; j < 3; ++j) {
    const __m256d a = _mm256_loadu_pd(rows + 4 * j), b = _mm256_loadu_pd(rows + 4 * (3 + j)),
                  c = _mm256_loadu_pd(rows + 4 * (6 + j));
    value_z[j] = sum3(z.value, a, b, c);
    slope_z[j] = sum3(z.derivative, a, b, c);
    curve_z[j] = second_difference(a, b, c);
  }
  const __m256d c = sum3(y.value, value_z[0], value_z[1], value_z[2]),
                cy = sum3(y.derivative, value_z[0], value_z[1], value_z[2]),
                cz = sum3(y.value, slope_z[0], slope_z[1], slope_z[2]),
                cyz = sum3(y.derivative, slope_z[0], slope_z[1], slope_z[2]),
                cyy = second_difference(value_z[0], value_z[1], value_z[2]),
                czz = sum3(y.value, curve_z[0], curve_z[1], curve_z[2]);
  const __m256d x_value = lanes_of(x.value), x_slope = lanes_of(x.derivative),
                x_curve = _mm256_set_pd(0, 1, -2, 1);
  double mixed[4];
  store_four(out, two_dots(c, x_value, c, x_slope), two_dots(cy, x_value, cz, x_value));
  store_four(out + 4, two_dots(c, x_curve, cyy, x_value), two_dots(czz, x_value, cyz, x_value));
  store_four(mixed, two_dots(cz, x_slope, cy, x_slope), _mm256_setzero_pd());
  out[8] = mixed[0], out[9] = mixed[1];
}

/// `out`: pure, cross.
void hessian_bound_of_patch_wide(const double* rows, double out[6]) noexcept {
  __m256d r[3][3];
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) r[k][j] = _mm256_loadu_pd(rows + 4 * (3 * k + j));
  __m256d yy = _mm256_setzero_pd(), zz = yy, yz = yy, xy = yy, xz = yy;
  double xx = 0;
  for (int k = 0; k < 3; ++k) {
    yy = _mm256_max_pd(yy, magnitude(second_difference(r[k][0], r[k][1], r[k][2])));
    zz = _mm256_max_pd(zz, magnitude(second_difference(r[0][k], r[1][k], r[2][k])));
    for (int j = 0; j < 3; ++j) {
      const __m128d s = _mm256_castpd256_pd128(step(r[k][j]));
      const __m128d second = _mm_andnot_pd(_mm_set1_pd(-0.0), _mm_sub_sd(_mm_unpackhi_pd(s, s), s));
      xx = larger(xx, _mm_cvtsd_f64(second));
    }
    for (int j = 0; j < 2; ++j) {
      xy = _mm256_max_pd(xy, magnitude(step(_mm256_sub_pd(r[k][j + 1], r[k][j]))));
      xz = _mm256_max_pd(xz, magnitude(step(_mm256_sub_pd(r[j + 1][k], r[j][k]))));
    }
  }
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      yz = _mm256_max_pd(
          yz, magnitude(_mm256_add_pd(_mm256_sub_pd(_mm256_sub_pd(r[k + 1][j + 1], r[k + 1][j]), r[k][j + 1]),
                                      r[k][j])));
  alignas(32) double a[4], b[4], c[4], d[4], e[4];
  _mm256_store_pd(a, yy), _mm256_store_pd(b, zz), _mm256_store_pd(c, yz), _mm256_store_pd(d, xz),
      _mm256_store_pd(e, xy);
  out[0] = xx;
  out[1] = larger(larger(a[0], a[1]), a[2]);
  out[2] = larger(larger(b[0], b[1]), b[2]);
  out[3] = larger(larger(c[0], c[1]), c[2]);
  out[4] = larger(d[0], d[1]);
  out[5] = larger(e[0], e[1]);
}

}  // namespace trephine::volume
