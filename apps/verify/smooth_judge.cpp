#include "apps/verify/smooth_judge.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace trephine::verify {

using glm::dvec3;
using glm::ivec3;

namespace {

/// Returns the quadratic B-spline basis function.
double basis(double x) {
  x = std::abs(x);
  if (x < 0.5) return 0.75 - x * x;
  if (x < 1.5) return 0.5 * (1.5 - x) * (1.5 - x);
  return 0;
}

constexpr int k_degree = 6;  // degree of a product of three quadratics along a line
using Coefficients = std::array<double, k_degree + 1>;

/// Returns the matrix that gives Bernstein coefficients from values at the points i / 6, by elimination in
/// long double.
const std::array<Coefficients, k_degree + 1>& bernstein_from_values() {
  static const auto result = [] {
    constexpr int n = k_degree + 1;
    const long double binomial[n] = {1, 6, 15, 20, 15, 6, 1};
    long double m[n][2 * n] = {};
    for (int i = 0; i < n; ++i) {
      const long double t = static_cast<long double>(i) / k_degree;
      for (int j = 0; j < n; ++j) {
        long double b = binomial[j];
        for (int k = 0; k < j; ++k) b *= t;
        for (int k = j; k < k_degree; ++k) b *= 1 - t;
        m[i][j] = b;
      }
      m[i][n + i] = 1;
    }
    for (int c = 0; c < n; ++c) {
      int pivot = c;
      for (int r = c; r < n; ++r)
        if (std::abs(m[r][c]) > std::abs(m[pivot][c])) pivot = r;
      for (int k = 0; k < 2 * n; ++k) std::swap(m[c][k], m[pivot][k]);
      for (int r = 0; r < n; ++r) {
        if (r == c) continue;
        const long double factor = m[r][c] / m[c][c];
        for (int k = 0; k < 2 * n; ++k) m[r][k] -= factor * m[c][k];
      }
    }
    std::array<Coefficients, n> inverse{};
    for (int r = 0; r < n; ++r)
      for (int k = 0; k < n; ++k)
        inverse[static_cast<std::size_t>(r)][static_cast<std::size_t>(k)] =
            static_cast<double>(m[r][n + k] / m[r][r]);
    return inverse;
  }();
  return result;
}

/// Splits a polynomial in Bernstein form at its centre (de Casteljau).
void halve(const Coefficients& whole, Coefficients& low, Coefficients& high) {
  Coefficients work = whole;
  for (std::size_t level = 0; level <= k_degree; ++level) {
    low[level] = work[0];
    high[k_degree - level] = work[k_degree - level];
    for (std::size_t i = 0; i + level < k_degree; ++i) work[i] = 0.5 * (work[i] + work[i + 1]);
  }
}

/// Returns true if at every point of a segment some field is negative. Halves the segment up to `depth`
/// times, and returns false if that does not decide.
bool is_free_polynomial(const std::vector<Coefficients>& fields, int depth) {
  bool may_hit_at_end = true;
  for (const Coefficients& c : fields) {
    if (*std::max_element(c.begin(), c.end()) < 0) return true;
    may_hit_at_end = may_hit_at_end && (c.front() >= 0 || c.back() >= 0);
  }
  if (depth == 0) return false;
  const auto is_solid_end = [&](auto end) {
    return std::all_of(fields.begin(), fields.end(), [&](const Coefficients& c) { return end(c) >= 0; });
  };
  if (may_hit_at_end && (is_solid_end([](const Coefficients& c) { return c.front(); }) ||
                         is_solid_end([](const Coefficients& c) { return c.back(); })))
    return false;
  std::vector<Coefficients> low(fields.size()), high(fields.size());
  for (std::size_t f = 0; f < fields.size(); ++f) halve(fields[f], low[f], high[f]);
  return is_free_polynomial(low, depth - 1) && is_free_polynomial(high, depth - 1);
}

}  // namespace

namespace {
ivec3 nearest_sample(const dvec3& q) {
  return {static_cast<int>(std::floor(q.x + 0.5)), static_cast<int>(std::floor(q.y + 0.5)),
          static_cast<int>(std::floor(q.z + 0.5))};
}
}  // namespace

std::uint64_t SmoothSolid::next_number() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

