// LayerContact: force and torque compared with integrals over the tool's surface of pressures at depths that
// have a formula; its tree compared with a test of all points.
#include "haptics/proxy/layer_contact.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

#include "apps/bench/scenes/scenes.h"
#include "haptics/baselines/voxel_sampling.h"
#include "tests/haptics/proxy/shell_fixture.h"
#include "volume/cuts/removal.h"

namespace trephine::haptics::layer_tests {
namespace {

using glm::dquat;
using glm::dvec3;

constexpr double k_pi = 3.14159265358979;

/// A solid whose depth (mm, positive inside) and outward normal have a formula.
struct Solid {
  std::function<double(const dvec3&)> depth;
  std::function<dvec3(const dvec3&)> outward;
};
Solid half_space(const dvec3& normal) {
  return {[=](const dvec3& p) { return -glm::dot(p, normal); }, [=](const dvec3&) { return normal; }};
}
/// Matter outside of a cylinder through the origin.
Solid hole(const dvec3& axis, double radius) {
  const auto across = [=](const dvec3& p) { return p - glm::dot(p, axis) * axis; };
  return {[=](const dvec3& p) { return glm::length(across(p)) - radius; },
          [=](const dvec3& p) { return -glm::normalize(across(p)); }};
}
TouchScene scene_of(const Solid& solid, double half_size, double spacing) {
  return scenes::scene_of(
      scenes::sampled(dvec3(-half_size), dvec3(half_size), dvec3(spacing),
                      [&](const dvec3& p) { return 300 + 400 * std::clamp(solid.depth(p), -2.0, 2.0); }));
}

SharedShell rod_shell(const Rod& rod, double spacing) {
  return PointShell::of_profile({{{rod.low, rod.radius}, {rod.high, rod.radius}}, spacing},
                                PointShell::Areas::computed)
      .value();
}
SharedShell ball_shell(double radius, double spacing) {
  ToolProfile profile;
  profile.spacing = spacing;
  constexpr int k_rings = 100;
  for (int i = 0; i <= k_rings; ++i) {
    const double angle = k_pi * (0.01 + 0.98 * i / k_rings);
    profile.rings.push_back({-radius * std::cos(angle), radius * std::sin(angle)});
  }
  return PointShell::of_profile(profile, PointShell::Areas::computed).value();
}

/// Integrates the pressure over the surface of a rod, with 300 x 300 elements of its side and of its ends.
Wrench integral_over(const Rod& rod, const Placement& tool, const Solid& solid, const LayerContact& contact) {
  Wrench sum;
  const auto add = [&](const dvec3& local, double area) {
    const dvec3 arm = tool.rotation * local, p = tool.position_world + arm;
    const dvec3 push = area * contact.pressure(solid.depth(p)) * solid.outward(p);
    sum.force_world += push;
    sum.torque_world += glm::cross(arm, push);
  };
  constexpr int k_parts = 300;
  for (int i = 0; i < k_parts; ++i)
    for (int j = 0; j < k_parts; ++j) {
      const double angle = 2 * k_pi * (i + 0.5) / k_parts, share = (j + 0.5) / k_parts;
      const dvec3 out(std::cos(angle), std::sin(angle), 0);
      add(rod.radius * out + dvec3(0, 0, rod.low + share * (rod.high - rod.low)),
          2 * k_pi * rod.radius / k_parts * (rod.high - rod.low) / k_parts);
      const double r = share * rod.radius, area = 2 * k_pi * r / k_parts * rod.radius / k_parts;
      for (const double end : {rod.low, rod.high}) add(r * out + dvec3(0, 0, end), area);
    }
  return sum;
}

double between(std::mt19937& random, double a, double b) {
  return a + (b - a) * (double(random()) / 4294967296.0);
}

// The area of a spherical cap is proportional to its height, so the force of a pressed ball has a formula.
TEST(LayerContact, ABallOnAPlaneHasTheForceOfTheFormula) {
  const dvec3 normal = glm::normalize(dvec3(0.3, -0.2, 0.9));
  const Solid solid = half_space(normal);
  const TouchScene scene = scene_of(solid, 12, 0.5);
  const TouchState state(uncut_version(scene));
  std::mt19937 random(1);
  double worst = 0, worst_torque = 0;
  for (const double spacing : {0.25, 0.15}) {
    const SharedShell shell = ball_shell(3, spacing);
    for (const double press : {0.3, 0.5, 0.8}) {
      const LayerContact contact(scene, state, *shell, {.stiffness = 0.2, .layer_mm = 0.25, .deepest_mm = 1});
      const double layer = 0.25, force = 2 * k_pi * 3 * 0.2 *
                                         (2 * layer * layer / 3 + 0.5 * (press * press - layer * layer));
      for (int n = 0; n < 20; ++n) {
        const dvec3 aside = glm::cross(normal, dvec3(between(random, -3, 3), between(random, -3, 3), 1));
        const Placement tool{(3 - press) * normal + aside,
                             glm::normalize(dquat(1, between(random, -1, 1), between(random, -1, 1), 0.3))};
        const PoseForce found = contact.contact(tool);
        worst = std::max(worst, glm::length(found.on_tool.force_world - force * normal) / force);
        worst_torque = std::max(worst_torque, glm::length(found.on_tool.torque_world) / (3 * force));
      }
    }
  }
  EXPECT_LT(worst, 0.03);
  EXPECT_LT(worst_torque, 0.02);
  RecordProperty("force_percent", std::to_string(100 * worst));
  RecordProperty("torque_percent", std::to_string(100 * worst_torque));
}

// A peg that is pressed aside and tilted in a hole, oblique to the axes of the voxels.
TEST(LayerContact, APegInAHoleHasTheForceAndTorqueOfTheIntegral) {
  const dvec3 axis = glm::normalize(dvec3(0.4, 0.3, 1));
  const Solid solid = hole(axis, 6);
  const TouchScene scene = scene_of(solid, 14, 0.5);
  const TouchState state(uncut_version(scene));
  const Rod rod{-6, 6, 5};
  const SharedShell shell = rod_shell(rod, 0.25);
  const LayerContact contact(scene, state, *shell, {.stiffness = 0.2, .layer_mm = 0.25, .deepest_mm = 1.2});
  const dvec3 across = glm::normalize(glm::cross(axis, dvec3(1, 0.2, 0)));
  const dquat upright(dvec3(0, 0, 1), axis);
  double worst = 0, worst_torque = 0;
  for (const double press : {1.3, 1.6, 1.8})
    for (const double tilt : {0.0, 0.03}) {
      const Placement tool{press * across, rotation_of(tilt * glm::cross(axis, across)) * upright};
      const Wrench found = contact.contact(tool).on_tool, expected = integral_over(rod, tool, solid, contact);
      const double force = glm::length(expected.force_world);
      EXPECT_GT(force, 0.3);
      worst = std::max(worst, glm::length(found.force_world - expected.force_world) / force);
      worst_torque = std::max(worst_torque,
                              glm::length(found.torque_world - expected.torque_world) / (rod.high * force));
    }
  EXPECT_LT(worst, 0.02);
  EXPECT_LT(worst_torque, 0.01);
  RecordProperty("force_percent", std::to_string(100 * worst));
  RecordProperty("torque_percent", std::to_string(100 * worst_torque));
}

// A rod slides over an oblique plane in steps of 0.02 mm: its force does not jump where points cross borders
// of voxels. The published tangent planes jump.
TEST(LayerContact, TheForceDoesNotJumpAtBordersOfVoxels) {
  const dvec3 normal = glm::normalize(dvec3(0.2, 0.1, 1));
  const TouchScene scene = scene_of(half_space(normal), 16, 0.5);
  const TouchState state(uncut_version(scene));
  const SharedShell shell = rod_shell({-6, 6, 2}, 0.25);
  const LayerContact ours(scene, state, *shell, {.stiffness = 0.2, .layer_mm = 0.25, .deepest_mm = 1});
  const auto map = baselines::VoxMap::of(*scene.items[0].bits, scene.base->frame, 1);
  const baselines::VoxelSampling published(map, *shell, {.stiffness = 0.5, .averaging_threshold = 10});
  const dvec3 along = glm::normalize(glm::cross(normal, dvec3(0.3, -0.8, 0.1)));
  const dquat lying(dvec3(0, 0, 1), along);
  const dvec3 motion = 0.02 * glm::normalize(along + 0.4 * glm::cross(normal, along));
  const auto jump_of = [&](const PoseContact& contact, double height) {
    double before = 0, jump = 0, sum = 0;
    for (int i = 0; i < 250; ++i) {
      const double force =
          glm::length(contact.contact({height * normal + double(i) * motion, lying}).on_tool.force_world);
      if (i > 0) jump = std::max(jump, std::abs(force - before));
      before = force, sum += force / 250;
    }
    EXPECT_GT(sum, 0.1);
    return jump / sum;
  };
  const double our_jump = jump_of(ours, 1.6), published_jump = jump_of(published, 1.8);
  EXPECT_LT(our_jump, 0.01);
  EXPECT_GT(published_jump, 3 * our_jump);
  RecordProperty("jump_percent", std::to_string(100 * our_jump));
  RecordProperty("published_jump_percent", std::to_string(100 * published_jump));
}

TEST(LayerContact, TheTreeChangesNoBit) {
  std::mt19937 random(5);
  // Noise has surfaces in all directions, thin walls and lone voxels.
  const TouchScene scene =
      scenes::scene_of(scenes::sampled(dvec3(-14), dvec3(14), dvec3(0.7, 0.7, 1.1), [&](const dvec3& p) {
        return -100 * p.z + between(random, -500, 500);
      }));
  volume::RemovalEditor editor(uncut_version(scene), solids_of(scene));
  editor.remove(volume::Sweep{dvec3(-3, 0, 8), dvec3(2, 1, -8), 2.2, false});
  editor.end_stroke();
  const TouchState state(editor.publish());
  const SharedShell shell = rod_shell(k_shaft, 0.35);
  const LayerContact contact(scene, state, *shell, {.stiffness = 0.2, .layer_mm = 0.3, .deepest_mm = 1});
  int touching = 0;
  long tree_tests = 0, all_tests = 0;
  for (int n = 0; n < 400; ++n) {
    const Placement tool{{between(random, -9, 9), between(random, -9, 9), between(random, -4, 12)},
                         glm::normalize(dquat(1, between(random, -1, 1), between(random, -1, 1), 0.2))};
    const PoseForce fast = contact.contact(tool), slow = contact.contact(tool, false);
    ASSERT_EQ(fast.on_tool.force_world, slow.on_tool.force_world) << n;  // to the bit
    ASSERT_EQ(fast.on_tool.torque_world, slow.on_tool.torque_world) << n;
    ASSERT_EQ(fast.points, slow.points);
    ASSERT_EQ(fast.interior, slow.interior);
    ASSERT_TRUE(std::isfinite(glm::length(fast.on_tool.force_world)));
    touching += fast.points > 0;
    tree_tests += fast.tests, all_tests += slow.tests;
  }
  EXPECT_GT(touching, 100);
  EXPECT_LT(tree_tests, all_tests);
}

// A drilled hole pushes as a hole of the scan does.
TEST(LayerContact, ADrilledHolePushesTheShaft) {
  const TouchScene scene = scene_of(half_space({0, 0, 1}), 14, 0.5);
  volume::RemovalEditor editor(uncut_version(scene), solids_of(scene));
  editor.remove(volume::Sweep{dvec3(0, 0, 6), dvec3(0, 0, -20), 3, false});
  editor.end_stroke();
  const TouchState state(editor.publish());
  const Rod rod{-5, 5, 2.6};
  const SharedShell shell = rod_shell(rod, 0.2);
  const LayerContact contact(scene, state, *shell, {.stiffness = 0.2, .layer_mm = 0.2, .deepest_mm = 1});
  const Placement tool{{0.6, 0.3, -6}, {1, 0, 0, 0}};
  const Wrench found = contact.contact(tool).on_tool,
               expected = integral_over(rod, tool, hole({0, 0, 1}, 3), contact);
  EXPECT_LT(glm::length(found.force_world - expected.force_world), 0.06 * glm::length(expected.force_world));
  EXPECT_GT(glm::length(expected.force_world), 0.3);
}

// On a virtual coupling, a pressed rod comes to rest where contact and coupling are in balance.
TEST(LayerContact, APressedRodComesToRest) {
  const TouchScene scene = scene_of(half_space({0, 0, 1}), 14, 0.5);
  const TouchState state(uncut_version(scene));
  const SharedShell shell = rod_shell({-6, 6, 2}, 0.3);
  const LayerContact contact(scene, state, *shell, {.stiffness = 0.2, .layer_mm = 0.25, .deepest_mm = 1});
  baselines::DynamicTool::Options options;
  options.integrator = baselines::Integrator::implicit;
  baselines::DynamicTool tool(contact, options, 1e-3);
  const dquat lying(dvec3(0, 0, 1), glm::normalize(dvec3(1, 0.1, 0)));
  double before = 0, change = 0;
  for (int i = 0; i < 3000; ++i) {
    tool.step({{0, 0, std::max(0.5, 4 - 0.005 * i)}, lying});
    const double force = tool.on_hand().force_world.z;
    if (i > 2500) change = std::max(change, std::abs(force - before));
    before = force;
  }
  EXPECT_EQ(tool.contact().interior, 0);
  EXPECT_NEAR(tool.contact().on_tool.force_world.z, before, 1e-3);
  EXPECT_GT(before, 0.5);
  EXPECT_LT(change, 1e-4);
}

}  // namespace
}  // namespace trephine::haptics::layer_tests
