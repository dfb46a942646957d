// Single ticks of a servo core: invalid poses and faults give no force, and release the button.
#include "haptics/servo/servo_core.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <limits>

#include "haptics/proxy/implicit_proxy.h"
#include "tests/haptics/servo/servo_fixture.h"

namespace trephine::haptics {
namespace {

TEST(ServoCore, ForceIsFiniteAndLatchedOnBadPoses) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  const auto owner = servo_scene_of(scene, method);
  const ServoScene& seen = *owner;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e300}) {
    ServoCore core({}, 1e-3);
    core.step(seen, {{{0, 0, 60}}});
    for (int i = 0; i < 100; ++i) core.step(seen, {{{0, 0, 40}}});
    ServoRecord r = core.step(seen, {{{0, bad, 40}}});
    EXPECT_EQ(r.force_world, glm::dvec3(0));
    r = core.step(seen, {{{0, 0, 40}}});
    EXPECT_EQ(r.force_world, glm::dvec3(0));
    EXPECT_TRUE(r.faults & fault_not_finite);
  }
}

TEST(ServoCore, ANonFiniteOrientationOrAxisIsAFaultAndGoesNoFarther) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  const auto seen = servo_scene_of(scene, method);
  const double bad = std::nan("");
  Pose turned{{0, 0, 60}, {1, bad, 0, 0}}, squeezed{{0, 0, 60}};
  squeezed.axes[2] = std::numeric_limits<float>::infinity();
  for (const Pose& pose : {turned, squeezed}) {
    ServoCore core({}, 1e-3);
    EXPECT_EQ(core.step(*seen, {{{0, 0, 60}}}).faults, 0u);
    const ServoRecord r = core.step(*seen, {pose});
    EXPECT_TRUE(r.faults & fault_not_finite);
    EXPECT_EQ(r.pose.orientation, glm::dquat(1, 0, 0, 0));
    EXPECT_EQ(r.pose.axes, (std::array<float, 4>{}));
    EXPECT_EQ(r.pose.buttons, 0u);
  }
}

TEST(ServoCore, TheButtonIsReleasedDuringAFault) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  const auto owner = servo_scene_of(scene, method);
  const ServoScene& seen = *owner;
  ServoCore core({}, 1e-3);
  EXPECT_TRUE(core.step(seen, {{{0, 0, 50}}}).pose.is_pressed());
  EXPECT_FALSE(core.step(seen, {{{0, 0, 40}}, fault_lost_device}).pose.is_pressed());
  EXPECT_FALSE(core.step(seen, {{{0, 0, 40}}}).pose.is_pressed());
  core.reset();
  EXPECT_TRUE(core.step(seen, {{{0, 0, 50}}}).pose.is_pressed());
}

}  // namespace
}  // namespace trephine::haptics
