// ShellProxy: force, torque, friction and energy of rods that touch solids whose distance has a formula.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "haptics/force/effects.h"
#include "haptics/servo/servo_core.h"
#include "tests/haptics/proxy/shell_fixture.h"
#include "tests/whole.h"

namespace trephine::haptics {
namespace {

using glm::dquat;
using glm::dvec3;

// A pressed rod slides over planes, in steps of 0.02 mm: its force changes little from step to step, also
// where its points cross borders of voxels.
TEST(ShellProxy, TheForceDoesNotJumpAtBordersOfVoxels) {
  double worst = 0, spread = 0;
  for (const double degrees : {0.0, 20.0}) {
    TouchScene scene = scene_with("plane", {{"angle", degrees}}, shell_of({-10, 10, 2}, 0.4),
                                  [](data_tools::PhantomOptions& o) { o.size = glm::ivec3(192); });
    scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = 0;
    const double angle = degrees * 3.14159265358979 / 180;
    const dvec3 normal(std::sin(angle), 0, std::cos(angle));
    const dvec3 along = glm::normalize(glm::cross(normal, dvec3(0.3, -0.8, 0.1)));
    const dquat lying(dvec3(0, 0, 1), along);
    ShellPlay run(scene);
    ProxyStep r;
    const double press = 1;
    for (int i = 0; i < 600; ++i) r = run.step({std::max(2 - press, 12 - 0.03 * i) * normal, lying});
    const dvec3 motion = 0.02 * glm::normalize(along + 0.4 * glm::cross(normal, along));
    double before = 0, least = 1e300, most = 0;
    for (int i = 0; i < 500; ++i) {
      const dvec3 hand = (2 - press) * normal + double(i) * motion;
      r = run.step({hand, lying});
      const double now = glm::length(r.proxy_world - hand);
      if (i > 20) worst = std::max(worst, std::abs(now - before) / press);
      if (i > 20) least = std::min(least, now), most = std::max(most, now);
      before = now;
    }
    spread = std::max(spread, (most - least) / press);
  }
  EXPECT_LT(worst, 0.025);
  EXPECT_LT(spread, 0.04);
  RecordProperty("jump_percent", std::to_string(100 * worst));
  RecordProperty("spread_percent", std::to_string(100 * spread));
}

// A rod touches a smooth plane in all ways for a minute (10 s in short runs): it is pressed, rubbed, tilted
// and lifted, with a tremor of 40 Hz. With the controller, the contact never gives more energy than it took
// before; without it, the contact does.
TEST(ShellProxy, ContactGivesBackNoMoreEnergyThanItTook) {
  TouchScene scene = scene_with("plane", {{"angle", 0}}, shell_of({-15, 15, 1.5}, 0.5));
  scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = 0;
  ShellProxy method;
  ASSERT_FALSE(method.prepare(scene));
  const ServoScene servo_scene = scene_for_one(scene, method, std::make_shared<volume::Version>(scene.base));
  const int ticks = runs_all_cases() ? 60000 : 10000;
  const double quarter = 0.5 * 3.14159265358979;
  double given[2] = {0, 0}, torque = 0;
  int touching = 0;
  for (const bool is_passive : {false, true}) {
    ForceOptions options;
    options.is_passive = is_passive;
    ServoCore core(options, 1e-3);
    for (int i = 0; i < ticks; ++i) {
      const double t = 1e-3 * i;
      ServoInput input;
      input.pose.position_world = {4 * std::sin(2.1 * t) + std::sin(9.7 * t), 3 * std::sin(1.3 * t),
                                   1.3 + 1.2 * std::sin(5.3 * t) + 0.4 * std::sin(251 * t)};
      input.pose.orientation =
          rotation_of({0.02 * std::sin(3.1 * t), 0.08 * std::sin(4.3 * t) + 0.02 * std::sin(188 * t), 0}) *
          rotation_of({0, quarter, 0});
      const ServoRecord record = core.step(servo_scene, input);
      touching += record.has_contact;
      torque = std::max(torque, glm::length(record.torque_world));
      given[is_passive] = std::max(given[is_passive], core.energy().contact + core.energy().turning);
    }
  }
  EXPECT_GT(touching, ticks / 2);
  EXPECT_GT(torque, 2) << "N mm";
  EXPECT_GT(given[0], 1) << "N mm, without the controller";
  EXPECT_LT(given[1], 0.3) << "N mm";
  RecordProperty("given_nmm", std::to_string(given[0]) + " " + std::to_string(given[1]));
}

// A rod rests on a plane and is levered: the torque that a device of three axes lacks becomes a vibration
// across the axis of the torque, and ends when the rod is lifted.
TEST(ShellProxy, AMissingTorqueVibrates) {
  TouchScene scene = scene_with("plane", {{"angle", 0}}, shell_of({-15, 15, 1.5}, 0.5));
  ShellProxy method;
  ASSERT_FALSE(method.prepare(scene));
  const double quarter = 0.5 * 3.14159265358979;
  constexpr int k_lifted = 1400, k_ticks = 2000;
  std::vector<ServoRecord> records[2];
  for (const bool has_effect : {false, true}) {
    ServoScene servo_scene = scene_for_one(scene, method, std::make_shared<volume::Version>(scene.base));
    auto laws = std::make_shared<LawSet>();
    if (has_effect) {
      ASSERT_FALSE(
          laws->add(law_of(parse_effect("missing-torque gain=0.05 frequency=50").value(), 1).value()));
    }
    servo_scene.hands[0].laws = laws;
    ServoCore core({}, 1e-3);
    for (int i = 0; i < k_ticks; ++i) {
      ServoInput input;
      const double press = std::min(1.0, 1e-3 * i);
      input.pose.position_world = {0, 0, i < k_lifted ? 1.5 - 0.6 * press : 9};
      input.pose.orientation = rotation_of({0, 0.1 * press, 0}) * rotation_of({0, quarter, 0});
      records[has_effect].push_back(core.step(servo_scene, input));
    }
  }
  double most = 0, mean = 0, along = 0;
  constexpr int k_begin = 1200;  // the hand rests
  for (std::size_t i = k_begin; i < k_lifted; ++i) {
    const dvec3 added = records[1][i].force_world - records[0][i].force_world;
    const dvec3 axis = glm::normalize(records[0][i].torque_world);
    most = std::max(most, glm::length(added));
    along = std::max(along, std::abs(glm::dot(added, axis)));
    mean += glm::dot(added, dvec3(0, 0, 1)) / (k_lifted - k_begin);
  }
  const double torque = glm::length(records[0][k_begin].torque_world);
  EXPECT_GT(torque, 2) << "N mm";
  EXPECT_NEAR(most, 0.05 * torque, 0.02 * torque);
  EXPECT_LT(along, 0.01 * most);
  EXPECT_LT(std::abs(mean), 0.05 * most);
  EXPECT_LT(glm::length(records[1][k_ticks - 1].force_world), 1e-9);
}

// A rod is pressed on a plane and turned against it, faster than the servo can follow without generating
// energy. With the controller, force and torque together generate less than 5 % of the energy without it.
TEST(ShellProxy, EnergyOfForceAndTorqueIsLimited) {
  TouchScene scene = scene_with("plane", {{"angle", 0}}, shell_of({-15, 15, 1.5}, 0.4));
  scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = 0;
  const double quarter = 0.5 * 3.14159265358979;
  double generated[2] = {0, 0}, torque = 0;
  for (const bool is_passive : {false, true}) {
    ShellProxy method;
    ASSERT_FALSE(method.prepare(scene));
    const ServoScene servo_scene =
        scene_for_one(scene, method, std::make_shared<volume::Version>(scene.base));
    ForceOptions options;
    options.is_passive = is_passive;
    ServoCore core(options, 1e-3);
    double least = 0;
    for (int i = 0; i < 3000; ++i) {
      const double t = 1e-3 * i, press = std::min(1.0, t);
      ServoInput input;
      input.pose.position_world = {0, 0, 1.5 - press * (0.6 + 0.5 * std::sin(251 * t))};
      const double tilt = 0.02 * press * std::sin(188 * t);
      input.pose.orientation = rotation_of({0, tilt, 0}) * rotation_of({0, quarter, 0});
      const ServoRecord record = core.step(servo_scene, input);
      torque = std::max(torque, glm::length(record.torque_world));
      const double energy = core.energy().contact + core.energy().turning;
      generated[is_passive] = std::max(generated[is_passive], energy - least);
      least = std::min(least, energy);
    }
  }
  EXPECT_GT(torque, 2) << "N mm: the torque takes part";
  EXPECT_GT(generated[0], 1) << "N mm";
  EXPECT_LT(generated[1], 0.05 * generated[0]) << "N mm";
  RecordProperty("generated_nmm", std::to_string(generated[0]) + " " + std::to_string(generated[1]));
}

// A rod lies flat on a plane, is pressed by `press` mm and drawn sideways: it sticks and lags by Coulomb's
// cone.
TEST(ShellProxy, FrictionIsCoulombs) {
  const Rod rod{-10, 10, 2};
  TouchScene scene = scene_with("plane", {{"angle", 0}}, shell_of(rod, 0.4));
  scene.items[0].material.static_friction = 0.4;
  scene.items[0].material.dynamic_friction = 0.25;
  const dquat flat = rotation_of({0, 0.5 * 3.14159265358979, 0});
  for (const dvec3 direction : {dvec3(0, 1, 0), dvec3(1, 0, 0)}) {
    ShellPlay run(scene);
    const double press = 1.5;
    ProxyStep r;
    for (int i = 0; i < 400; ++i) r = run.step({{0, 0, std::max(2 - press, 10 - 0.05 * i)}, flat});
    const dvec3 start = r.proxy_world;
    double sticks_to = 0;
    for (double aside = 0; aside < 3; aside += 0.01) {
      r = run.step({dvec3(0, 0, 2 - press) + aside * direction, flat});
      // Drawn across its axis, a cylinder may also roll; then its axis lags behind the hand by less.
      const double moved = glm::dot(r.proxy_world - start, direction);
      if (moved < 0.02) sticks_to = aside;
    }
    const double lag = 3 - glm::dot(r.proxy_world - start, direction);
    if (direction.x == 1) {  // along the rod nothing can roll
      EXPECT_NEAR(sticks_to, 0.4 * press, 0.08);
      EXPECT_NEAR(lag, 0.25 * press, 0.05);
    } else {
      EXPECT_GT(lag, 0.05);
      EXPECT_LT(lag, 0.4 * press + 0.05);
    }
    // Planted fault: without friction there is no lag.
    TouchScene smooth = scene;
    smooth.items[0].material.static_friction = smooth.items[0].material.dynamic_friction = 0;
    ShellPlay slick(smooth);
    for (int i = 0; i < 400; ++i) r = slick.step({{0, 0, std::max(2 - press, 10 - 0.05 * i)}, flat});
    for (double aside = 0; aside < 3; aside += 0.01)
      r = slick.step({dvec3(0, 0, 2 - press) + aside * direction, flat});
    EXPECT_LT(std::abs(3 - glm::dot(r.proxy_world, direction)), 0.02);
  }
}

/// A tool that a still hand presses on noisy bone comes to rest: a force that alternated between poses would
/// be a vibration.
TEST(ShellProxy, APressedToolComesToRest) {
  TouchScene scene = scene_with("head", {{"noise", 40}}, shell_of(k_shaft, 0.4));
  for (const double friction : {0.0, 0.3}) {
    scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = friction;
    for (int place = 0; place < 8; ++place) {
      ShellPlay run(scene);
      const double angle = 0.78 * place;
      const dvec3 outward = glm::normalize(dvec3(std::cos(angle), std::sin(angle), 0.3));
      const dquat turn = rotation_of(1.2 * dvec3(std::sin(3 * angle), std::cos(2 * angle), 0.3));
      ProxyStep r;
      double depth = 0;
      for (double distance = 160; distance > 40 && depth < 5; distance -= 0.2) {
        r = run.step({distance * outward, turn});
        if (r.has_contact) depth += 0.2;
      }
      ASSERT_TRUE(r.has_contact) << place;
      const Placement hand{run.tool(r).position_world - 4.0 * outward, turn};
      for (int i = 0; i < 400; ++i) r = run.step(hand);
      double most = 0;
      for (int i = 0; i < 200; ++i) {
        const Placement before = run.tool(r);
        r = run.step(hand);
        const dvec3 turned = turn_between(before.rotation, run.tool(r).rotation);
        most = std::max({most, glm::distance(before.position_world, run.tool(r).position_world),
                         10 * glm::length(turned)});
      }
      EXPECT_LT(most, 1e-3) << place << ", friction " << friction << ": mm per step";
    }
  }
}

}  // namespace
}  // namespace trephine::haptics
