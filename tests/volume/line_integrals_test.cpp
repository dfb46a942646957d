// Line integrals against exact arithmetic, voxel by voxel, and against closed forms.
#include "volume/imaging/line_integrals.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/verify/exact_traversal.h"
#include "tests/hash_number.h"
#include "tests/whole.h"
#include "volume/base/parallel.h"

namespace trephine::volume {
namespace {

using glm::dvec3;
using glm::ivec3;

constexpr VoxelWeights k_weights{-990, -1000, 0, 2.1e-5f, 1.7e-5f};

/// Returns noise with metal in it; half of the blocks are air.
Volume metal_noise(const ivec3& size, std::uint64_t seed) {
  Volume v = make_volume(size, Frame()).value();
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const std::size_t i = v.index(x, y, z);
        const auto block = static_cast<std::uint64_t>((x >> 3) + 64 * ((y >> 3) + 64 * (z >> 3)));
        const double u = number(31 * i + seed);
        v.voxels[i] = static_cast<std::int16_t>(
            number(block + 1000 * seed) < 0.5 ? -1000 - (i % 3 == 0 ? 24 : 0) : -1000 + 3000 * u * u);
      }
  v.voxels[v.voxels.size() - 1] = 2000;  // shows whether the last voxel is read
  return v;
}

/// Returns the integral of one ray by the independent judge, in units of the ray's length.
double judged(const Volume& v, const Ray& ray) {
  const auto plain = [](const dvec3& p) { return std::array<double, 3>{p.x, p.y, p.z}; };
  // The traversed grid has one more voxel on each side, so that leaving the scan is a crossing too.
  const auto visits =
      verify::exact_traversal(plain(ray.start), plain(ray.end), {-1, -1, -1}, {v.size.x, v.size.y, v.size.z});
  long double sum = 0;
  for (std::size_t i = 0; i < visits.size(); ++i) {
    const auto& at = visits[i].voxel;
    const ivec3 voxel(at[0], at[1], at[2]);
    if (!v.contains(voxel)) continue;
    const long double end = i + 1 < visits.size() ? visits[i + 1].t_enter : 1.0L;
    const int intensity = v.voxels[v.index(voxel.x, voxel.y, voxel.z)];
    const double weight = intensity <= -990 ? 0
                          : intensity <= 0  ? 2.1e-5f * static_cast<double>(intensity + 1000)
                                            : 2.1e-5f * 1000.0 + 1.7e-5f * static_cast<double>(intensity);
    sum += (end - visits[i].t_enter) * static_cast<long double>(weight);
  }
  return static_cast<double>(sum);
}

/// Returns the largest weight of a voxel. Errors are relative to at least one step through such a voxel,
/// since single precision may miss a voxel whose edge a ray just crosses.
double heaviest(const Volume& v) {
  return k_weights.of(*std::max_element(v.voxels.span().begin(), v.voxels.span().end()));
}

/// Returns the fan number n. By n, its rays pass through the volume along an axis, nearly along an axis, at
/// 45 degrees, along a space diagonal or in any direction, or start and end inside. In half of the groups of
/// 18 fans, sources outside the volume and their pixels are on whole and half voxels.
RayFan fan_of(std::uint64_t n, const ivec3& size) {
  const auto at = [n](std::uint64_t k) { return number(101 * n + k); };
  const dvec3 s(size);
  RayFan fan;
  fan.columns = 19, fan.rows = 7;
  const int d = static_cast<int>(n % 3);
  const dvec3 middle = 0.5 * s + dvec3(at(1) - 0.5, at(2) - 0.5, at(3) - 0.5) * 6.0;
  dvec3 along{0.0}, right{0.0}, down{0.0};
  along[d] = n % 2 == 0 ? 1 : -1;
  right[(d + 1) % 3] = 1, down[(d + 2) % 3] = 1;
  const double far = 3.0 * glm::length(s);
  switch (n / 3 % 6) {
    case 0:  // straight along an axis
      break;
    case 1:  // any direction
      along += dvec3(at(4) - 0.5, at(5) - 0.5, at(6) - 0.5) * 2.0;
      break;
    case 2:  // 45 degrees
      along[(d + 1) % 3] = 1;
      break;
    case 3:  // a space diagonal
      along = {1, -1, 1};
      break;
    case 4:  // nearly along an axis
      along[(d + 1) % 3] = 1e-7 * (at(4) - 0.5);
      break;
    default:  // both ends inside
      fan.source = middle - 0.2 * s;
      fan.right = right * 1.3, fan.down = down * 2.1;
      fan.corner = middle - 9.0 * fan.right - 3.0 * fan.down + 0.3 * s * along;
      return fan;
  }
  fan.source = middle - far * along;
  fan.right = right * (0.4 + 6 * at(7)), fan.down = down * (0.4 + 6 * at(8));
  fan.corner = middle + far * along - 9.0 * fan.right - 3.0 * fan.down;
  if (n / 18 % 2 == 0) {  // on whole and half voxels: within planes, along edges, through corners
    const auto snapped = [](const dvec3& p) { return glm::round(2.0 * p) / 2.0; };
    fan.source = snapped(fan.source), fan.corner = snapped(fan.corner);
    fan.right = snapped(fan.right), fan.down = snapped(fan.down);
  }
  return fan;
}

TEST(LineIntegrals, EqualExactArithmeticOnEveryRay) {
  long rays = 0, met = 0;
  double worst = 0;
  for (const ivec3& size : {ivec3(40, 33, 29), ivec3(70, 9, 5), ivec3(3, 2, 50), ivec3(1, 20, 20)}) {
    const Volume v = metal_noise(size, static_cast<std::uint64_t>(size.x));
    for (const LineKernels* kernels : {&k_line_kernels_any, &best_line_kernels()}) {
      const LineIntegrals lines(v, k_weights, 1, *kernels);
      for (std::uint64_t n = 0; n < (runs_all_cases() ? 4000u : 200u); ++n) {
        const RayFan fan = fan_of(n, size);
        std::vector<double> sums(static_cast<std::size_t>(fan.columns * fan.rows), -1);
        lines.integrate(fan, {0, 0, fan.columns, fan.rows}, RaySum::exact, 1, sums);
        for (int j = 0; j < fan.rows; ++j)
          for (int i = 0; i < fan.columns; ++i) {
            const Ray ray{fan.source, fan.pixel(i, j)};
            const double length = glm::length(ray.end - ray.start);
            const double is = judged(v, ray);
            const double sum = sums[static_cast<std::size_t>(i + fan.columns * j)];
            const double error = std::abs(sum - is) / std::max(is, heaviest(v) / length);
            ++rays, met += is > 0;
            worst = std::max(worst, error);
            ASSERT_LE(error, 1e-6) << "fan " << n << " pixel " << i << ", " << j << ": " << sum << " not "
                                   << is;
          }
      }
    }
  }
  EXPECT_GT(met, rays / 4);
  RecordProperty("rays", static_cast<int>(rays));
  RecordProperty("worst", std::to_string(worst));
  std::printf(
      "%ld rays, %ld with a positive sum; error at most %.2g, relative to the larger of the sum and "
      "a step through the heaviest voxel\n",
      rays, met, worst);
}

TEST(LineIntegrals, AreExactOnRaysWhereTraversalsBreak) {
  const Volume v = metal_noise({24, 20, 17}, 3);
  const LineIntegrals lines(v, k_weights, 1);
  long met = 0;
  for (std::uint64_t n = 0; n < (runs_all_cases() ? 400'000u : 20'000u); ++n) {
    const verify::AdversarialRay r = verify::adversarial_ray(n, 7);
    Ray ray{{r.start[0], r.start[1], r.start[2]}, {r.end[0], r.end[1], r.end[2]}};
    ray.start += 8.0, ray.end += 8.0;  // near the middle of the grid
    const double is = judged(v, ray);
    const double length = glm::length(ray.end - ray.start), sum = lines.integrate(ray);
    if (!(length > 0 && length < 1e6)) continue;
    met += is > 0;
    ASSERT_LE(std::abs(sum - is), 1e-6 * std::max(is, heaviest(v) / length))
        << verify::ray_family_name(static_cast<int>(n % verify::k_ray_families)) << " " << n << ": " << sum
        << " not " << is;
  }
  EXPECT_GT(met, 2000);
}

TEST(LineIntegrals, AreTheSameBitsForAnyCpuThreadCountAndBox) {
  const ivec3 size(75, 60, 50);
  const Volume v = metal_noise(size, 5);
  const LineIntegrals any(v, k_weights, 1, k_line_kernels_any), wide(v, k_weights, 2);
  for (std::uint64_t n = 0; n < 60; ++n)
    for (const RaySum how : {RaySum::exact, RaySum::joseph}) {
      RayFan fan = fan_of(n, size);
      fan.columns = 83, fan.rows = 37;
      const std::size_t count = 83 * 37;
      std::vector<double> a(count, -1), b(count, -1), part(count, -1);
      any.integrate(fan, {0, 0, 83, 37}, how, 1, a);
      wide.integrate(fan, {0, 0, 83, 37}, how, 3, b);
      ASSERT_EQ(a, b) << n;
      const PixelBox box{17, 5, 60, 23};
      wide.integrate(fan, box, how, 2, part);
      for (int j = 0; j < 37; ++j)
        for (int i = 0; i < 83; ++i) {
          const bool is_in = i >= 17 && i < 60 && j >= 5 && j < 23;
          const auto at = static_cast<std::size_t>(i + 83 * j);
          ASSERT_EQ(part[at], is_in ? a[at] : -1) << n << ": " << i << ", " << j;
        }
    }
}

TEST(LineIntegrals, SkipOnlyEmptyBlocks) {
  const Volume v = metal_noise({64, 64, 64}, 9);
  const LineIntegrals lines(v, k_weights, 1);
  // With these weights every intensity counts, so that no block may be skipped.
  const VoxelWeights all{-2000, -2000, -1000, 0, 0};
  int filled = 0;
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        bool is = false;
        for (int i = 0; i < 512; ++i)
          is |= v.voxels[v.index(8 * x + (i & 7), 8 * y + (i >> 3 & 7), 8 * z + (i >> 6))] > -990;
        EXPECT_EQ(lines.is_filled({x, y, z}), is);
        filled += is;
      }
  EXPECT_GT(filled, 150);
  EXPECT_LT(filled, 350);
  EXPECT_TRUE(LineIntegrals(v, all, 1).is_filled({0, 0, 0}));
}

