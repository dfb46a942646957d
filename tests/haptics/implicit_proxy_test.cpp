#include "haptics/implicit_proxy.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "tests/checker/fall_through.h"
#include "tests/scenes/scenes.h"
#include "volume/removal.h"
#include "volume/traversal.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

/// Plays HIP positions and judges each step.
struct Play {
  TouchScene scene;
  std::shared_ptr<const volume::Version> version;
  ImplicitProxy method{3};
  ProxyState state;
  checker::FallThroughJudge judge;
  long contacts = 0;

  explicit Play(TouchScene s)
      : scene(std::move(s)),
        version(std::make_shared<volume::Version>(scene.base)),
        judge(scene.base->size, [this](int x, int y, int z) {
          return scene.base->voxels[scene.base->index(x, y, z)] >= 300 && version->distance_at(x, y, z) > 0;
        }) {
    EXPECT_FALSE(method.prepare(scene).has_value());
  }
  ProxyStep step(const dvec3& hip_world) {
    const ProxyStep s = method.step(scene, *version, state, {hip_world});
    judge.look({std::span(s.path_volume.data(), static_cast<std::size_t>(s.waypoint_count)),
                scene.base->frame.volume_from_world(hip_world), s.has_contact, s.is_buried});
    contacts += s.has_contact;
    return s;
  }
};

data_tools::PhantomOptions grid(int size, double psf, double shear = 0) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(size);
  o.psf_sigma_voxels = psf;
  o.shear_degrees = shear;
  return o;
}

TEST(ImplicitProxy, FreeMotionFollowsTheHipExactly) {
  Play play(scenes::phantom_scene("sphere", grid(64, 1)));
  for (int i = 0; i < 50; ++i) {
    const dvec3 hip(50.0 + i * 0.1, 40, 10);
    const ProxyStep s = play.step(hip);
    EXPECT_FALSE(s.has_contact);
    EXPECT_LT(glm::length(s.proxy_world - hip), 1e-12);
  }
  EXPECT_EQ(play.judge.fall_throughs(), 0);
}

TEST(ImplicitProxy, StaysOnASphereWithinAVoxelAndFacesOut) {
  for (const double shear : {0.0, 20.0}) {
    Play play(scenes::phantom_scene("sphere", grid(128, 1.5, shear)));
    play.scene.shapes[0].material.static_friction = play.scene.shapes[0].material.dynamic_friction = 0;
    const PosePath path = scenes::sphere_slide(45, 1.0, 100, 3);
    double worst = 0, sum = 0, worst_angle = 0;
    long count = 0;
    for (const auto& sample : path.samples()) {
      const ProxyStep s = play.step(sample.pose.position_world);
      if (!s.has_contact || sample.t < 0.1) continue;
      const double error = glm::length(s.proxy_world) - 45;
      worst = std::max(worst, std::abs(error));
      sum += error * error;
      ++count;
      worst_angle = std::max(
          worst_angle, std::acos(std::min(1.0, glm::dot(s.normal_world, glm::normalize(s.proxy_world)))));
    }
    EXPECT_GT(count, 2800);
    EXPECT_EQ(play.judge.fall_throughs(), 0);
    EXPECT_LT(worst, 0.94 * 1.5);  // cubes: a voxel of 0.94 mm, its corner at most
    EXPECT_LT(std::sqrt(sum / static_cast<double>(count)), 0.94 * 0.6);
    EXPECT_LT(worst_angle, 0.12);
  }
}

TEST(ImplicitProxy, NeverFallsThroughThinPlatesAtAnySpeed) {
  for (const double thickness : {1.5, 3.0})                // 1.6 voxels and less: as thin as voxels can hold
    for (const double speed : {0.05, 2.0, 60.0, 400.0}) {  // mm a step
      data_tools::PhantomOptions o = grid(128, 0);
      o.parameters = {{"thickness", thickness}, {"angle", 37}};
      Play play(scenes::phantom_scene("plate", o));
      dvec3 hip(0, 0, 50);
      play.step(hip);
      while (hip.z > -50) {
        hip += dvec3(0.13 * speed, 0.07 * speed, -speed);
        if (std::abs(hip.x) > 40) hip.x = 0;
        play.step(hip);
      }
      EXPECT_EQ(play.judge.fall_throughs(), 0) << thickness << " " << speed;
      EXPECT_GT(play.contacts, 0);
    }
}

TEST(ImplicitProxy, NeverFallsThroughARoughWalkOverNoisyBoneAndGyroid) {
  for (const char* name : {"gyroid", "shell"}) {
    Play play(scenes::phantom_scene(name, grid(96, 0.7, 12)));
    const PosePath path = scenes::rough_walk(dvec3(-55), dvec3(55), 3.0, 40000, 5);
    for (const auto& sample : path.samples()) {
      const ProxyStep s = play.step(sample.pose.position_world);
      ASSERT_TRUE(std::isfinite(s.proxy_world.x + s.proxy_world.y + s.proxy_world.z));
      ASSERT_LE(s.counters.iterations, 3);
    }
    EXPECT_EQ(play.judge.fall_throughs(), 0) << name;
    EXPECT_EQ(play.judge.buried_starts(), 0);
    EXPECT_GT(play.contacts, 10000);
  }
}

