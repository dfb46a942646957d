// Virtual couplings of 3 and 6 degrees of freedom, and limits of devices.
#include "haptics/force/coupling.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace trephine::haptics {
namespace {

using glm::dvec3;

constexpr double k_dt = 1e-3;

void expect_near(const dvec3& a, const dvec3& b, double within) { EXPECT_LT(glm::length(a - b), within); }

TEST(Coupling, IsTheStiffestForTheDeviceAndMatchesThePublishedExample) {
  const Coupling c = critical_coupling(0.025, 0.008, 1000);
  EXPECT_NEAR(c.stiffness, 0.594, 0.001);  // 594 N/m
  EXPECT_NEAR(c.damping, 2 * std::sqrt(c.stiffness * 0.025 / 1000), 1e-12);
  EXPECT_NEAR(0.5e-3 * c.stiffness + c.damping, 0.008, 1e-12);
  EXPECT_DOUBLE_EQ(passive_stiffness(0.002, 0.001, 1000), 2);
  EXPECT_DOUBLE_EQ(passive_stiffness(0.002, 0.003, 1000), 0);
  // Critically damped: after a jump of the hand the tool reaches it without overshoot, within a few periods.
  for (const double mass : {0.002, 0.025, 0.2}) {
    const Coupling k = critical_coupling(mass, 0.02, 1000);
    VirtualCoupling tool(k, mass, k_dt);
    tool.step({0, 0, 0}, {});
    double farthest = 0;
    dvec3 at;
    for (int i = 0; i < 3000; ++i) {
      at = tool.step({10, 0, 0}, {});
      if (i > 5) farthest = std::max(farthest, at.x);
    }
    // The damper follows the hand's velocity: a jump makes the tool overshoot once, by less than a fifth.
    EXPECT_LT(farthest, 12) << mass;
    EXPECT_NEAR(at.x, 10, 1e-6);
    // At rest the hand receives the force on the tool.
    for (int i = 0; i < 3000; ++i) tool.step({10, 0, 0}, dvec3(0, 0, 1));
    expect_near(tool.on_hand().force_world, {0, 0, 1}, 1e-6);
    expect_near(tool.tool_world(), {10, 0, 1 / k.stiffness}, 1e-6);
  }
}

/// Wrench on a rod of balls, held at its middle, above a floor at z = 0 of a stiffness (N/mm).
Wrench floor_on_rod(const VirtualCoupling& tool, double stiffness) {
  Wrench sum;
  for (int k = -4; k <= 4; ++k) {
    const dvec3 arm = tool.tool_orientation() * dvec3(5 * k, 0, 0);
    const double depth = 1 - (tool.tool_world() + arm).z;  // for a ball of 1 mm
    if (depth <= 0) continue;
    const dvec3 force(0, 0, stiffness * depth);
    sum.force_world += force;
    sum.torque_world += glm::cross(arm, force);
  }
  return sum;
}

// 6 degrees of freedom: a rod is pressed down, flat and tilted, and turned.
TEST(Coupling, AHeldRodIsPressedTurnedAndPassive) {
  const Coupling along = critical_coupling(0.05, 0.02, 1000);
  const RotationalCoupling turning{30, 200, 5};  // a rod of 50 g and 40 mm has 6.7 kg mm2, plus a handle
  constexpr double k_floor = 0.5;
  for (const double tilt : {0.0, 0.1, -0.3}) {
    VirtualCoupling tool(along, 0.05, k_dt, turning);
    const glm::dquat held(std::cos(tilt / 2), 0, std::sin(tilt / 2), 0);
    Wrench on_tool;
    for (int i = 0; i < 6000; ++i) {
      const dvec3 hand(0, 0, std::max(-1.0, 8 - 0.01 * i));
      tool.step(hand, on_tool, held);
      on_tool = floor_on_rod(tool, k_floor);
    }
    // At rest the hand receives the wrench on the rod, by the statics of a rigid body.
    EXPECT_GT(on_tool.force_world.z, 0.1) << tilt;
    expect_near(tool.on_hand().force_world, on_tool.force_world, 1e-6);
    expect_near(tool.on_hand().torque_world, on_tool.torque_world, 1e-5);
    if (tilt == 0) {
      expect_near(on_tool.torque_world, {0, 0, 0}, 1e-6);
    } else {
      EXPECT_LT(on_tool.torque_world.y * tilt, -0.1);  // it is turned flat
    }
  }
  // Along a closed path it gives the hand no energy.
  VirtualCoupling tool(along, 0.05, k_dt, turning);
  Wrench on_tool;
  dvec3 last(0, 0, 3);
  glm::dquat last_turn(1, 0, 0, 0);
  double given = 0;
  for (int i = 0; i <= 20000; ++i) {
    const double t = 1e-3 * i, a = 0.4 * std::sin(3.1415926535897931 * t);
    const dvec3 hand(4 * std::sin(6.283185307179586 * t), 0, 3 * std::cos(3.1415926535897931 * t));
    const glm::dquat turn(std::cos(a / 2), 0, std::sin(a / 2), 0);
    given += glm::dot(tool.on_hand().force_world, hand - last) +
             glm::dot(tool.on_hand().torque_world, turn_between(last_turn, turn));
    tool.step(hand, on_tool, turn);
    on_tool = floor_on_rod(tool, k_floor);
    last = hand, last_turn = turn;
    ASSERT_TRUE(std::isfinite(glm::length(tool.on_hand().torque_world)));
    ASSERT_LT(glm::length(tool.on_hand().torque_world), 200);
  }
  EXPECT_LT(given, 0);
}

TEST(Coupling, DevicesLimitForceSlewAndStiffness) {
  DeviceCapabilities small{"small", 3, 3.3, 0.6, 80, 500, 0.05, 0.002};
  const ForceOptions f = within_limits(ForceOptions{}, small);
  EXPECT_EQ(f.force_limit, 3.3);
  EXPECT_EQ(f.slew_limit, 500);
  EXPECT_EQ(within_limits(Material{2, 0, 0, 0}, small).stiffness, 0.6);
  EXPECT_EQ(within_limits(Material{0.4, 0, 0, 0}, small).stiffness, 0.4);
  const DeviceCapabilities silent{"mouse", 3, 0, 0, 1e3};
  EXPECT_EQ(within_limits(ForceOptions{}, silent).force_limit, ForceOptions{}.force_limit);
}

}  // namespace
}  // namespace trephine::haptics
