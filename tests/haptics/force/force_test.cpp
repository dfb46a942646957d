#include "haptics/force/force.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <limits>

#include "apps/bench/scenes/scenes.h"
#include "haptics/device/device.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

ProxyStep contact_at(const dvec3& proxy) {
  ProxyStep s;
  s.has_contact = true;
  s.proxy_world = proxy;
  s.normal_world = {0, 0, 1};
  s.shape = 0;
  s.side = Side::front;
  return s;
}

TouchScene one_shape() {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(8);
  return scenes::phantom_scene("sphere", o);
}

TEST(ForceModel, SpringIsExactAtRestAndSmoothingFollowsTheFormula) {
  const TouchScene scene = one_shape();
  ForceModel model({}, 1e-3);
  EXPECT_DOUBLE_EQ(model.alpha(), 0.3);
  double expected = 0;
  for (int i = 0; i < 60; ++i) {
    const dvec3 f = model.step(contact_at({0, 0, 2}), {0, 0, 0}, scene).force_world;
    expected = 0.3 * 1.0 + 0.7 * expected;
    ASSERT_NEAR(f.z, expected, 1e-12);
  }
  EXPECT_NEAR(expected, 1.0, 1e-6);  // 0.5 N/mm x 2 mm
}

TEST(ForceModel, DampingActsOnTheStretchOfTheSpring) {
  const TouchScene scene = one_shape();
  ForceOptions raw;
  raw.smoothing_alpha = 1;
  ForceModel model(raw, 1e-3);
  model.step(contact_at({0, 0, 0}), {0, 0, -1}, scene);
  const dvec3 f = model.step(contact_at({0, 0, 0}), {0, 0, -1.1}, scene).force_world;  // 100 mm/s inward
  EXPECT_NEAR(f.z, 0.5 * 1.1 + 0.001 * 100, 1e-12);
}

TEST(ForceModel, SmoothingHasTheSameTimeConstantAtAnyRate) {
  const TouchScene scene = one_shape();
  double after_20_ms[3];
  int i = 0;
  for (const double rate : {500.0, 1000.0, 10000.0}) {
    ForceModel model({}, 1 / rate);
    dvec3 f(0);
    for (int n = 0; n < static_cast<int>(0.02 * rate); ++n)
      f = model.step(contact_at({0, 0, 2}), {0, 0, 0}, scene).force_world;
    after_20_ms[i++] = f.z;
  }
  EXPECT_NEAR(after_20_ms[0], after_20_ms[1], 1e-12);
  EXPECT_NEAR(after_20_ms[2], after_20_ms[1], 1e-12);
}

TEST(ForceGuard, LimitsMagnitudeAndSlew) {
  ForceGuard guard({}, 1e-3);
  dvec3 last(0);
  for (int i = 0; i < 50; ++i) {
    const dvec3 f = guard.step(dvec3{0, 0, 100}, 0).force_world;
    ASSERT_LE(glm::length(f - last), 1.0 + 1e-12);
    ASSERT_LE(glm::length(f), 8 + 1e-12);
    last = f;
  }
  EXPECT_NEAR(last.z, 8, 1e-12);
  EXPECT_EQ(guard.faults(), fault_magnitude);
}

TEST(ForceGuard, NanGivesNoForceAndStaysLatched) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    ForceGuard guard({}, 1e-3);
    guard.step(dvec3{0, 0, 1}, 0);
    EXPECT_EQ(guard.step(dvec3{0, bad, 1}, 0).force_world, dvec3(0));
    EXPECT_EQ(guard.step(dvec3{0, 0, 1}, 0).force_world, dvec3(0));
    EXPECT_TRUE(guard.faults() & fault_not_finite);
    guard.reset();
    EXPECT_NEAR(guard.step(dvec3{0, 0, 1}, 0).force_world.z, 1, 1e-12);
    // A torque that is not finite also suppresses the force of its tick.
    EXPECT_TRUE(guard.step({{0, 0, 1}, {0, bad, 0}}, 0).is_zero());
    EXPECT_TRUE(guard.faults() & fault_not_finite);
  }
}

TEST(ForceGuard, ForceFadesOutAfterAFault) {
  for (const std::uint32_t fault : {fault_stale_scene, fault_lost_device, fault_full_ring}) {
    ForceGuard guard({}, 1e-3);
    for (int i = 0; i < 20; ++i) guard.step(dvec3{0, 0, 8}, 0);
    double last = 8;
    for (int i = 0; i < 51; ++i) {
      const double f = guard.step(dvec3{0, 0, 8}, i == 0 ? fault : 0).force_world.z;
      ASSERT_LE(f, last + 1e-12);
      last = f;
    }
    EXPECT_EQ(last, 0);
    EXPECT_EQ(guard.faults() & k_latched_faults, fault);
  }
}