/// Joseph's sums, with smooth values between voxel centres, against the closed form.
TEST(LineIntegrals, JosephsSumsFollowALinearRamp) {
  Volume v = make_volume({40, 40, 40}, Frame()).value();
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x)
        v.voxels[v.index(x, y, z)] = static_cast<std::int16_t>(10 * x + 20 * y + 30 * z);
  const VoxelWeights weights{-1000, -1000, 0, 1e-3f, 1e-3f};
  const LineIntegrals lines(v, weights, 1);
  RayFan fan;
  fan.source = {20, -400, 15}, fan.corner = {12.3, 420, 14.1}, fan.right = {0.9, 0, 0},
  fan.down = {0, 0, 0.7};
  fan.columns = 11, fan.rows = 9;
  std::vector<double> sums(99);
  lines.integrate(fan, {0, 0, 11, 9}, RaySum::joseph, 1, sums);
  for (int j = 0; j < 9; ++j)
    for (int i = 0; i < 11; ++i) {
      const dvec3 to = fan.pixel(i, j), along = to - fan.source;
      const dvec3 middle = fan.source + (19.5 - fan.source.y) / along.y * along;
      const double mean = 1e-3 * (1000 + 10 * middle.x + 20 * middle.y + 30 * middle.z);
      EXPECT_NEAR(sums[static_cast<std::size_t>(i + 11 * j)], mean * 40 / std::abs(along.y), 1e-7) << i << j;
    }
}

TEST(LineIntegrals, AreZeroForNonFiniteRays) {
  const Volume v = metal_noise({16, 16, 16}, 2);
  const LineIntegrals lines(v, k_weights, 1);
  const double no = std::numeric_limits<double>::quiet_NaN(), far = 1e300;
  EXPECT_EQ(lines.integrate({{no, 0, 0}, {1, 1, 1}}), 0);
  EXPECT_EQ(lines.integrate({{far, 0, 0}, {1, 1, 1}}), 0);
  EXPECT_EQ(lines.integrate({{5, 5, 5}, {5, 5, 5}}), 0);
  RayFan fan;
  fan.columns = 9, fan.rows = 2;
  std::vector<double> sums(18, -1);
  for (const dvec3& source : {dvec3(no), dvec3(far), dvec3(5)}) {
    fan.source = source, fan.corner = dvec3(5);
    lines.integrate(fan, {0, 0, 9, 2}, RaySum::exact, 1, sums);
    EXPECT_EQ(*std::max_element(sums.begin(), sums.end()), 0);
  }
}

}  // namespace
}  // namespace trephine::volume
