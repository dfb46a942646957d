// ForceParts: the parts of a tick's force add up to this force, and each part is the contribution of its
// cause.
#include "haptics/servo/force_parts.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

#include "haptics/force/effects.h"
#include "haptics/proxy/shell_proxy.h"
#include "haptics/proxy/subvoxel_proxy.h"
#include "haptics/tool/point_shell.h"
#include "tests/haptics/servo/servo_fixture.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;
using Kind = ForcePart::Kind;

std::shared_ptr<const LawSet> laws_of(std::initializer_list<const char*> texts) {
  auto laws = std::make_shared<LawSet>();
  std::uint32_t id = 1;
  for (const char* text : texts) {
    ServoLaw law = law_of(parse_effect(text).value(), id++).value();
    law.words = text;
    EXPECT_FALSE(laws->add(std::move(law)));
  }
  return laws;
}

dvec3 force_of(const ForceParts& parts, Kind kind) {
  dvec3 sum(0);
  for (const ForcePart& part : parts.parts)
    if (part.kind == kind) sum += part.wrench.force_world;
  return sum;
}

data_tools::PhantomOptions flat(int size) {
  data_tools::PhantomOptions o = phantom_options(size);
  o.parameters = {{"angle", 0}};
  return o;
}

/// A plane at z = 0 without friction, K = 0.5 N/mm, touched by a point.
class ForcePartsOnAPlane : public testing::Test {
 protected:
  ForcePartsOnAPlane() : scene_(scenes::phantom_scene("plane", flat(32))) {
    scene_.items[0].material = {0.5, 0.001, 0, 0};
  }
  void prepare(std::shared_ptr<const LawSet> laws = nullptr) {
    ASSERT_FALSE(method_.prepare(scene_));
    servo_scene_ = scene_for_one(scene_, method_, std::make_shared<volume::Version>(scene_.base), laws);
  }
  /// Moves from z = 20 mm down to `at` in 100 ticks, and stays there for 500 ticks. Returns the force parts
  /// of the last tick.
  ForceParts rest(const dvec3& at, const ForceOptions& options = {}) {
    ServoCore core(options, 1e-3);
    ForceParts parts;
    for (int i = 0; i < 600; ++i) {
      const double share = std::min(1.0, i / 100.0);
      ServoInput input;
      input.pose.position_world = (1 - share) * dvec3(at.x, at.y, 20) + share * at;
      if (i == 599) parts = force_parts(core, servo_scene_, input);
      core.step(servo_scene_, input);
    }
    return parts;
  }
  TouchScene scene_;
  SubvoxelProxy method_;
  ServoScene servo_scene_;
};

TEST_F(ForcePartsOnAPlane, AtRestThereIsOnlyTheSpring) {
  prepare();
  const ForceParts parts = rest({1, 2, -2});
  ASSERT_EQ(parts.parts.size(), 1u);
  EXPECT_EQ(parts.parts[0].kind, Kind::spring);
  EXPECT_NEAR(glm::length(parts.parts[0].wrench.force_world), 1, 0.03) << "2 mm at 0.5 N/mm";
  EXPECT_EQ(parts.stiffness, 0.5);
  EXPECT_LT(parts.friction_ratio(), 0.02);
}

TEST_F(ForcePartsOnAPlane, EachEffectHasItsPart) {
  prepare(laws_of({"constant force=0,0.7,0 most=3", "spring anchor=1,2,10 stiffness=0.1 most=3"}));
  const ForceParts parts = rest({1, 2, -2});
  std::vector<ForcePart> effects;
  for (const ForcePart& part : parts.parts)
    if (part.kind == Kind::effect) effects.push_back(part);
  ASSERT_EQ(effects.size(), 2u);
  EXPECT_TRUE(effects[0].name.starts_with("constant ")) << effects[0].name;
  EXPECT_NEAR(glm::distance(effects[0].wrench.force_world, dvec3(0, 0.7, 0)), 0, 1e-9);
  EXPECT_NEAR(glm::distance(effects[1].wrench.force_world, dvec3(0, 0, 1.2)), 0, 1e-9) << "12 mm at 0.1 N/mm";
}

TEST_F(ForcePartsOnAPlane, ALimitIsAPart) {
  prepare();
  ForceOptions options;
  options.force_limit = 0.6;
  const ForceParts parts = rest({1, 2, -2}, options);
  EXPECT_NEAR(glm::length(force_of(parts, Kind::spring)), 1, 0.03);
  EXPECT_NEAR(glm::length(force_of(parts, Kind::limits) + force_of(parts, Kind::transition)), 0.4, 0.03);
}