TEST(VirtualDevice, HandSettlesWhereSpringAndForceBalance) {
  const PosePath request = PosePath::from_samples({{0, {{0, 0, 0}}}, {10, {{0, 0, 0}}}}, "test").value();
  HandModel hand;
  hand.encoder_step = 0;
  VirtualDevice device(request, hand);
  ASSERT_FALSE(device.open().has_value());
  Pose pose;
  for (int i = 0; i < 3000; ++i) {
    ASSERT_TRUE(device.read(i * 1e-3, pose));
    device.write(glm::dvec3(0, 0, 0.6));
  }
  EXPECT_NEAR(pose.position_world.z, 0.6 / hand.stiffness, 1e-6);
  EXPECT_LT(device.kinetic_energy(), 1e-12);
}

// A torque turns the hand until its spring balances it; without a torque the orientation is that of the path.
TEST(VirtualDevice, TorqueTurnsTheHand) {
  const glm::dquat tilted(std::cos(0.2), std::sin(0.2), 0, 0);
  const PosePath request =
      PosePath::from_samples({{0, {{0, 0, 0}, tilted}}, {10, {{0, 0, 0}, tilted}}}, "test").value();
  const HandModel hand;
  VirtualDevice device(request, hand);
  ASSERT_FALSE(device.open().has_value());
  Pose pose;
  for (int i = 0; i < 3000; ++i) {
    ASSERT_TRUE(device.read(i * 1e-3, pose));
    if (i < 500) {
      ASSERT_EQ(pose.orientation, request.at(i * 1e-3).orientation);
    }
    device.write({glm::dvec3(0), i < 500 ? glm::dvec3(0) : glm::dvec3(0, 0, 12)});
  }
  const glm::dvec3 turn = turn_between(tilted, pose.orientation);
  EXPECT_NEAR(turn.x, 0, 1e-6);
  EXPECT_NEAR(turn.z, 12 / (hand.stiffness * hand.grip * hand.grip), 1e-3);
  EXPECT_EQ(pose.position_world, glm::dvec3(0));
}

TEST(VirtualDevice, EncoderRoundsAndLossIsReported) {
  const PosePath request =
      PosePath::from_samples({{0, {{0.013, 0, 0}}}, {1, {{0.013, 0, 0}}}}, "test").value();
  VirtualDevice device(request, {});
  ASSERT_FALSE(device.open().has_value());
  Pose pose;
  ASSERT_TRUE(device.read(0, pose));
  EXPECT_DOUBLE_EQ(pose.position_world.x, 0.02);
  device.lose_at(0.5);
  EXPECT_TRUE(device.read(0.4, pose));
  EXPECT_FALSE(device.read(0.5, pose));
}

// A torque is limited in magnitude and slew, faded out after a fault, and set to 0 if it is not finite.
TEST(ForceGuard, TorquesAreGuardedLikeForces) {
  ForceOptions options;
  options.torque_limit = 100;
  options.torque_slew_limit = 10000;
  ForceGuard guard(options, 1e-3);
  EXPECT_TRUE(guard.last().is_zero());
  glm::dvec3 last(0);
  for (int i = 0; i < 40; ++i) {
    const glm::dvec3 torque = guard.step({dvec3(0), {0, 300, 0}}, 0).torque_world;
    ASSERT_LE(glm::length(torque), 100 * (1 + 1e-12));
    ASSERT_LE(glm::length(torque - last), 10 * (1 + 1e-9));
    last = torque;
  }
  EXPECT_NEAR(last.y, 100, 1e-9);
  EXPECT_TRUE(guard.faults() & fault_magnitude);
  // After the loss of the device, the torque is faded out.
  for (int i = 0; i < 60; ++i) {
    last = guard.step({dvec3(0), {0, 300, 0}}, i == 0 ? fault_lost_device : 0u).torque_world;
  }
  EXPECT_EQ(last, glm::dvec3(0));
  EXPECT_TRUE(guard.is_faded());
  guard.reset();
  EXPECT_EQ(guard.step({dvec3(0), {std::nan(""), 0, 0}}, 0).torque_world, dvec3(0));
  EXPECT_TRUE(guard.faults() & fault_not_finite);
}

}  // namespace
}  // namespace trephine::haptics
