// QuadraticPatch: smooth reconstruction of a field by tensor-product quadratic B-splines over 3 x 3 x 3
// voxels, one polynomial per voxel cube, with continuous value and gradient (Unser 1999, eq. 6). Weights are
// not negative and sum to 1, so that a value is between those of its samples, and is air if all samples are
// air.
#pragma once

#include <algorithm>
#include <cmath>
#include <emmintrin.h>
#include <glm/vec3.hpp>

#include "volume/cuts/version.h"
#include "volume/scan/field.h"

namespace trephine::volume {

/// Value and first derivatives, per voxel step.
struct ValueAndGradient {
  double value;
  glm::dvec3 gradient;
};

/// Value, first and second derivatives, per voxel step.
struct Jet : ValueAndGradient {
  glm::dvec3 hessian_diagonal;  ///< xx, yy, zz
  glm::dvec3 hessian_mixed;     ///< yz, xz, xy
  /// Returns the matrix of second derivatives times v.
  glm::dvec3 hessian_times(const glm::dvec3& v) const noexcept {
    return {hessian_diagonal.x * v.x + hessian_mixed.z * v.y + hessian_mixed.y * v.z,
            hessian_mixed.z * v.x + hessian_diagonal.y * v.y + hessian_mixed.x * v.z,
            hessian_mixed.y * v.x + hessian_mixed.x * v.y + hessian_diagonal.z * v.z};
  }
};

/// Converts derivatives per step to derivatives per `k` steps along each axis.
inline void rescale(ValueAndGradient& s, const glm::dvec3& k) noexcept { s.gradient *= k; }
inline void rescale(Jet& j, const glm::dvec3& k) noexcept {
  j.gradient *= k;
  j.hessian_diagonal *= k * k;
  j.hessian_mixed *= glm::dvec3(k.y * k.z, k.x * k.z, k.x * k.y);
}

/// True if the wide functions are used (see uses_avx2()), which give the same bits as the narrow functions.
/// `rows`: QuadraticPatch::samples(); `out`: see quadratic_patch_wide.cpp.
extern const bool k_has_wide_patches;
void value_and_gradient_of_patch_wide(const double* rows, const double p[3], double out[4]) noexcept;
void jet_of_patch_wide(const double* rows, const double p[3], double out[10]) noexcept;
void hessian_bound_of_patch_wide(const double* rows, double out[6]) noexcept;

/// Polynomial of one voxel's cube. Plain data of 288 bytes. Queries take points relative to the voxel's
/// centre, each coordinate in [-0.5, 0.5] up to rounding, allocate nothing and cost 10 - 25 ns.
class QuadraticPatch {
 public:
  /// Loads a shape's field around voxel v, which may be outside the grid.
  void load(const Field& field, const glm::ivec3& v) noexcept;
  /// Loads the distance (mm) to removed matter around sample s of the version's lattice. Derivatives are per
  /// lattice step.
  void load_distance(const Version& version, const glm::ivec3& s) noexcept;

  /// Sets one row along x of the 27 samples; y, z: 0 to 2.
  void set_row(int y, int z, double a, double b, double c) noexcept { rows_[z][y] = Lanes(a, b, c); }

  ValueAndGradient value_and_gradient(const glm::dvec3& p) const noexcept {
    if (k_has_wide_patches) {
      double out[4];
      value_and_gradient_of_patch_wide(samples(), &p.x, out);
      return {out[0], {out[1], out[2], out[3]}};
    }
    return narrow_value_and_gradient(p);
  }
  /// Variant without AVX2.
  ValueAndGradient narrow_value_and_gradient(const glm::dvec3& p) const noexcept {
    const Weights y(p.y), z(p.z);
    Lanes value_z[3], slope_z[3];
    for (int j = 0; j < 3; ++j) {
      value_z[j] = z.value[0] * rows_[0][j] + z.value[1] * rows_[1][j] + z.value[2] * rows_[2][j];
      slope_z[j] =
          z.derivative[0] * rows_[0][j] + z.derivative[1] * rows_[1][j] + z.derivative[2] * rows_[2][j];
    }
    const Lanes c = y.value[0] * value_z[0] + y.value[1] * value_z[1] + y.value[2] * value_z[2];
    const Lanes cy =
        y.derivative[0] * value_z[0] + y.derivative[1] * value_z[1] + y.derivative[2] * value_z[2];
    const Lanes cz = y.value[0] * slope_z[0] + y.value[1] * slope_z[1] + y.value[2] * slope_z[2];
    const Weights w(p.x);
    const Lanes x(w.value), dx(w.derivative);
    return {dot(c, x), {dot(c, dx), dot(cy, x), dot(cz, x)}};
  }

