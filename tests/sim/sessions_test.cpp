#include <bit>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "haptics/proxy/implicit_proxy.h"
#include "modules/drilling/burr.h"
#include "sim/drivers/live_session.h"
#include "sim/drivers/lockstep.h"
#include "tests/scenes/golden.h"

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

/// Approaches at (x, 0) mm, drills there for `ticks` ticks, and lifts the tool again.
void stroke(Lockstep& run, double x, int ticks) {
  for (int i = 0; i < 60; ++i) run.step({{x, 0, 3}, {1, 0, 0, 0}, false});
  for (int i = 0; i < ticks; ++i) run.step({{x, 0, -3}, {1, 0, 0, 0}, true});
  for (int i = 0; i < 60; ++i) run.step({{x, 0, 3}, {1, 0, 0, 0}, false});
}

TEST(Lockstep, SameInputSameBits) {
  std::uint64_t hashes[2];
  dvec3 forces[2];
  for (int i = 0; i < 2; ++i) {
    const haptics::TouchScene scene = flat_bone();
    haptics::ImplicitProxy method;
    ASSERT_FALSE(method.prepare(scene).has_value());
    const drilling::Burr burr{4, 30, 20, false};
    Lockstep run(scene, method, drilling::burr(burr), {}, 1000);
    forces[i] = dvec3(0);
    stroke(run, -4, 400);
    stroke(run, 3, 300);
    forces[i] = run.step({{0, 0, -2}, {1, 0, 0, 0}, true}).force_world;
    hashes[i] = run.engine().version()->content_hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(forces[0], forces[1]);
  // The golden values hold for every compiler, preset and x86-64 CPU.
  EXPECT_EQ(hashes[0], scenes::golden("lockstep, removed volume"));
  EXPECT_EQ(std::bit_cast<std::uint64_t>(forces[0].z), scenes::golden("lockstep, last force"));
}

TEST(Lockstep, UndoAndRedoByStrokeAreExact) {
  const haptics::TouchScene scene = flat_bone();
  haptics::ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  const drilling::Burr burr{4, 30, 20, false};
  Lockstep run(scene, method, drilling::burr(burr), {}, 1000);
  std::vector<std::uint64_t> hash{run.engine().version()->content_hash()};
  std::vector<double> removed{0};
  for (int i = 0; i < 4; ++i) {
    stroke(run, -6 + 4 * i, 300);
    hash.push_back(run.engine().version()->content_hash());
    removed.push_back(run.engine().removed_mm3());
    EXPECT_GT(removed.back(), removed[removed.size() - 2]);
  }
  EXPECT_EQ(run.engine().stroke_count(), 4u);
  for (int i = 3; i >= 0; --i) {
    EXPECT_TRUE(run.undo().is_changed);
    EXPECT_EQ(run.engine().version()->content_hash(), hash[static_cast<std::size_t>(i)]);
    EXPECT_EQ(run.engine().removed_mm3(), removed[static_cast<std::size_t>(i)]);
  }
  EXPECT_FALSE(run.undo().is_changed);
  for (int i = 1; i <= 3; ++i) {
    EXPECT_TRUE(run.redo().is_changed);
    EXPECT_EQ(run.engine().version()->content_hash(), hash[static_cast<std::size_t>(i)]);
  }
  // Further drilling discards the strokes that could be redone; older versions are unchanged.
  stroke(run, 8, 200);
  EXPECT_FALSE(run.engine().can_redo());
  run.undo();
  EXPECT_EQ(run.engine().version()->content_hash(), hash[3]);
}

TEST(Lockstep, UndoIsLimitedToTheNewestStrokes) {
  const haptics::TouchScene scene = flat_bone();
  haptics::ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  const drilling::Burr burr{1, 60, 400, true};
  Engine edits(scene, method, drilling::burr(burr), 1e-3);
  haptics::ServoRecord tick;
  const std::size_t strokes = Engine::k_max_strokes + 30;
  for (std::size_t i = 0; i < strokes; ++i) {
    for (const bool is_pressed : {true, false}) {
      tick.pose = {{-12 + 0.08 * static_cast<double>(i), 0, -1}, {1, 0, 0, 0}, is_pressed};
      edits.apply(tick);
    }
  }
  EXPECT_EQ(edits.stroke_count(), strokes);
  std::size_t undone = 0;
  while (edits.apply(Undo{}).is_changed) ++undone;
  EXPECT_EQ(undone, Engine::k_max_strokes);
  EXPECT_EQ(edits.stroke_count(), 30u);
  EXPECT_GT(edits.removed_mm3(), 0);
  while (edits.apply(Redo{}).is_changed) {}
  EXPECT_EQ(edits.stroke_count(), strokes);
}

/// Returns a plate of 3 mm with faces at z = +-1.5: thin bone, drilled from either side.
haptics::TouchScene thin_bone() {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(64);
  o.spacing_mm = dvec3(0.5);
  o.psf_sigma_voxels = 1;
  o.parameters = {{"thickness", 3}, {"angle", 0}};
  return scenes::phantom_scene("plate", o);
}

// After an undo, bone grows back over the tool. The tool is led out along its own path to the side from which
// it came. Speed and force are bounded, and a hand at rest receives no energy.
TEST(Lockstep, GrowthLeadsTheToolOutToTheSideItCameFrom) {
  for (const double side : {1.0, -1.0}) {
    const haptics::TouchScene scene = thin_bone();
    haptics::ImplicitProxy method;
    ASSERT_FALSE(method.prepare(scene).has_value());
    const drilling::Burr burr{4, 60, 40, false};
    Lockstep run(scene, method, drilling::burr(burr), {}, 1000);
    haptics::ServoRecord r;
    // First obliquely, so that the escape path has a bend; then straight into the bone, nearly through it.
    for (int i = 0; i < 100; ++i) r = run.step({{0.02 * i, 0, side * (6 - 0.03 * i)}, {1, 0, 0, 0}, false});
    for (int i = 0; i < 2500; ++i)
      r = run.step({{2, 0, side * std::max(-0.8, 3 - 0.01 * i)}, {1, 0, 0, 0}, true});
    ASSERT_LT(side * r.proxy_world.z, 0.5);  // deep in its own hole
    const dvec3 hand(2, 0, side * -0.8);
    const double before = run.engine().removed_mm3();
    ASSERT_GT(before, 1);
    ASSERT_TRUE(run.undo().is_changed);
    EXPECT_EQ(run.engine().removed_mm3(), 0);
    // The hand holds still with the button pressed. The tool is led out, and cuts nothing on this path.
    double last_force = glm::length(r.force_world), strongest = 0;
    dvec3 last_proxy = hand;
    int led = 0;
    for (; led < 1000; ++led) {
      r = run.step({hand, {1, 0, 0, 0}, true});
      if (!r.is_escaping) break;
      EXPECT_FALSE(r.is_buried);
      EXPECT_FALSE(r.pose.is_pressed());
      EXPECT_LE(glm::length(r.proxy_world - last_proxy), 1e-3 * haptics::k_escape_speed + 1e-9);
      const double force = glm::length(r.force_world);
      if (led > 30) {
        EXPECT_LE(force, haptics::k_escape_force + 1e-9);
      }
      EXPECT_LE(std::abs(force - last_force), 1.0 + 1e-9);
      strongest = std::max(strongest, force);
      last_force = force;
      last_proxy = r.proxy_world;
    }
    EXPECT_GT(led, 15);
    EXPECT_LT(led, 400);
    EXPECT_GT(side * last_proxy.z, 1.0);  // outside again, on the side from which it came
    EXPECT_GT(r.energy.discarded, 0.5);   // energy that a jump would have stored
    EXPECT_EQ(r.energy.growth, 0);        // a hand at rest receives no work
    EXPECT_TRUE(r.has_contact);
    // Only the tick after the escape may cut a little, since the button is still pressed.
    EXPECT_LT(run.engine().removed_mm3(), 0.05);
    // Afterwards the surface stops the tool as before, while the full force returns over tenths of a second.
    for (int i = 0; i < 600; ++i) {
      r = run.step({hand, {1, 0, 0, 0}, false});
      EXPECT_LE(std::abs(glm::length(r.force_world) - last_force), 1.0 + 1e-9);
      last_force = glm::length(r.force_world);
    }
    EXPECT_GT(side * r.proxy_world.z, 0.9);
    EXPECT_NEAR(last_force, 0.5 * glm::length(r.proxy_world - hand), 0.1);
  }
}

TEST(Lockstep, AHandThatYieldsReceivesOnlyBoundedWorkFromGrowth) {
  const haptics::TouchScene scene = thin_bone();
  haptics::ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  const drilling::Burr burr{4, 60, 40, false};
  Lockstep run(scene, method, drilling::burr(burr), {}, 1000);
  haptics::ServoRecord r;
  for (int i = 0; i < 2500; ++i) r = run.step({{0, 0, std::max(-0.8, 4 - 0.01 * i)}, {1, 0, 0, 0}, true});
  ASSERT_TRUE(run.undo().is_changed);
  // The hand is replaced by a free mass of 50 g, with a damping of 0.002 N s/mm by the device.
  dvec3 x(0, 0, -0.8), v(0);
  double fastest = 0;
  for (int i = 0; i < 2000; ++i) {
    r = run.step({x, {1, 0, 0, 0}, false});
    v += 1e-3 * 1000.0 * (r.force_world - 0.002 * v) / 0.05;
    x += 1e-3 * v;
    fastest = std::max(fastest, glm::length(v));
  }
  EXPECT_GT(x.z, 1.0);
  // The work on the mass is at most that of the escape force over 4 mm, and its speed is bounded.
  EXPECT_GT(r.energy.growth, 0);
  EXPECT_LT(r.energy.growth + std::abs(r.energy.contact), haptics::k_escape_force * 4);
  EXPECT_LT(fastest, 4 * haptics::k_escape_speed);
}

TEST(Lockstep, AFreeToolStaysInPlaceWhenBoneGrowsElsewhere) {
  const haptics::TouchScene scene = flat_bone();
  haptics::ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  const drilling::Burr burr{4, 60, 40, false};
  Lockstep run(scene, method, drilling::burr(burr), {}, 1000);
  stroke(run, -4, 300);
  haptics::ServoRecord r;
  for (int i = 0; i < 200; ++i) r = run.step({{3, 0, -1}, {1, 0, 0, 0}, false});
  const dvec3 proxy = r.proxy_world, force = r.force_world;
  ASSERT_TRUE(run.undo().is_changed);
  r = run.step({{3, 0, -1}, {1, 0, 0, 0}, false});
  EXPECT_FALSE(r.is_escaping);
  EXPECT_LT(glm::length(r.proxy_world - proxy), 1e-9);
  EXPECT_LT(glm::length(r.force_world - force), 1e-6);
}

TEST(LiveSession, DrillsOnItsThreadsAndUndoes) {
  const haptics::TouchScene scene = flat_bone();
  haptics::ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  const drilling::Burr burr{4, 60, 40, false};
  const auto request = haptics::PosePath::from_samples({{0, {{0, 0, 3}, {1, 0, 0, 0}, false}},
                                                        {0.1, {{0, 0, 0.5}, {1, 0, 0, 0}, true}},
                                                        {0.4, {{0, 0, -4}, {1, 0, 0, 0}, true}},
                                                        {0.9, {{0, 0, -4}, {1, 0, 0, 0}, true}},
                                                        {0.95, {{0, 0, 5}, {1, 0, 0, 0}, false}},
                                                        {1.1, {{0, 0, 5}, {1, 0, 0, 0}, false}}},
                                                       "test")
                           .value();
  haptics::VirtualDevice device(request, {});
  LiveSession live(device, scene, method, drilling::burr(burr), {});
  live.keep_trace(100'000);
  ASSERT_FALSE(live.start().has_value());
  double most = 0;
  bool saw_change = false;
  const auto wait_until = [&](auto&& done) {
    for (int i = 0; i < 2000; ++i) {
      const LiveState s = live.fetch_state();
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
  EXPECT_TRUE(wait_until([](const LiveState& s) { return s.removed_mm3 == 0 && s.version->is_uncut(); }));
  live.redo();
  EXPECT_TRUE(wait_until([&](const LiveState& s) { return s.removed_mm3 > 5; }));
  live.reset_faults();  // harmless without a fault
  const double asked_at = live.fetch_state().newest.t;
  EXPECT_TRUE(wait_until([&](const LiveState& s) { return s.newest.t > asked_at + 0.05; }));
  EXPECT_EQ(live.fetch_state().newest.faults & haptics::k_latched_faults, 0u);
  live.stop();
  EXPECT_EQ(live.servo_report().faults & (haptics::fault_not_finite | haptics::fault_full_ring), 0u);
  std::uint64_t tick = 0;
  for (const auto& r : live.trace()) ASSERT_EQ(r.tick, tick++);
}

}  // namespace
}  // namespace trephine::sim