double SmoothSolid::value(std::size_t f, const dvec3& p) const {
  const dvec3 q = p * dvec3(fields_[f].per_voxel);
  const ivec3 v = nearest_sample(q);
  const std::uint64_t parts = f == 0 && parts_.parts_at ? parts_.parts_at(v) : 0;
  if (parts == 0) return value_of(f, fields_[f].samples, q, v);
  double largest = -1e300;
  for (int part = 0; part < 64; ++part)
    if (parts >> part & 1)
      largest = std::max(largest, value_of(
                                      f + 100 + static_cast<std::size_t>(part),
                                      [&](int x, int y, int z) {
                                        return parts_.samples(part, v, {x, y, z});
                                      },
                                      q, v));
  return largest;
}

/// Returns the value of a field at q, in units of its lattice, in the cube around lattice point v. `f`:
/// number of the field in the cache.
double SmoothSolid::value_of(std::size_t f, const Samples& samples, const dvec3& q, const ivec3& v) const {
  // Most queries are near the previous ones: cache the samples of some cubes.
  struct Cube {
    std::uint64_t number = 0;
    std::size_t field = 0;
    ivec3 middle{0};
    std::array<double, 27> samples;
  };
  thread_local std::array<Cube, 256> cache;
  Cube& cube = cache[(static_cast<unsigned>(v.x) + 7 * static_cast<unsigned>(v.y) +
                      43 * static_cast<unsigned>(v.z) + 131 * f) %
                     cache.size()];
  if (cube.number != number_ || cube.field != f || cube.middle != v) {
    cube.number = number_, cube.field = f, cube.middle = v;
    for (int n = 0; n < 27; ++n)
      cube.samples[static_cast<std::size_t>(n)] =
          samples(v.x + n % 3 - 1, v.y + n / 3 % 3 - 1, v.z + n / 9 - 1);
  }
  const auto weights = [](double at, int middle) {
    return std::array<double, 3>{basis(at - (middle - 1)), basis(at - middle), basis(at - (middle + 1))};
  };
  const auto x = weights(q.x, v.x), y = weights(q.y, v.y), z = weights(q.z, v.z);
  double sum = 0;
  for (std::size_t n = 0; n < 27; ++n) sum += x[n % 3] * y[n / 3 % 3] * z[n / 9] * cube.samples[n];
  return sum;
}

bool SmoothSolid::is_solid(const dvec3& p) const {
  for (std::size_t f = 0; f < fields_.size(); ++f)
    if (value(f, p) < 0) return false;
  return true;
}

namespace {

/// Returns the Bernstein form of a field along the segment from a to b, in units of its lattice, inside the
/// cube around lattice point v.
Coefficients bernstein_along(const Samples& field, const ivec3& v, const dvec3& a, const dvec3& b) {
  double samples[3][3][3];
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) samples[k][j][i] = field(v.x + i - 1, v.y + j - 1, v.z + k - 1);
  Coefficients values{};
  for (int t = 0; t <= k_degree; ++t) {
    const dvec3 p = a + (static_cast<double>(t) / k_degree) * (b - a) - dvec3(v);
    // Weights of this cube's polynomial, even if rounding puts p just outside the cube.
    const auto weights = [](double x, double w[3]) {
      w[0] = 0.5 * (0.5 - x) * (0.5 - x), w[1] = 0.75 - x * x, w[2] = 0.5 * (0.5 + x) * (0.5 + x);
    };
    double wx[3], wy[3], wz[3];
    weights(p.x, wx), weights(p.y, wy), weights(p.z, wz);
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
          values[static_cast<std::size_t>(t)] += wx[i] * wy[j] * wz[k] * samples[k][j][i];
  }
  Coefficients bernstein{};
  const auto& inverse = bernstein_from_values();
  for (std::size_t i = 0; i <= k_degree; ++i)
    for (std::size_t j = 0; j <= k_degree; ++j) bernstein[i] += inverse[i][j] * values[j];
  return bernstein;
}

}  // namespace