  Jet jet(const glm::dvec3& p) const noexcept {
    if (k_has_wide_patches) {
      double out[10];
      jet_of_patch_wide(samples(), &p.x, out);
      return {{out[0], {out[1], out[2], out[3]}}, {out[4], out[5], out[6]}, {out[7], out[8], out[9]}};
    }
    return narrow_jet(p);
  }
  /// Variant without AVX2.
  Jet narrow_jet(const glm::dvec3& p) const noexcept {
    const Weights y(p.y), z(p.z);
    Lanes value_z[3], slope_z[3], curve_z[3];
    for (int j = 0; j < 3; ++j) {
      value_z[j] = z.value[0] * rows_[0][j] + z.value[1] * rows_[1][j] + z.value[2] * rows_[2][j];
      slope_z[j] =
          z.derivative[0] * rows_[0][j] + z.derivative[1] * rows_[1][j] + z.derivative[2] * rows_[2][j];
      curve_z[j] = rows_[0][j] - rows_[1][j] - rows_[1][j] + rows_[2][j];
    }
    const Lanes c = y.value[0] * value_z[0] + y.value[1] * value_z[1] + y.value[2] * value_z[2];
    const Lanes cy =
        y.derivative[0] * value_z[0] + y.derivative[1] * value_z[1] + y.derivative[2] * value_z[2];
    const Lanes cz = y.value[0] * slope_z[0] + y.value[1] * slope_z[1] + y.value[2] * slope_z[2];
    const Lanes cyz =
        y.derivative[0] * slope_z[0] + y.derivative[1] * slope_z[1] + y.derivative[2] * slope_z[2];
    const Lanes cyy = value_z[0] - value_z[1] - value_z[1] + value_z[2];
    const Lanes czz = y.value[0] * curve_z[0] + y.value[1] * curve_z[1] + y.value[2] * curve_z[2];
    const Weights w(p.x);
    const Lanes x(w.value), dx(w.derivative), dxx(1, -2, 1);
    Jet jet;
    jet.value = dot(c, x);
    jet.gradient = {dot(c, dx), dot(cy, x), dot(cz, x)};
    jet.hessian_diagonal = {dot(c, dxx), dot(cyy, x), dot(czz, x)};
    jet.hessian_mixed = {dot(cyz, x), dot(cz, dx), dot(cy, dx)};
    return jet;
  }

  /// Bounds of |second derivative| over the cube: pure = max |xx|, |yy|, |zz|, cross = max |yz|, |xz|, |xy|.
  /// Each second derivative is a mean, with positive weights, of second differences of the samples.
  struct HessianBound {
    glm::dvec3 pure, cross;
    /// Bounds |v . (second derivatives) v|.
    double along(const glm::dvec3& v) const noexcept {
      return pure.x * v.x * v.x + pure.y * v.y * v.y + pure.z * v.z * v.z +
             2 * (cross.x * std::abs(v.y * v.z) + cross.y * std::abs(v.x * v.z) +
                  cross.z * std::abs(v.x * v.y));
    }
  };
  HessianBound hessian_bound() const noexcept;
  HessianBound narrow_hessian_bound() const noexcept;  ///< variant without AVX2
  friend void rescale(HessianBound& b, const glm::dvec3& k) noexcept {
    b.pure *= k * k;
    b.cross *= glm::dvec3(k.y * k.z, k.x * k.z, k.x * k.y);
  }

  /// Bounds of the values in the cube.
  double minimum() const noexcept;
  double maximum() const noexcept;

 private:
  /// Three samples along x, and a fourth lane without weight.
  struct Lanes {
    __m128d low, high;
    Lanes() = default;
    Lanes(__m128d l, __m128d h) noexcept : low(l), high(h) {}
    Lanes(double a, double b, double c) noexcept : low(_mm_set_pd(b, a)), high(_mm_set_sd(c)) {}
    explicit Lanes(const double* v) noexcept : Lanes(v[0], v[1], v[2]) {}
    friend Lanes operator+(const Lanes& a, const Lanes& b) noexcept {
      return {_mm_add_pd(a.low, b.low), _mm_add_pd(a.high, b.high)};
    }
    friend Lanes operator-(const Lanes& a, const Lanes& b) noexcept {
      return {_mm_sub_pd(a.low, b.low), _mm_sub_pd(a.high, b.high)};
    }
    friend Lanes operator*(double s, const Lanes& a) noexcept {
      const __m128d factor = _mm_set1_pd(s);
      return {_mm_mul_pd(factor, a.low), _mm_mul_pd(factor, a.high)};
    }
    friend double dot(const Lanes& a, const Lanes& b) noexcept {
      const __m128d sum = _mm_add_pd(_mm_mul_pd(a.low, b.low), _mm_mul_pd(a.high, b.high));
      return _mm_cvtsd_f64(_mm_add_sd(sum, _mm_unpackhi_pd(sum, sum)));
    }
    friend Lanes larger(const Lanes& a, const Lanes& b) noexcept {
      return {_mm_max_pd(a.low, b.low), _mm_max_pd(a.high, b.high)};
    }
    friend Lanes smaller(const Lanes& a, const Lanes& b) noexcept {
      return {_mm_min_pd(a.low, b.low), _mm_min_pd(a.high, b.high)};
    }
    friend Lanes magnitude(const Lanes& a) noexcept {
      const __m128d sign = _mm_set1_pd(-0.0);
      return {_mm_andnot_pd(sign, a.low), _mm_andnot_pd(sign, a.high)};
    }
    double first() const noexcept { return _mm_cvtsd_f64(low); }
    double second() const noexcept { return _mm_cvtsd_f64(_mm_unpackhi_pd(low, low)); }
    double third() const noexcept { return _mm_cvtsd_f64(high); }
    double max3() const noexcept { return std::max(std::max(first(), second()), third()); }
    /// Differences of neighbours in the first two lanes; the others are 0.
    Lanes step() const noexcept { return {_mm_sub_pd(_mm_shuffle_pd(low, high, 1), low), _mm_setzero_pd()}; }
  };
  struct Weights {
    double value[3], derivative[3];
    explicit Weights(double u) noexcept
        : value{0.5 * (0.5 - u) * (0.5 - u), 0.75 - u * u, 0.5 * (0.5 + u) * (0.5 + u)},
          derivative{u - 0.5, -2 * u, u + 0.5} {}
  };

  /// Returns nine rows of four doubles, [z][y]; the fourth double of a row is arbitrary.
  const double* samples() const noexcept { return reinterpret_cast<const double*>(&rows_[0][0]); }

  Lanes rows_[3][3];  ///< [z][y], along x; the fourth lane is arbitrary
};

/// Distance (mm) to removed matter at p (volume frame), with derivatives per voxel step.
Jet cut_jet(const Version& version, const glm::dvec3& p) noexcept;

}  // namespace trephine::volume
