// Geometry and frames of the Falcon, judged by an assembly of its arms in space and by hand-written bytes.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>
#include <regex>
#include <string>

#include "haptics/device/falcon_frame.h"
#include "haptics/device/falcon_kinematics.h"

using namespace trephine;
using namespace trephine::haptics;
using glm::dvec3;

namespace {

/// Assembles an arm in space, joint by joint, and returns the error of its forearm's length, mm. Shares no
/// code with the solver: elbow and wrist are computed as points. `angle`: of the upper arm, rad. Lengths in
/// mm and angles of the arms as published by libnifalcon.
double forearm_error(int arm, double angle, const dvec3& grip) {
  const double turn =
      (15 + std::array{90.0, -30.0, -150.0}[static_cast<std::size_t>(arm)]) * std::numbers::pi / 180;
  const dvec3 out{std::cos(turn), std::sin(turn), 0}, across{-std::sin(turn), std::cos(turn), 0}, up{0, 0, 1};
  const dvec3 shoulder = 40.0 * out - 23.09 * across;
  const dvec3 elbow = shoulder + 60.0 * (std::cos(angle) * out + std::sin(angle) * up);
  const dvec3 wrist = grip + 14.43 * out - 25.0 * across;
  // The short sides of the parallelogram lengthen the forearm within the plane of the arm.
  const dvec3 link = wrist - elbow;
  const double side = glm::dot(link, across), plane = glm::length(link - side * across);
  return std::hypot(plane - 22.5, side) - 102.5;
}

/// Returns random points in the workspace of the device, mm.
std::vector<dvec3> workspace_points(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-1, 1);
  std::vector<dvec3> points;
  while (points.size() < static_cast<std::size_t>(count)) {
    const dvec3 p{share(random), share(random), share(random)};
    if (glm::length(p) <= 1)
      points.push_back(FalconKinematics::k_centre + FalconKinematics::k_workspace_radius * p);
  }
  return points;
}

/// Returns a frame of the firmware: three values of four digits, least significant digit first, and flags.
std::vector<std::uint8_t> frame(std::array<int, 3> values, int flags) {
  std::vector<std::uint8_t> bytes{'<'};
  for (const int value : values)
    for (int digit = 0; digit < 4; ++digit)
      bytes.push_back(static_cast<std::uint8_t>("ABCDEFGHIJKLMNOP"[(value + 65536) / (1 << 4 * digit) % 16]));
  bytes.push_back(static_cast<std::uint8_t>('A' + flags));
  bytes.push_back('A');
  bytes.push_back('>');
  return bytes;
}

}  // namespace

TEST(FalconKinematics, ForwardInvertsInverse) {
  double error = 0;
  for (const dvec3& p : workspace_points(5000)) {
    const auto angles = FalconKinematics::inverse(p);
    ASSERT_TRUE(angles) << p.x << " " << p.y << " " << p.z;
    for (int arm = 0; arm < 3; ++arm)
      ASSERT_NEAR(forearm_error(arm, (*angles)[static_cast<std::size_t>(arm)], p), 0, 1e-9);
    const auto back = FalconKinematics::forward(*angles);
    ASSERT_TRUE(back);
    error = std::max(error, glm::length(*back - p));
  }
  EXPECT_LT(error, 1e-6);
}

TEST(FalconKinematics, TheJacobianIsThatOfDifferences) {
  for (const dvec3& p : workspace_points(300)) {
    const auto angles = FalconKinematics::inverse(p);
    const auto jacobian = FalconKinematics::jacobian(*angles, p);
    ASSERT_TRUE(jacobian);
    for (int axis = 0; axis < 3; ++axis) {
      dvec3 step(0);
      step[axis] = 1e-4;
      const auto above = FalconKinematics::inverse(p + step), below = FalconKinematics::inverse(p - step);
      for (int arm = 0; arm < 3; ++arm) {
        const auto i = static_cast<std::size_t>(arm);
        const double slope = ((*above)[i] - (*below)[i]) / 2e-4;
        EXPECT_NEAR((*jacobian)[axis][arm], slope, 1e-6 + 1e-5 * std::abs(slope));
      }
    }
  }
}

TEST(FalconKinematics, MotorsAndForceHaveTheSamePower) {
  for (const dvec3& p : workspace_points(300)) {
    const auto angles = FalconKinematics::inverse(p);
    const dvec3 force(3, -2, 5), motion(1e-4, 2e-4, -1e-4);
    const auto torques = FalconKinematics::torques(*angles, p, force);
    ASSERT_TRUE(torques);
    const auto moved = FalconKinematics::inverse(p + motion), back = FalconKinematics::inverse(p - motion);
    double work = 0;
    for (std::size_t i = 0; i < 3; ++i) work += (*torques)[i] * ((*moved)[i] - (*back)[i]) / 2;
    EXPECT_NEAR(work, glm::dot(force, motion), 1e-7);
  }
}

