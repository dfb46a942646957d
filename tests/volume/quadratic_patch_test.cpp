#include "volume/fields/quadratic_patch.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/verify/smooth_judge.h"
#include "data-tools/phantoms/phantoms.h"
#include "volume/base/deterministic_math.h"
#include "volume/cuts/removal.h"

namespace trephine::volume {
namespace {

using glm::dvec3;
using glm::ivec3;

Volume noisy(const ivec3& size) {
  Volume v = make_volume(size, Frame(), true).value();
  for (std::size_t i = 0; i < v.voxels.size(); ++i) {
    v.voxels[i] = static_cast<std::int16_t>(-1024 + static_cast<int>(hash_bits(i) % 4096));
    v.labels[i] = static_cast<std::uint8_t>(hash_bits(i + 77) % 3);
  }
  v.label_names = {"air", "a", "b"};
  return v;
}

double random(std::uint64_t i) { return static_cast<double>(hash_bits(i) >> 11) * 0x1p-53; }

TEST(QuadraticPatch, EqualsTheSumOfSplinesWithItsDerivativesAndBounds) {
  const auto base = std::make_shared<const Volume>(noisy({11, 9, 10}));
  RemovalEditor editor(std::make_shared<Version>(base), {Field(*base, Shape{})});
  editor.remove({{3, 4, 5}, {8, 4, 2}, 2.5});
  const auto version = editor.publish();
  Shape window, label;
  window.low = -100, window.high = 900;
  label.label = 2;
  const Field fields[] = {Field(*base, Shape{}), Field(*base, window), Field(*base, label)};
  std::vector<verify::Samples> samples;
  for (const Field& f : fields) samples.push_back([&f](int x, int y, int z) { return f.at(x, y, z); });
  samples.push_back([&](int x, int y, int z) { return version->voxel_distance(x, y, z); });
  const verify::SmoothSolid judge({{samples[0]}, {samples[1]}, {samples[2]}, {samples[3]}});

  std::uint64_t n = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const ivec3 v(static_cast<int>(random(n + 6) * 15) - 2, static_cast<int>(random(n + 7) * 13) - 2,
                  static_cast<int>(random(n + 8) * 14) - 2);
    const dvec3 u(random(n) - 0.5, random(n + 1) - 0.5, random(n + 2) - 0.5);
    const dvec3 direction(random(n + 3) - 0.5, random(n + 4) - 0.5, random(n + 5) - 0.5);
    n += 9;
    for (std::size_t f = 0; f < samples.size(); ++f) {
      QuadraticPatch patch;
      if (f < 3)
        patch.load(fields[f], v);
      else
        patch.load_distance(*version, version->lattice().centre_of(v));
      const ValueAndGradient s = patch.value_and_gradient(u);
      const Jet j = patch.jet(u);
      const double scale = 1e-9 * (f < 2 ? 4000 : 1);
      ASSERT_NEAR(s.value, judge.value(f, dvec3(v) + u), scale) << f;
      ASSERT_EQ(s.value, j.value);
      ASSERT_EQ(s.gradient, j.gradient);
      ASSERT_LE(s.value, patch.maximum() + scale);
      ASSERT_GE(s.value, patch.minimum() - scale);
      // Compares derivatives with central differences of the values. For these low-degree polynomials the
      // error of such a difference is below the tolerance.
      const double h = 1e-4;
      const dvec3 ahead = u + h * direction, behind = u - h * direction;
      const double slope =
          (patch.value_and_gradient(ahead).value - patch.value_and_gradient(behind).value) / (2 * h);
      ASSERT_NEAR(slope, glm::dot(s.gradient, direction), 1e-7 * (f < 2 ? 4000 : 1));
      const double curvature =
          glm::dot(patch.value_and_gradient(ahead).gradient - patch.value_and_gradient(behind).gradient,
                   direction) /
          (2 * h);
      ASSERT_NEAR(curvature, glm::dot(j.hessian_times(direction), direction), 1e-7 * (f < 2 ? 8000 : 2));
      ASSERT_LE(std::abs(glm::dot(j.hessian_times(direction), direction)),
                patch.hessian_bound().along(direction) * (1 + 1e-12) + scale);
    }
  }
}

/// The wide kernel (AVX2) and the narrow one give the same bits, so that a session that was recorded with one
/// of them replays with the other.
TEST(QuadraticPatch, WideAndNarrowKernelsGiveTheSameBits) {
  if (!k_has_wide_patches) GTEST_SKIP() << "no AVX2 here";
  std::uint64_t n = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    QuadraticPatch patch;
    const double scale = trial % 3 == 0 ? 1e-6 : trial % 3 == 1 ? 1 : 3000;
    for (int z = 0; z < 3; ++z)
      for (int y = 0; y < 3; ++y, n += 3)
        patch.set_row(y, z, scale * (random(n) - 0.5), scale * (random(n + 1) - 0.5),
                      scale * (random(n + 2) - 0.5));
    const dvec3 p(random(n) - 0.5, random(n + 1) - 0.5, random(n + 2) - 0.5);
    n += 3;
    const ValueAndGradient wide = patch.value_and_gradient(p), narrow = patch.narrow_value_and_gradient(p);
    ASSERT_EQ(wide.value, narrow.value);
    ASSERT_EQ(wide.gradient, narrow.gradient);
    const Jet wide_jet = patch.jet(p), narrow_jet = patch.narrow_jet(p);
    ASSERT_EQ(wide_jet.value, narrow_jet.value);
    ASSERT_EQ(wide_jet.gradient, narrow_jet.gradient);
    ASSERT_EQ(wide_jet.hessian_diagonal, narrow_jet.hessian_diagonal);
    ASSERT_EQ(wide_jet.hessian_mixed, narrow_jet.hessian_mixed);
    const auto wide_bound = patch.hessian_bound(), narrow_bound = patch.narrow_hessian_bound();
    ASSERT_EQ(wide_bound.pure, narrow_bound.pure);
    ASSERT_EQ(wide_bound.cross, narrow_bound.cross);
  }
}

TEST(QuadraticPatch, NeighbouringCubesAgreeInValueAndSlope) {
  const Volume base = noisy({8, 8, 8});
  const Field field(base, Shape{});
  for (int axis = 0; axis < 3; ++axis) {
    ivec3 a(3, 4, 3), b = a;
    b[axis] += 1;
    QuadraticPatch low, high;
    low.load(field, a);
    high.load(field, b);
    for (std::uint64_t n = 0; n < 50; ++n) {
      dvec3 u(random(3 * n) - 0.5, random(3 * n + 1) - 0.5, random(3 * n + 2) - 0.5);
      u[axis] = 0.5;
      dvec3 w = u;
      w[axis] = -0.5;
      const ValueAndGradient s = low.value_and_gradient(u), t = high.value_and_gradient(w);
      EXPECT_NEAR(s.value, t.value, 1e-9);
      EXPECT_LT(glm::length(s.gradient - t.gradient), 1e-8);
    }
  }
}

}  // namespace
}  // namespace trephine::volume
