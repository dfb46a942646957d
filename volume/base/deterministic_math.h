// exp, log, sin, cos, atan and acos from + - * / and the square root: identical bits on every machine,
// compiler and C library.
#pragma once

#include <cmath>

namespace trephine {

/// e^x for |x| < 700, relative error below 1e-15.
inline double deterministic_exp(double x) noexcept {
  constexpr double k_ln2_high = 0x1.62e42fefa38p-1, k_ln2_low = 0x1.ef35793c7673p-45;  // sum: ln 2
  const double k = std::floor(x / (k_ln2_high + k_ln2_low) + 0.5);
  const double r = (x - k * k_ln2_high) - k * k_ln2_low;
  double sum = 1;
  for (int n = 14; n >= 1; --n) sum = 1 + sum * r / n;
  return std::ldexp(sum, static_cast<int>(k));
}

/// Natural logarithm of x > 0, absolute error below 1e-14.
inline double deterministic_log(double x) noexcept {
  int e = 0;
  double m = std::frexp(x, &e);
  if (m < 0.7071067811865476) m *= 2, --e;
  const double s = (m - 1) / (m + 1);  // ln m = 2 atanh s, |s| < 0.172
  double sum = 0;
  for (int n = 23; n >= 1; n -= 2) sum = sum * s * s + 1.0 / n;
  return 2 * s * sum + e * 0.6931471805599453;
}

/// sin x for |x| < 1e5, absolute error below 1e-14.
inline double deterministic_sin(double x) noexcept {
  constexpr double k_pi_high = 0x1.921fb544p+1, k_pi_low = 0x1.0b4611a626331p-33;  // sum: pi
  const double k = std::floor(x / (k_pi_high + k_pi_low) + 0.5);
  const double r = (x - k * k_pi_high) - k * k_pi_low;
  constexpr double k_terms[] = {1.0 / 51090942171709440000.0,
                                -1.0 / 121645100408832000.0,
                                1.0 / 355687428096000.0,
                                -1.0 / 1307674368000.0,
                                1.0 / 6227020800.0,
                                -1.0 / 39916800.0,
                                1.0 / 362880.0,
                                -1.0 / 5040.0,
                                1.0 / 120.0,
                                -1.0 / 6.0};  // (-1)^n / (2n + 1)! for n = 10 to 1
  const double square = r * r;
  double sum = 0;
  for (const double term : k_terms) sum = (sum + term) * square;
  sum += 1;
  const bool is_odd = k - 2 * std::floor(k / 2) != 0;
  return is_odd ? -sum * r : sum * r;
}

/// cos x for |x| < 1e5. The rounding of x + pi / 2 adds to the error of deterministic_sin().
inline double deterministic_cos(double x) noexcept { return deterministic_sin(x + 1.5707963267948966); }

/// 64-bit hash for seeded noise (Steele et al. 2014, splitmix64).
inline unsigned long long hash_bits(unsigned long long x) noexcept {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

/// Approximately standard normal number for a seed and a counter: scaled sum of four uniform 16-bit numbers
/// (Irwin-Hall), within +-3.46.
inline double hash_normal(unsigned long long seed, unsigned long long counter) noexcept {
  const unsigned long long bits = hash_bits(hash_bits(seed) ^ counter);
  double sum = 0;
  for (int part = 0; part < 4; ++part) sum += static_cast<double>(bits >> (16 * part) & 0xffff) * 0x1p-16;
  return (sum - 2.0 * (1 - 0x1p-16)) * 1.7320508075688772;
}

/// Arc tangent of x >= 0, absolute error below 1e-15.
inline double deterministic_atan(double x) noexcept {
  if (x > 1) return 1.5707963267948966 - deterministic_atan(1 / x);
  // Halves the angle twice, then sums the series for an angle of at most pi / 16.
  const double half = x / (1 + std::sqrt(1 + x * x)), quarter = half / (1 + std::sqrt(1 + half * half));
  const double square = quarter * quarter;
  double sum = 0;
  for (int n = 27; n > 0; n -= 2) sum = 1.0 / n - square * sum;
  return 4 * quarter * sum;
}
/// Arc cosine of x from -1 to 1, absolute error below 2e-15.
inline double deterministic_acos(double x) noexcept {
  if (x <= -1) return 3.141592653589793;
  return 2 * deterministic_atan(std::sqrt((1 - x) / (1 + x)));
}

}  // namespace trephine