TEST_F(ForcePartsOnAPlane, FrictionIsTheSlopeOfTheSpring) {
  scene_.items[0].material.static_friction = 0.5;
  scene_.items[0].material.dynamic_friction = 0.3;
  prepare();
  ServoCore core({}, 1e-3);
  ForceParts parts;
  for (int i = 0; i < 900; ++i) {
    ServoInput input;
    input.pose.position_world = {i < 400 ? 0 : 0.02 * (i - 400), 0, std::max(-2.0, 20 - 0.1 * i)};
    if (i == 899) parts = force_parts(core, servo_scene_, input);
    core.step(servo_scene_, input);
  }
  EXPECT_NEAR(parts.friction_ratio(), 0.3, 0.02) << "the proxy slides";
  EXPECT_EQ(parts.material.dynamic_friction, 0.3);
}

/// Random motions with effects, friction, limits, resets and faults, on surfaces and in the air.
TEST(ForceParts, AddUpToTheForceOfEachTick) {
  std::mt19937 random(7);
  const auto between = [&](double a, double b) { return a + (b - a) * (double(random()) / 4294967296.0); };
  data_tools::PhantomOptions o = phantom_options(40);
  o.parameters = {{"radius", 15}};
  TouchScene scene = scenes::phantom_scene("sphere", o);
  scene.items[0].material = {1.5, 0.002, 0.4, 0.3};
  SubvoxelProxy method;
  ASSERT_FALSE(method.prepare(scene));
  const ServoScene servo_scene =
      scene_for_one(scene, method, std::make_shared<volume::Version>(scene.base),
                    laws_of({"viscous damping=0.01 most=2",
                             "vibration direction=0,1,0 amplitude=0.4 frequency=120 most=2"}));
  ForceOptions options;
  options.is_passive = true;
  options.force_limit = 3;
  ServoCore core(options, 1e-3);
  dvec3 hand(0, 0, 30), motion(0);
  double worst = 0, largest_energy = 0;
  int touching = 0;
  for (int tick = 0; tick < 3000; ++tick) {
    if (tick % 40 == 0)
      motion = (dvec3(between(-20, 20), between(-20, 20), between(-20, 25)) - hand) / between(40, 160);
    hand += motion;
    ServoInput input;
    input.pose.position_world = hand;
    input.pose.buttons = tick % 300 < 150;
    input.is_reset = tick % 701 == 700;
    if (tick % 997 == 996) input.faults = fault_lost_device;
    const ForceParts parts = force_parts(core, servo_scene, input);
    const ServoRecord record = core.step(servo_scene, input);
    ASSERT_EQ(parts.record.force_world, record.force_world);
    dvec3 sum(0);
    for (const ForcePart& part : parts.parts) sum += part.wrench.force_world;
    worst = std::max(worst, glm::distance(sum, record.force_world));
    largest_energy = std::max(largest_energy, glm::length(force_of(parts, Kind::energy)));
    touching += record.has_contact;
  }
  EXPECT_GT(touching, 500);
  EXPECT_LT(worst, 1e-8) << "N";
  EXPECT_GT(largest_energy, 0.01) << "N: without this part the sum would differ";
}

/// A rod that is pressed on a plane and tilted.
TEST(ForceParts, TorquesAddUp) {
  TouchScene scene = scenes::phantom_scene("plane", flat(96));
  scene.items[0].material.stiffness = 1;
  ASSERT_FALSE(set_tool(
      scene,
      sample_surface(std::make_shared<const ToolShape>(ToolProfile{{{-15, 1.5}, {15, 1.5}}, 0.5})).value()));
  ShellProxy method;
  ASSERT_FALSE(method.prepare(scene));
  const ServoScene servo_scene = scene_for_one(scene, method, std::make_shared<volume::Version>(scene.base),
                                               laws_of({"viscous damping=0.01"}));
  ForceOptions options;
  options.is_passive = true;
  options.torque_limit = 1;
  ServoCore core(options, 1e-3);
  double worst = 0, largest = 0;
  for (int i = 0; i < 800; ++i) {
    ServoInput input;
    input.pose.position_world = {0, 0, std::max(-0.5, 20 - 0.1 * i)};
    const double tilt = 0.05 * std::sin(0.2 * i);
    input.pose.orientation = rotation_of({0, tilt, 0}) * rotation_of({0, 0.5 * 3.14159265358979, 0});
    const ForceParts parts = force_parts(core, servo_scene, input);
    core.step(servo_scene, input);
    Wrench sum;
    for (const ForcePart& part : parts.parts) {
      sum.force_world += part.wrench.force_world, sum.torque_world += part.wrench.torque_world;
      if (part.kind == Kind::limits) largest = std::max(largest, glm::length(part.wrench.torque_world));
    }
    worst = std::max({worst, glm::distance(sum.force_world, parts.record.force_world),
                      glm::distance(sum.torque_world, parts.record.torque_world)});
  }
  EXPECT_LT(worst, 1e-7) << "N, N mm";
  EXPECT_GT(largest, 0.5) << "N mm: the torque limit contributes a part";
}

}  // namespace
}  // namespace trephine::haptics
