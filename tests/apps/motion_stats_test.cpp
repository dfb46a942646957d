// Motion of a hand against closed forms: circles, motions of minimum jerk, stops, strokes, gaps.
#include "apps/workbench/motion_stats.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace trephine::workbench {
namespace {

using glm::dvec3;

constexpr double k_pi = 3.14159265358979323846;

/// Feeds a motion to one hand of MotionStats.
struct Feed {
  double rate;
  MotionStats stats;
  std::uint64_t tick = 0;
  explicit Feed(double rate_hz, std::size_t hands = 1) : rate(rate_hz), stats(hands, 1 / rate_hz) {}
  void add(const dvec3& p, bool is_pressed = true, double force = 0, double clearance = 20, int hand = 0) {
    haptics::ServoRecord record;
    record.tick = tick++;
    record.hand = static_cast<std::uint8_t>(hand);
    record.pose.position_world = p;
    record.pose.press(is_pressed);
    record.force_world = dvec3(0, 0, force);
    stats.add(record, clearance);
  }
  /// Feeds position(t) for `seconds`.
  template <class Position>
  void play(double seconds, const Position& position, bool is_pressed = true) {
    const auto count = static_cast<int>(std::lround(seconds * rate));
    for (int i = 0; i < count; ++i) add(position(i / rate), is_pressed);
  }
};

/// Position of a motion of minimum jerk of length 1 at a share of its duration (Flash and Hogan 1985).
double minimum_jerk(double s) { return s * s * s * (10 + s * (-15 + s * 6)); }

TEST(MotionStats, ACircleHasItsLengthSpeedAndJerk) {
  for (const double rate : {250.0, 1000.0, 4000.0}) {
    SCOPED_TRACE(rate);
    constexpr double k_radius = 30, k_angular_speed = 4;  // mm, rad/s
    Feed feed(rate);
    feed.play(2 * k_pi, [](double t) {
      return dvec3(k_radius * std::cos(k_angular_speed * t), k_radius * std::sin(k_angular_speed * t), 7);
    });
    const HandMotion motion = feed.stats.hand(0);
    const double speed = k_radius * k_angular_speed, seconds = 2 * k_pi;
    // Positions are averaged over intervals of h = 20 ms. This reduces the radius by the factor sin(x) / x
    // with x = 0.5 k_angular_speed h. Each difference of the means reduces the result by the same factor.
    const double x = 0.5 * k_angular_speed * 0.02, less = std::sin(x) / x;
    EXPECT_NEAR(motion.seconds, seconds, 1 / rate);
    EXPECT_EQ(motion.working_seconds, motion.seconds);
    EXPECT_EQ(motion.idle_seconds, 0);
    EXPECT_NEAR(motion.path, speed * seconds, 0.002 * speed * seconds);
    EXPECT_NEAR(motion.mean_speed, speed, 0.002 * speed);
    EXPECT_NEAR(motion.peak_speed, speed * less * less, 1e-3 * speed);
    const double jerk = speed * k_angular_speed * k_angular_speed;
    EXPECT_NEAR(motion.jerk, jerk * std::pow(less, 4), 2e-3 * jerk);
    // The integral of the squared jerk is jerk^2 D: D^4 jerk^2 / v^2 = (k_angular_speed D)^4.
    EXPECT_NEAR(motion.log_jerk, 4 * std::log(k_angular_speed * seconds), 0.01);
    EXPECT_EQ(motion.strokes, 1);
  }
}

TEST(MotionStats, AMotionOfMinimumJerkIsTheSmoothest) {
  constexpr double k_length = 80, k_seconds = 4;
  Feed smooth(1000), shaky(1000);
  const auto reach = [](double t) { return dvec3(k_length * minimum_jerk(t / k_seconds), 0, 0); };
  smooth.play(k_seconds, reach);
  shaky.play(k_seconds, [&](double t) { return reach(t) + dvec3(0, 0.3 * std::sin(2 * k_pi * 8 * t), 0); });
  const HandMotion motion = smooth.stats.hand(0);
  // The integral of the squared jerk is 720 L^2 / D^5, and the peak of the speed is 1.875 L / D. The
  // tolerance is needed because the first and last means, where the jerk is largest, are not counted.
  EXPECT_NEAR(motion.log_jerk, std::log(720 / (1.875 * 1.875)), 0.08);
  EXPECT_NEAR(motion.path, k_length, 1e-6);
  EXPECT_NEAR(motion.peak_speed, 1.875 * k_length / k_seconds, 0.01);
  EXPECT_NEAR(motion.mean_speed, k_length / k_seconds, 0.01);
  // A tremor of 8 Hz and 0.3 mm raises the jerk.
  const HandMotion tremor = shaky.stats.hand(0);
  EXPECT_GT(tremor.log_jerk, motion.log_jerk + 3);
  EXPECT_GT(tremor.jerk, 5 * motion.jerk);
  EXPECT_GT(tremor.path, motion.path + 5);
  // Smoothness does not depend on length and duration.
  Feed faster(1000);
  faster.play(2, [](double t) { return dvec3(0, 20 * minimum_jerk(t / 2), 0); });
  EXPECT_NEAR(faster.stats.hand(0).log_jerk, motion.log_jerk, 0.1);
}

TEST(MotionStats, StopsAreIdleAndStrokesHaveTheirLengths) {
  Feed feed(1000);
  // Strokes of 10, 20 and 30 mm at 20 mm/s. After each stroke the hand rests for one second.
  double at = 0;
  for (const double length : {10.0, 20.0, 30.0}) {
    feed.play(length / 20, [&](double t) { return dvec3(at + 20 * t, 0, 0); });
    at += length;
    feed.play(
        1, [&](double) { return dvec3(at, 0, 0); }, false);
  }
  const HandMotion motion = feed.stats.hand(0);
  EXPECT_NEAR(motion.seconds, 6, 1e-9);
  EXPECT_NEAR(motion.working_seconds, 3, 1e-9);
  EXPECT_NEAR(motion.idle_seconds, 3, 3 * 0.04) << "a pause is detected within two means (40 ms)";
  EXPECT_EQ(motion.strokes, 3);
  EXPECT_NEAR(motion.stroke_length, 20, 0.03);
  EXPECT_NEAR(motion.stroke_spread, std::sqrt(200.0 / 3), 0.05);
  EXPECT_NEAR(motion.path, 60, 0.1);
  EXPECT_LE(motion.peak_speed, 20.001);
  // A moving hand without its button is neither idle nor at work.
  Feed moving(1000);
  moving.play(
      2, [](double t) { return dvec3(30 * t, 0, 0); }, false);
  EXPECT_EQ(moving.stats.hand(0).idle_seconds, 0);
  EXPECT_EQ(moving.stats.hand(0).working_seconds, 0);
  EXPECT_EQ(moving.stats.hand(0).strokes, 0);
}

TEST(MotionStats, ForcesCountWhereTheyActAndNearStructures) {
  Feed feed(1000);
  for (int i = 0; i < 1000; ++i) {
    const double force = i < 500 ? 0 : i < 750 ? 1 : 3, clearance = i < 600 ? 10 : 2.9;
    feed.add(dvec3(0), false, force, clearance);
  }
  const HandMotion motion = feed.stats.hand(0);
  EXPECT_NEAR(motion.mean_force, 2, 1e-9);
  EXPECT_EQ(motion.peak_force, 3);
  EXPECT_NEAR(motion.near_seconds, 0.4, 1e-9);
  EXPECT_NEAR(motion.near_force_seconds, 0.25, 1e-9);
}

TEST(MotionStats, AGapIsNotAMotion) {
  Feed feed(1000);
  feed.play(1, [](double t) { return dvec3(10 * t, 0, 0); });
  feed.tick += 500;
  feed.play(1, [](double t) { return dvec3(1000 + 10 * t, 0, 0); });
  HandMotion motion = feed.stats.hand(0);
  EXPECT_NEAR(motion.path, 20, 0.05);
  EXPECT_LT(motion.peak_speed, 10.001);
  EXPECT_EQ(motion.strokes, 2);
  // A pose that is not finite is a gap, too.
  feed.add(dvec3(std::nan(""), 0, 0));
  feed.play(1, [](double) { return dvec3(0); });
  motion = feed.stats.hand(0);
  EXPECT_NEAR(motion.path, 20, 0.05);
  EXPECT_EQ(motion.strokes, 3);
  EXPECT_TRUE(std::isfinite(motion.jerk));
}

/// A jump of the mouse's tool to another position is not a motion at 300 m/s.
TEST(MotionStats, AJumpIsNotAMotion) {
  Feed feed(1000);
  feed.play(1, [](double t) { return dvec3(10 * t, 0, 0); });
  feed.play(1, [](double t) { return dvec3(300 + 10 * t, 0, 0); });
  HandMotion motion = feed.stats.hand(0);
  EXPECT_NEAR(motion.path, 20, 0.05);
  EXPECT_LT(motion.peak_speed, 10.001);
  // A fast hand is not a jump.
  feed.play(0.2, [](double t) { return dvec3(310 + 2000 * t, 0, 0); });
  motion = feed.stats.hand(0);
  EXPECT_NEAR(motion.peak_speed, 2000, 20);
}

TEST(MotionStats, TheTotalIsThatOfAllHands) {
  Feed feed(1000, 2);
  for (int i = 0; i < 1000; ++i) {
    feed.add(dvec3(0.01 * i, 0, 0), true, 1, 20, 0);
    --feed.tick;
    feed.add(dvec3(0, 0.03 * i, 0), false, 3, 20, 1);
  }
  const HandMotion first = feed.stats.hand(0), second = feed.stats.hand(1), total = feed.stats.total();
  EXPECT_NEAR(total.path, first.path + second.path, 1e-9);
  EXPECT_NEAR(total.seconds, 2, 1e-9);
  EXPECT_NEAR(total.mean_force, 2, 1e-9);
  EXPECT_EQ(total.peak_force, 3);
  EXPECT_EQ(total.peak_speed, second.peak_speed);
  EXPECT_EQ(total.strokes, 1);
  EXPECT_EQ(total.working_seconds, 1);
}

TEST(MotionStats, WithoutTicksEverythingIsZero) {
  const HandMotion motion = MotionStats(1, 1e-3).total();
  EXPECT_EQ(motion.seconds, 0);
  EXPECT_EQ(motion.mean_speed, 0);
  EXPECT_EQ(motion.stroke_spread, 0);
  EXPECT_EQ(motion.log_jerk, 0);
}

TEST(MotionStats, AStraightStrokeOfConstantSpeedHasNoSmoothness) {
  Feed feed(500);
  feed.play(2, [](double t) { return dvec3(11.3 * t, 2.7 * t, 0.1); });
  feed.add(dvec3(0), false);
  const HandMotion motion = feed.stats.hand(0);
  EXPECT_EQ(motion.strokes, 1);
  EXPECT_EQ(motion.measured_strokes, 0) << motion.log_jerk;
}

}  // namespace
}  // namespace trephine::workbench