TEST(ImplicitProxy, HoldsInADrilledCavityAndReachesFartherAfterRemoval) {
  Play play(scenes::phantom_scene("plane", [] {
    auto o = grid(96, 1);
    o.parameters = {{"angle", 0}};
    return o;
  }()));
  volume::RemovalEditor editor(play.version, {play.scene.shapes[0].field});
  play.step({0, 0, 5});
  for (int i = 0; i < 100; ++i) play.step({0, 0, -6});
  const double before = glm::length(play.step({0, 0, -6}).proxy_world - dvec3(0, 0, -6));
  EXPECT_NEAR(before, 6, 1.25);
  editor.remove({{0, 0, 2}, {0, 0, -8}, 4});
  play.version = editor.publish();
  for (int i = 0; i < 200; ++i) play.step({0, 0, -6});
  EXPECT_FALSE(play.step({0, 0, -6}).has_contact);
  // Push against floor and wall of the hole from inside.
  for (int i = 0; i < 4000; ++i) {
    const double a = i * 0.01;
    play.step({8 * std::cos(a), 8 * std::sin(a), -9 - 5 * std::sin(0.37 * a)});
  }
  EXPECT_EQ(play.judge.fall_throughs(), 0);
  EXPECT_GT(play.contacts, 3000);
}

TEST(ImplicitProxy, BackSideHoldsAProxyInTheSolid) {
  TouchScene scene = scenes::phantom_scene("sphere", grid(96, 1));
  scene.shapes[0].sides = Sides::both;
  ImplicitProxy method;
  ProxyState state;
  const volume::Version version(scene.base);
  method.step(scene, version, state, {dvec3(0)});
  EXPECT_EQ(state.inside, 1u);
  ProxyStep s;
  for (int i = 0; i < 600; ++i) s = method.step(scene, version, state, {dvec3(0.1 * i, 0.02 * i, 0)});
  EXPECT_TRUE(s.has_contact);
  EXPECT_EQ(s.side, -1);
  EXPECT_LT(glm::length(s.proxy_world), 46.5);
  EXPECT_LT(glm::dot(s.normal_world, glm::normalize(s.proxy_world)),
            -0.95);  // into the solid, where the proxy is
  // With the front alone held, the same motion leaves the solid, and cannot come back in.
  scene.shapes[0].sides = Sides::front;
  for (int i = 0; i < 600; ++i) s = method.step(scene, version, state, {dvec3(0.1 * i, 0.02 * i, 0)});
  EXPECT_FALSE(s.has_contact);
  for (int i = 0; i < 600; ++i)
    s = method.step(scene, version, state, {dvec3(60 - 0.1 * i, 12 - 0.02 * i, 0)});
  EXPECT_TRUE(s.has_contact);
  EXPECT_EQ(s.side, 1);
}

TEST(ImplicitProxy, GrowthOverTheProxyIsSaidAndGivesNoForce) {
  Play play(scenes::phantom_scene("plane", [] {
    auto o = grid(64, 1);
    o.parameters = {{"angle", 0}};
    return o;
  }()));
  const auto untouched = play.version;
  volume::RemovalEditor editor(play.version, {play.scene.shapes[0].field});
  editor.remove({{0, 0, 0}, {0, 0, -15}, 8});
  play.version = editor.publish();
  play.step({0, 0, 10});
  play.step({0, 0, -10});
  play.version = untouched;
  const ProxyStep s = play.step({0, 0, -10});
  EXPECT_TRUE(s.is_buried);
  EXPECT_FALSE(s.has_contact);
}

TEST(ImplicitProxy, FrictionHoldsStillAndTrailsByTheCone) {
  Play play(scenes::phantom_scene("plane", [] {
    auto o = grid(128, 1.5);
    o.parameters = {{"angle", 0}};
    return o;
  }()));
  play.step({0.3, 0.2, 5});
  for (int i = 0; i < 20; ++i) play.step({0.3, 0.2, -2});
  const dvec3 held = play.step({0.3, 0.2, -2}).proxy_world;
  // Within the static cone the proxy does not creep.
  ProxyStep s;
  for (int i = 0; i < 2000; ++i) s = play.step({0.3 + 0.3, 0.2, -2});
  EXPECT_LT(glm::length(s.proxy_world - held), 1e-9);
  // Sliding, it trails by the dynamic coefficient times the depth.
  dvec3 hip(0.6, 0.2, -2);
  for (int i = 0; i < 300; ++i) {
    hip.x += 0.05;
    s = play.step(hip);
  }
  const double depth = s.proxy_world.z - hip.z;
  EXPECT_NEAR(hip.x - s.proxy_world.x, 0.15 * depth, 0.06);
  EXPECT_EQ(play.judge.fall_throughs(), 0);
}

TEST(ImplicitProxy, WorkDoesNotGrowWithTheVolume) {
  // The same voxel density, volumes of 50^3 and 200^3: identical steps, identical work.
  long work[2] = {0, 0};
  for (const int i : {0, 1}) {
    data_tools::PhantomOptions o;
    o.size = glm::ivec3(i == 0 ? 50 : 200);
    o.spacing_mm = dvec3(0.5);
    o.parameters = {{"radius", 10}};
    Play play(scenes::phantom_scene("sphere", o));
    const PosePath path = scenes::sphere_slide(10, 0.5, 50, 1);
    for (const auto& sample : path.samples()) {
      const ProxyStep s = play.step(sample.pose.position_world);
      work[i] += s.counters.voxels + s.counters.cells;
    }
  }
  EXPECT_EQ(work[0], work[1]);
  EXPECT_GT(work[0], 1000);
}

}  // namespace
}  // namespace trephine::haptics