TEST(FalconKinematics, AnEncoderCountMovesAFractionOfAMillimetre) {
  const auto at = FalconKinematics::forward(
      {FalconKinematics::angle_of(0), FalconKinematics::angle_of(0), FalconKinematics::angle_of(0)});
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->x, 0, 1e-9);
  EXPECT_NEAR(at->y, 0, 1e-9);
  const auto next = FalconKinematics::forward(
      {FalconKinematics::angle_of(1), FalconKinematics::angle_of(1), FalconKinematics::angle_of(1)});
  EXPECT_NEAR(glm::length(*next - *at), 0.05, 0.03);
}

TEST(FalconKinematics, ImpossibleAnglesHaveNoPosition) {
  EXPECT_FALSE(FalconKinematics::inverse({300, 0, 100}));
  EXPECT_FALSE(FalconKinematics::inverse({0, 0, 900}));
  EXPECT_FALSE(FalconKinematics::forward({20, -20, 20}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(FalconKinematics::forward({nan, 0.5, 0.5}));
  EXPECT_FALSE(FalconKinematics::inverse({nan, 0, 100}));
}

TEST(FalconFrame, StatesAreReadAndRequestsWritten) {
  FalconParser parser;
  const auto state = parser.add(frame({-1234, 0, 32767}, 0x75));
  ASSERT_TRUE(state);
  EXPECT_EQ(state->counts, (std::array<std::int16_t, 3>{-1234, 0, 32767}));
  EXPECT_EQ(state->buttons, 5);
  EXPECT_TRUE(state->is_homed());

  const FalconBytes bytes =
      encode({.motors = {1, -1, 0.5}, .homes = true, .light = FalconRequest::Light::red});
  const auto expected = frame({4095, -4095, 2048}, 9);
  EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), expected.begin()));
}

TEST(FalconFrame, MotorValuesNeverWrapAround) {
  const double infinity = std::numeric_limits<double>::infinity();
  const FalconBytes bytes = encode({.motors = {1e9, -1e9, infinity}});
  EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), frame({4095, -4095, 0}, 0).begin()));
}

TEST(FalconFrame, AParserFindsTheNextFrameAfterDamage) {
  const auto good = frame({1, 2, 3}, 0x70), other = frame({4, 5, 6}, 0x71);
  const auto join = [](std::vector<std::uint8_t> a, const std::vector<std::uint8_t>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  };
  // A frame is found if it arrives in two parts, and also after noise, after the first part of a frame, after
  // a frame with a damaged digit, and after a frame without its end.
  for (std::size_t split = 0; split <= good.size(); ++split) {
    FalconParser parser;
    const auto early = parser.add(std::span(good).first(split));
    const auto late = parser.add(std::span(good).subspan(split));
    EXPECT_EQ(early.has_value(), split == good.size());
    EXPECT_EQ(late.has_value(), split < good.size());
  }
  for (std::vector<std::uint8_t> damage :
       {std::vector<std::uint8_t>{0, 13, '>', 'A'}, std::vector<std::uint8_t>(good.begin(), good.begin() + 9),
        [&] {
          auto bytes = good;
          bytes[3] = 'z';
          return bytes;
        }(),
        [&] {
          auto bytes = good;
          bytes.back() = 'A';
          return bytes;
        }()}) {
    FalconParser parser;
    EXPECT_FALSE(parser.add(damage));
    const auto state = parser.add(other);
    ASSERT_TRUE(state);
    EXPECT_EQ(state->counts, (std::array<std::int16_t, 3>{4, 5, 6}));
  }
  // If several frames arrive together, the state of the last frame is returned.
  FalconParser parser;
  EXPECT_EQ(parser.add(join(good, other))->counts[0], 4);
  EXPECT_EQ(parser.damaged(), 0u);
}

TEST(FalconFrame, StatesInRandomBytesAreWholeFrames) {
  const std::regex whole("<[A-P]{12}[^<][^<]>");
  std::mt19937 random(3);
  FalconParser parser;
  std::string stream;
  int states = 0;
  for (int i = 0; i < 200'000; ++i) {
    // Frames with random digits. Half of the frames are damaged at one position, and some are truncated.
    std::string bytes = "<";
    for (int k = 0; k < 14; ++k) bytes += static_cast<char>('A' + random() % 16);
    bytes += '>';
    if (random() % 2 == 0) bytes[random() % 16] = "<>zA"[random() % 4];
    if (random() % 8 == 0) bytes.resize(random() % 16);
    for (const char c : bytes) {
      stream += c;
      if (stream.size() > 16) stream.erase(0, 1);
      const auto byte = static_cast<std::uint8_t>(c);
      if (!parser.add(std::span(&byte, 1))) continue;
      ++states;
      ASSERT_TRUE(std::regex_match(stream, whole)) << stream;
    }
  }
  EXPECT_GT(states, 80'000);
  EXPECT_GT(parser.damaged(), 50'000u);
}
