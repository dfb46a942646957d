#include "volume/scan/field.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "data-tools/phantoms/phantoms.h"
#include "volume/base/deterministic_math.h"
#include "volume/scan/gaussian.h"

namespace trephine::volume {
namespace {

Frame sheared_frame() {
  glm::dmat3 axes(0.0);
  axes[0] = {0.4, 0.1, 0.0};
  axes[1] = {-0.1, 0.5, 0.05};
  axes[2] = {0.02, 0.3, 1.25};
  return Frame::from_axes({-12, 7, 3}, axes).value();
}

TEST(Frame, RoundTripsAndRefusesBadFrames) {
  const Frame f = sheared_frame();
  const glm::dvec3 p(3.25, -1.5, 20.125);
  EXPECT_LT(glm::length(f.volume_from_world(f.world_from_volume(p)) - p), 1e-12);
  EXPECT_FALSE(f.is_orthogonal());
  EXPECT_TRUE(Frame().is_orthogonal());
  EXPECT_FALSE(Frame::from_axes({0, 0, 0}, glm::dmat3(0.0)).is_ok());
  glm::dmat3 flat(1.0);
  flat[2] = flat[1];
  EXPECT_NE(Frame::from_axes({0, 0, 0}, flat).error().message().find("singular"), std::string::npos);
  EXPECT_FALSE(Frame::from_spacing({0, 0, 0}, {1, 1, -1}).is_ok());
  EXPECT_FALSE(Frame::from_spacing({0, 0, 0}, {1, 0, 1}).is_ok());
  EXPECT_FALSE(Frame::from_spacing({0, 0, std::nan("")}, {1, 1, 1}).is_ok());
  EXPECT_FALSE(Frame::from_spacing({0, 0, 0}, {1, 1, std::numeric_limits<double>::infinity()}).is_ok());
}

TEST(Volume, RefusesImpossibleSizesBeforeAllocating) {
  EXPECT_FALSE(make_volume({0, 5, 5}, Frame()).is_ok());
  EXPECT_FALSE(make_volume({5, -2, 5}, Frame()).is_ok());
  EXPECT_FALSE(make_volume({2'000'000'000, 5, 5}, Frame()).is_ok());
  const auto huge = make_volume({32768, 32768, 32768}, Frame());
  ASSERT_FALSE(huge.is_ok());
  EXPECT_EQ(huge.error().kind, ErrorKind::missing_here);
}

// Voxel spacings in metres and in micrometres give valid frames; axes that span no volume are refused.
TEST(Frame, AcceptsMetresAndMicrometres) {
  for (const double spacing : {1e-6, 5e-5, 5e-4, 0.005, 1.0, 1e4}) {
    const auto frame = Frame::from_spacing({1, 2, 3}, glm::dvec3(spacing, spacing, 6 * spacing));
    ASSERT_TRUE(frame) << spacing;
    const glm::dvec3 p(12.25, -3.5, 7.125);
    const glm::dvec3 back = frame.value().volume_from_world(frame.value().world_from_volume(p));
    EXPECT_LT(glm::length(back - p), 1e-9 / spacing * 1e-6 + 1e-9) << spacing;
  }
  for (const glm::dvec3& bad : {glm::dvec3(0, 1, 1), glm::dvec3(1, -1, 1), glm::dvec3(1, 1, std::nan(""))})
    EXPECT_FALSE(Frame::from_spacing({0, 0, 0}, bad));
  glm::dmat3 flat(1.0);
  flat[2] = flat[0] + 1e-9 * flat[1];
  EXPECT_FALSE(Frame::from_axes({0, 0, 0}, flat));
}

// A linear function and its constant gradient in the world are reproduced exactly.
TEST(Field, LinearFunctionAndItsWorldGradientAreExact) {
  Volume v = make_volume({20, 18, 16}, sheared_frame()).value();
  const glm::dvec3 gradient_volume(7, -4, 11);  // per voxel; integers, so that int16 represents them exactly
  for (int z = 0; z < 16; ++z)
    for (int y = 0; y < 18; ++y)
      for (int x = 0; x < 20; ++x)
        v.voxels[v.index(x, y, z)] = static_cast<std::int16_t>(7 * x - 4 * y + 11 * z);
  Shape shape;
  shape.low = 30.25;
  const Field field(v, shape);
  const glm::dvec3 gradient_world = glm::transpose(glm::inverse(v.frame.axes())) * gradient_volume;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> u(2, 13);
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 p(u(random), u(random), u(random));
    ASSERT_NEAR(field.value(p), glm::dot(gradient_volume, p) - 30.25, 1e-10);
    ASSERT_LT(glm::length(field.gradient(p) - gradient_volume), 1e-10);
    ASSERT_LT(glm::length(field.smooth_gradient(p) - gradient_volume), 1e-10);
    ASSERT_LT(glm::length(v.frame.gradient_world_from_volume(field.gradient(p)) - gradient_world), 1e-10);
  }
}

TEST(Field, GradientIsTheDerivativeOfTheValue) {
  Volume v = make_volume({9, 9, 9}, Frame()).value();
  std::mt19937_64 random(4);
  for (auto& x : v.voxels.span()) x = static_cast<std::int16_t>(random() % 3000) - 1500;
  Shape shape;
  shape.low = -200, shape.high = 900;  // the intensities are within the window, below and above it
  const Field field(v, shape);
  std::uniform_real_distribution<double> u(-1.4, 9.4);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 p(u(random), u(random), u(random));
    const double h = 1e-6;
    for (int a = 0; a < 3; ++a) {
      glm::dvec3 step(0);
      step[a] = h;
      if (std::floor(p[a] - h) != std::floor(p[a] + h)) continue;  // crosses a cell face
      const double difference = (field.value(p + step) - field.value(p - step)) / (2 * h);
      ASSERT_NEAR(field.gradient(p)[a], difference, 1e-4 * (1 + std::abs(difference)));
    }
  }
}

TEST(Field, SmoothGradientIsContinuousAcrossCells) {
  Volume v = make_volume({9, 9, 9}, Frame()).value();
  std::mt19937_64 random(6);
  for (auto& x : v.voxels.span()) x = static_cast<std::int16_t>(random() % 2000);
  const Field field(v, Shape{});
  for (int i = 1; i < 8; ++i) {
    const glm::dvec3 below(i - 1e-9, 3.3, 4.7), above(i + 1e-9, 3.3, 4.7);
    EXPECT_LT(glm::length(field.smooth_gradient(below) - field.smooth_gradient(above)), 1e-4);
  }
}

/// Returns the x coordinate (voxels) below 0 at which the trilinear field of a solid that fills the grid
/// reaches 0.
double border_of(const Volume& v, const Shape& shape) {
  const Field field(v, shape);
  double solid = 1, air = -1.5;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (solid + air);
    (field.value({middle, 2.3, 1.8}) >= 0 ? solid : air) = middle;
  }
  return solid;
}

TEST(Field, SolidsEndHalfAVoxelBeyondTheLastCentresInEveryUnit) {
  // Hounsfield units, raw 12-bit scanner values, an 8-bit mask, dense metal; open and closed windows.
  for (const auto& [intensity, low, high] : {std::tuple(1600.0, 300.0, 1e9),
                                             {301.0, 300.0, 1e9},
                                             {4000.0, 1324.0, 1e9},
                                             {1.0, 0.5, 1e9},
                                             {255.0, 128.0, 1e9},
                                             {32000.0, 300.0, 1e9},
                                             {700.0, 300.0, 1600.0},
                                             {-500.0, -2000.0, 300.0}}) {
    Volume v = make_volume({4, 5, 4}, Frame()).value();
    for (auto& x : v.voxels.span()) x = static_cast<std::int16_t>(intensity);
    Shape shape;
    shape.low = low, shape.high = high;
    EXPECT_NEAR(border_of(v, shape), -0.5, 1e-12) << intensity;
    const Field field(v, shape);
    for (const glm::ivec3& out : {glm::ivec3(-1, 0, 0), {4, 4, 3}, {-7, 9, 2}, {2, 5, -3}})
      EXPECT_LT(field.at(out.x, out.y, out.z), 0);
    EXPECT_LT(field.value({-7, 2, 2}), 0);
  }
  Volume labelled = make_volume({4, 5, 4}, Frame(), true).value();
  for (auto& x : labelled.labels.span()) x = 3;
  Shape label;
  label.label = 3;
  EXPECT_NEAR(border_of(labelled, label), -0.5, 1e-12);
}

TEST(Field, IsAirBeyondTheGridAlsoWhereTheFieldIsZeroOrAir) {
  Volume v = make_volume({3, 3, 3}, Frame()).value();
  Shape shape;
  for (auto& x : v.voxels.span()) x = 300;
  EXPECT_EQ(Field(v, shape).at(0, 0, 0), 0);
  EXPECT_LT(Field(v, shape).at(-1, 0, 0), 0);
  for (auto& x : v.voxels.span()) x = -1000;
  EXPECT_EQ(Field(v, shape).at(-1, 0, 0), -1300);
}

TEST(Gaussian, SpreadsAnImpulseToTheKernelAndKeepsMass) {
  const glm::ivec3 size(33, 31, 35);
  std::vector<float> values(33 * 31 * 35, 0.0f);
  const auto at = [&](int x, int y, int z) {
    return values[static_cast<std::size_t>(x + 33 * (y + 31 * z))];
  };
  values[16 + 33 * (15 + 31 * 17)] = 1000;
  gaussian_blur(values, size, {1.0, 2.0, 0.0});
  double sum = 0;
  for (const float v : values) sum += v;
  EXPECT_NEAR(sum, 1000, 0.01);
  EXPECT_EQ(at(16, 15, 16), 0.0f);  // no blur along z
  for (const int d : {1, 2, 3}) {
    EXPECT_NEAR(at(16 + d, 15, 17) / at(16, 15, 17), std::exp(-0.5 * d * d), 1e-5);
    EXPECT_NEAR(at(16, 15 + d, 17) / at(16, 15, 17), std::exp(-0.125 * d * d), 1e-5);
  }
}

TEST(Gaussian, KeepsAConstantAndIsIndependentOfThreads) {
  Volume v = make_volume({21, 22, 23}, Frame()).value();
  for (auto& x : v.voxels.span()) x = 321;
  const Volume blurred = gaussian_blurred(v, glm::dvec3(1.5)).value();
  for (const auto& x : blurred.voxels.span()) ASSERT_EQ(x, 321);
  std::mt19937_64 random(6);
  for (auto& x : v.voxels.span()) x = static_cast<std::int16_t>(random() % 2000);
  const Volume one = gaussian_blurred(v, glm::dvec3(0.7), 1).value(),
               three = gaussian_blurred(v, glm::dvec3(0.7), 3).value();
  for (std::size_t i = 0; i < one.voxels.size(); ++i) ASSERT_EQ(one.voxels[i], three.voxels[i]);
}

TEST(DeterministicMath, AgreesWithTheLibrary) {
  for (double x = -30; x < 30; x += 0.0371) {
    ASSERT_NEAR(deterministic_exp(x) / std::exp(x), 1, 2e-15);
    ASSERT_NEAR(deterministic_log(x * x + 1e-9), std::log(x * x + 1e-9),
                1e-14 * (1 + std::abs(std::log(x * x + 1e-9))));
    ASSERT_NEAR(deterministic_sin(40 * x), std::sin(40 * x), 1e-13);
    ASSERT_NEAR(deterministic_atan(std::abs(x)), std::atan(std::abs(x)), 1e-15);
    if (std::abs(x) <= 1) {
      ASSERT_NEAR(deterministic_acos(x), std::acos(x), 2e-15);
    }
    ASSERT_NEAR(deterministic_cos(40 * x), std::cos(40 * x), 1e-12);
  }
}

}  // namespace
}  // namespace trephine::volume
