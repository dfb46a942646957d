#include <bit>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "haptics/implicit_proxy.h"
#include "modules/drilling/burr.h"
#include "sim/live_session.h"
#include "sim/lockstep.h"
#include "tests/scenes/scenes.h"

namespace trephine::sim {
namespace {

using glm::dvec3;

haptics::TouchScene flat_bone() {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(64);
  o.spacing_mm = dvec3(0.5);
  o.psf_sigma_voxels = 1;
  o.parameters = {{"angle", 0}};
  return scenes::phantom_scene("plane", o);
}

/// Presses at (x, 0) for `ticks`, then lifts for a few.
void stroke(Lockstep& run, double x, int ticks, double& t) {
  for (int i = 0; i < 60; ++i, t += 1e-3) run.step({{x, 0, 3}, {1, 0, 0, 0}, false}, t);
  for (int i = 0; i < ticks; ++i, t += 1e-3) run.step({{x, 0, -3}, {1, 0, 0, 0}, true}, t);
  for (int i = 0; i < 60; ++i, t += 1e-3) run.step({{x, 0, 3}, {1, 0, 0, 0}, false}, t);
}

TEST(Lockstep, SameInputSameBits) {
  std::uint64_t hashes[2];
  dvec3 forces[2];
  for (int i = 0; i < 2; ++i) {
    const haptics::TouchScene scene = flat_bone();
    haptics::ImplicitProxy method;
    ASSERT_FALSE(method.prepare(scene).has_value());
    drilling::Burr burr({2, 30, 20, false});
    Lockstep run(scene, method, &burr, {}, 1000);
    double t = 0;
    forces[i] = dvec3(0);
    stroke(run, -4, 400, t);
    stroke(run, 3, 300, t);
    forces[i] = run.step({{0, 0, -2}, {1, 0, 0, 0}, true}, t).force_world;
    hashes[i] = run.edits().current()->content_hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(forces[0], forces[1]);
  // The same on every compiler, preset and x86-64 CPU; a change of the phantom or of removal changes it
  // knowingly.
  EXPECT_EQ(hashes[0], 9417461461550874069ull);
  EXPECT_EQ(std::bit_cast<std::uint64_t>(forces[0].z), 4597345573958413389ull);
}

TEST(Lockstep, UndoAndRedoByStrokeAreExact) {
  const haptics::TouchScene scene = flat_bone();
  haptics::ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  drilling::Burr burr({2, 30, 20, false});
  Lockstep run(scene, method, &burr, {}, 1000);
  double t = 0;
  std::vector<std::uint64_t> hash{run.edits().current()->content_hash()};
  std::vector<double> removed{0};
  for (int i = 0; i < 4; ++i) {
    stroke(run, -6 + 4 * i, 300, t);
    hash.push_back(run.edits().current()->content_hash());
    removed.push_back(run.edits().removed_mm3());
    EXPECT_GT(removed.back(), removed[removed.size() - 2]);
  }
  EXPECT_EQ(run.edits().stroke_count(), 4u);
  for (int i = 3; i >= 0; --i) {
    EXPECT_TRUE(run.undo().is_changed);
    EXPECT_EQ(run.edits().current()->content_hash(), hash[static_cast<std::size_t>(i)]);
    EXPECT_EQ(run.edits().removed_mm3(), removed[static_cast<std::size_t>(i)]);
  }
  EXPECT_FALSE(run.undo().is_changed);
  for (int i = 1; i <= 3; ++i) {
    EXPECT_TRUE(run.redo().is_changed);
    EXPECT_EQ(run.edits().current()->content_hash(), hash[static_cast<std::size_t>(i)]);
  }
  // Drilling on ends the redo line; older versions are as they were.
  stroke(run, 8, 200, t);
  EXPECT_FALSE(run.edits().can_redo());
  run.undo();
  EXPECT_EQ(run.edits().current()->content_hash(), hash[3]);
}

TEST(Lockstep, UndoInContactGoesBackToAFreePointWithForceFromZero) {
  const haptics::TouchScene scene = flat_bone();
  haptics::ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  drilling::Burr burr({2, 60, 40, false});
  Lockstep run(scene, method, &burr, {}, 1000);
  double t = 0;
  for (int i = 0; i < 100; ++i, t += 1e-3) run.step({{0, 0, 4 - 0.05 * i}, {1, 0, 0, 0}, true}, t);
  haptics::ServoRecord r;
  for (int i = 0; i < 1500; ++i, t += 1e-3) r = run.step({{0, 0, -4}, {1, 0, 0, 0}, true}, t);
  EXPECT_LT(r.proxy_world.z, -1);  // deep in its own hole
  ASSERT_TRUE(run.undo().is_changed);
  EXPECT_EQ(run.edits().removed_mm3(), 0);
  r = run.step({{0, 0, -4}, {1, 0, 0, 0}, false}, t += 1e-3);
  EXPECT_FALSE(r.is_buried);
  EXPECT_TRUE(r.has_contact);
  EXPECT_GT(r.proxy_world.z, -0.6);                   // outside again, where it came from
  EXPECT_LE(glm::length(r.force_world), 1.0 + 1e-9);  // from zero, a slew step at most
  double last = glm::length(r.force_world);
  for (int i = 0; i < 50; ++i) {
    r = run.step({{0, 0, -4}, {1, 0, 0, 0}, false}, t += 1e-3);
    const double now = glm::length(r.force_world);
    EXPECT_LE(std::abs(now - last), 1.0 + 1e-9);
    last = now;
  }
  EXPECT_NEAR(last, 0.5 * 4, 0.3);
}

TEST(LiveSession, DrillsOnItsThreadsAndUndoes) {
  const haptics::TouchScene scene = flat_bone();
  haptics::ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  drilling::Burr burr({2, 60, 40, false});
  const auto wish = haptics::PosePath::from_samples({{0, {{0, 0, 3}, {1, 0, 0, 0}, false}},
                                                     {0.1, {{0, 0, 0.5}, {1, 0, 0, 0}, true}},
                                                     {0.4, {{0, 0, -4}, {1, 0, 0, 0}, true}},
                                                     {0.9, {{0, 0, -4}, {1, 0, 0, 0}, true}},
                                                     {0.95, {{0, 0, 5}, {1, 0, 0, 0}, false}},
                                                     {1.1, {{0, 0, 5}, {1, 0, 0, 0}, false}}},
                                                    "test")
                        .value();
  haptics::VirtualDevice device(wish, {});
  LiveSession live(device, scene, method, &burr, {});
  live.keep_trace(100'000);
  ASSERT_FALSE(live.start().has_value());
  double most = 0;
  bool saw_change = false;
  const auto wait_until = [&](auto&& done) {
    for (int i = 0; i < 2000; ++i) {
      const LiveState s = live.look();
      most = std::max(most, s.removed_mm3);
      saw_change = saw_change || s.changed.low.x <= s.changed.high.x;
      if (done(s)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
    return false;
  };
  EXPECT_TRUE(wait_until([](const LiveState& s) { return s.newest.t > 1.0; }));
  EXPECT_GT(most, 5);
  EXPECT_TRUE(saw_change);
  live.undo();
  EXPECT_TRUE(wait_until([](const LiveState& s) { return s.removed_mm3 == 0 && s.version->is_untouched(); }));
  live.redo();
  EXPECT_TRUE(wait_until([&](const LiveState& s) { return s.removed_mm3 > 5; }));
  live.reset_faults();  // harmless when there is none
  const double asked_at = live.look().newest.t;
  EXPECT_TRUE(wait_until([&](const LiveState& s) { return s.newest.t > asked_at + 0.05; }));
  EXPECT_EQ(live.look().newest.faults & haptics::k_latched_faults, 0u);
  live.stop();
  EXPECT_EQ(live.servo_report().faults & (haptics::fault_not_finite | haptics::fault_full_ring), 0u);
  std::uint64_t tick = 0;
  for (const auto& r : live.trace()) ASSERT_EQ(r.tick, tick++);
}

}  // namespace
}  // namespace trephine::sim