/// Returns true if a segment inside one cube of every field meets no solid.
bool SmoothSolid::is_free_in_cube(const dvec3& from, const dvec3& to) const {
  if (parts_.parts_at) {
    const ivec3 v = nearest_sample(0.5 * (from + to));
    if (const std::uint64_t parts = parts_.parts_at(v); parts != 0) {
      for (int part = 0; part < 64; ++part) {
        if ((parts >> part & 1) == 0) continue;
        const Samples samples = [&](int x, int y, int z) { return parts_.samples(part, v, {x, y, z}); };
        if (!is_free_polynomial({bernstein_along(samples, v, from, to)}, 48)) return false;
      }
      return true;
    }
  }
  std::vector<Coefficients> polynomials;
  for (const auto& [field, per_voxel] : fields_) {
    const dvec3 a = from * dvec3(per_voxel), b = to * dvec3(per_voxel);
    const ivec3 v = nearest_sample(0.5 * (a + b));
    double highest = -1e300;
    for (int n = 0; n < 27; ++n)
      highest = std::max(highest, field(v.x + n % 3 - 1, v.y + n / 3 % 3 - 1, v.z + n / 9 - 1));
    if (highest < 0) return true;
    polynomials.push_back(bernstein_along(field, v, a, b));
  }
  return is_free_polynomial(polynomials, 48);
}

bool SmoothSolid::is_free(const dvec3& a, const dvec3& b) const {
  // Cuts the segment at every plane between cubes.
  std::vector<double> cuts{0, 1};
  for (const SampledField& field : fields_)
    for (int axis = 0; axis < 3; ++axis) {
      const double k = field.per_voxel[axis], low = k * std::min(a[axis], b[axis]),
                   high = k * std::max(a[axis], b[axis]);
      for (double plane = std::floor(low) - 0.5; plane <= high + 0.5; plane += 1)
        if (plane > low && plane < high) cuts.push_back((plane / k - a[axis]) / (b[axis] - a[axis]));
    }
  std::sort(cuts.begin(), cuts.end());
  for (std::size_t i = 1; i < cuts.size(); ++i)
    if (!is_free_in_cube(a + cuts[i - 1] * (b - a), a + cuts[i] * (b - a))) return false;
  return true;
}

dvec3 sweep_ideal_proxy(const SmoothSolid& solid, const glm::dmat3& axes, const dvec3& proxy,
                        const dvec3& hip_from, const dvec3& hip_to, int substeps) {
  const glm::dmat3 inverse = glm::inverse(axes);
  const double voxel = std::min({glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])});
  dvec3 at = proxy;
  for (int s = 1; s <= substeps; ++s) {
    const dvec3 hip = hip_from + (static_cast<double>(s) / substeps) * (hip_to - hip_from);
    const auto energy = [&](const dvec3& p) {
      const dvec3 d = axes * (hip - p);
      return glm::dot(d, d);
    };
    // Returns the last free point from p toward q, by bisection.
    const auto advance = [&](const dvec3& p, const dvec3& q) {
      if (solid.is_free(p, q)) return q;
      double free = 0, blocked = 1;
      for (int i = 0; i < 46; ++i) {
        const double middle = 0.5 * (free + blocked);
        (solid.is_free(p, p + middle * (q - p)) ? free : blocked) = middle;
      }
      return p + free * (q - p);
    };
    // Descends: tries a step in many directions, and halves the step if none is nearer to the HIP. The first
    // step is small, so that no pocket of free space is skipped.
    at = advance(at, hip);
    constexpr int k_max_rounds = 3000;
    double step = 0.05 * voxel;
    for (int round = 0; round < k_max_rounds && step > 1e-7 * voxel && energy(at) > 0; ++round) {
      const dvec3 to_hip = glm::normalize(axes * (hip - at));
      dvec3 u = glm::cross(to_hip, std::abs(to_hip.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0));
      u = glm::normalize(u);
      const dvec3 w = glm::cross(to_hip, u);
      dvec3 best = at;
      for (int i = 0; i < 12; ++i) {
        const double angle = i * 0.5235987755982988;  // 30 degrees
        const dvec3 across = std::cos(angle) * u + std::sin(angle) * w;
        // Lifts off the surface, moves across, and descends toward the HIP.
        for (const double lift : {0.0, 0.7, 2.0}) {
          const dvec3 over = at + inverse * (step * (across - lift * to_hip));
          if (!solid.is_free(at, over)) continue;
          const dvec3 down = advance(over, over + inverse * (4 * step * to_hip));
          if (energy(down) < energy(best)) best = down;
        }
      }
      if (energy(best) < energy(at))
        at = best;
      else
        step *= 0.5;
    }
  }
  return at;
}

}  // namespace trephine::verify
