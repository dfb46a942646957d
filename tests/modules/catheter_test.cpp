// Catheters in the hand: pops, refusals and tracks in a layered slab in closed form.
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

#include "tests/modules/catheter_slab.h"

namespace trephine::ventriculostomy {
namespace {

TEST(Catheter, PopsThroughDuraAndWallWithTheForcesAndDepthsOfAClosedForm) {
  constexpr double k_speed = 20;  // mm/s
  for (const auto& [rate, spacing] :
       {std::pair{250.0, dvec3(0.5)}, std::pair{1000.0, dvec3(0.6, 0.6, 1)}, std::pair{4000.0, dvec3(0.5)}}) {
    SCOPED_TRACE(rate);
    const Slab bench(spacing);
    sim::Lockstep run = bench.run(rate);
    drill_hole(run);
    double strongest_dura = 0, strongest_wall = 0, brain = 0, beyond = 0;
    move(run, rate, 4, -38, k_speed, [&](const ServoRecord& r, double z) {
      const double force = r.force_world.z;
      if (z > -9) strongest_dura = std::max(strongest_dura, force);
      if (z < -15 && z > -28) brain = std::max(brain, force);
      if (z < -29 && z > -32) strongest_wall = std::max(strongest_wall, force);
      if (z < -34) beyond = std::max(beyond, std::abs(force));
    });
    const auto entered = events_of<CatheterEntered>(run.engine());
    ASSERT_EQ(entered.size(), 1u);
    EXPECT_NEAR(entered[0].second.z, -6.3, 0.1) << "the hole ends in the dura";
    const double viscous = 0.003 * k_speed;
    EXPECT_NEAR(strongest_dura, 1.5, 0.1 + k_speed / rate);
    EXPECT_NEAR(brain, 0.05 + viscous, 0.03);
    EXPECT_NEAR(strongest_wall, 0.4 + viscous, 0.06 + k_speed / rate);
    EXPECT_LT(beyond, 0.01) << "fluid does not resist";
    const auto pops = events_of<CatheterPopped>(run.engine());
    ASSERT_EQ(pops.size(), 2u);
    EXPECT_EQ(pops[0].first.structure, "dura");
    EXPECT_NEAR(pops[0].first.depth, 0, 0.1);
    EXPECT_EQ(pops[1].first.structure, "ventricle_left");
    EXPECT_NEAR(pops[1].second.z, k_wall, 0.1);
    EXPECT_NEAR(pops[1].first.depth, entered[0].second.z - k_wall, 0.1);
    // Within the existing track the catheter meets no resistance, and no membrane pops.
    move(run, rate, -38, -20, 60, [&](const ServoRecord& r, double) { EXPECT_LT(r.force_world.z, 0.2); });
    move(run, rate, -20, -37, 60, k_ignore);
    EXPECT_EQ(events_of<CatheterPopped>(run.engine()).size(), 2u);
    // The catheter is drawn out and inserted again: a new passage begins, and the dura pops again.
    move(run, rate, -37, 4, 100, k_ignore);
    EXPECT_FALSE(state_of(run).has_entered);
    const auto left = events_of<CatheterWithdrawn>(run.engine());
    ASSERT_EQ(left.size(), 1u);
    EXPECT_NEAR(left[0].second.z, -38, 0.2);
    move(run, rate, 4, -20, 40, k_ignore);
    EXPECT_EQ(events_of<CatheterPopped>(run.engine()).size(), 3u);
    EXPECT_EQ(measure(run.engine(), "catheter passages"), 2);
  }
}

TEST(Catheter, DuraThatWasDrilledAwayDoesNotPop) {
  // The hole ends below the dura, so that no dura resists or pops.
  const Slab bench;
  sim::Lockstep run = bench.run(1000, {4, -7.5});
  drill_hole(run);
  double strongest = 0;
  move(run, 1000, 4, -20, 20,
       [&](const ServoRecord& r, double) { strongest = std::max(strongest, r.force_world.z); });
  EXPECT_LT(strongest, 0.3);
  EXPECT_TRUE(events_of<CatheterPopped>(run.engine()).empty());
  EXPECT_EQ(events_of<CatheterEntered>(run.engine()).size(), 1u);
}

TEST(Catheter, PassesTheBlurredEdgeOfBoneButNoBone) {
  // The threshold classifies the upper millimetre of the dura as bone. Labels take precedence over the
  // threshold, so that only the dura resists.
  const Slab blurred(dvec3(0.5), -5);
  sim::Lockstep run = blurred.run(1000, {4, -5.2});
  drill_hole(run);
  double strongest = 0;
  move(run, 1000, 4, -20, 20,
       [&](const ServoRecord& r, double) { strongest = std::max(strongest, r.force_world.z); });
  EXPECT_NEAR(strongest, 1.5, 0.12);
  ASSERT_EQ(events_of<CatheterPopped>(run.engine()).size(), 1u);
  EXPECT_TRUE(events_of<CatheterRefused>(run.engine()).empty());
  move(run, 1000, -20, 4, 60, k_ignore);
  EXPECT_FALSE(run.engine().servo_scene()->hands[1].passable_items.contains(0)) << "bone blocks again";
  const Slab bone;  // here unblurred bone continues below the hole
  sim::Lockstep other = bone.run(1000, {4, -5.2});
  drill_hole(other);
  move(other, 1000, 4, -8, 20, k_ignore);
  for (int i = 0; i < 300; ++i) tick(other, {0, 0, -8}, k_upright);
  EXPECT_TRUE(events_of<CatheterEntered>(other.engine()).empty());
  EXPECT_EQ(events_of<CatheterRefused>(other.engine()).size(), 1u);
}

TEST(Catheter, IsRefusedWithAReasonAwayFromAHole) {
  const Slab bench;
  const auto refusal = [&](sim::Lockstep& run, const auto& approach) {
    approach();
    const auto refused = events_of<CatheterRefused>(run.engine());
    EXPECT_TRUE(events_of<CatheterEntered>(run.engine()).empty());
    EXPECT_EQ(refused.size(), 1u) << "reported once until the catheter is lifted";
    return refused.empty() ? std::string() : refused[0].first.reason;
  };
  const auto down = [](sim::Lockstep& run, double x, const glm::dquat& turn, double to) {
    for (double z = 4; z > to; z -= 0.05) tick(run, {x, 0, z}, turn);
    // An obstruction of a moment is no refusal: a hand turns the catheter while it approaches.
    const std::size_t before = events_of<CatheterRefused>(run.engine()).size();
    for (int i = 0; i < 100; ++i) tick(run, {x, 0, to}, turn);
    EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), before);
    for (int i = 0; i < 200; ++i) tick(run, {x, 0, to}, turn);
  };
  {
    sim::Lockstep run = bench.run();
    EXPECT_NE(refusal(run, [&] { down(run, 0, k_upright, -3); }).find("Drill a burr hole"),
              std::string::npos);
    down(run, 0, k_upright, -3);
    EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), 2u) << "the catheter was lifted in between";
  }
  {
    sim::Lockstep run = bench.run(1000, {1.1, -6.3});
    drill_hole(run);
    EXPECT_NE(refusal(run, [&] { down(run, 0, k_upright, -6.2); }).find("widen the hole"), std::string::npos);
  }
  {
    sim::Lockstep run = bench.run();
    drill_hole(run);
    const glm::dquat lying = glm::angleAxis(1.2, dvec3(0, 1, 0));
    EXPECT_NE(refusal(run, [&] { down(run, 0, lying, -5.8); }).find("edge of the hole"), std::string::npos);
    // The catheter enters when it is turned along the hole, without being lifted.
    for (double angle = 1.2; angle > 0; angle -= 0.01)
      tick(run, {0, 0, -5.8}, glm::angleAxis(angle, dvec3(0, 1, 0)));
    EXPECT_EQ(events_of<CatheterEntered>(run.engine()).size(), 1u);
    EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), 1u) << "reported once";
  }
  {
    sim::Lockstep run = bench.run(1000, {}, {.has_stylet = false});
    drill_hole(run);
    EXPECT_NE(refusal(run, [&] { down(run, 0, k_upright, -6.2); }).find("stylet"), std::string::npos);
  }
  // The check of the instrument refuses a scan without ventricles.
  haptics::TouchScene plain = sim::small_bone();
  EXPECT_TRUE(catheter_type().check(catheter({}).parameters.data(), plain).has_value());
}

TEST(Catheter, StopsBeforeTheLayerThatItCannotEnter) {
  const Slab bench;
  sim::Lockstep run = bench.run(1000, {1.1, -6.3});  // the hole is narrower than the catheter
  drill_hole(run);
  double deepest = 0, strongest = 0;
  const auto watch = [&](const ServoRecord& r, double) {
    deepest = std::min(deepest, r.proxy_world.z);
    strongest = std::max(strongest, r.force_world.z);
  };
  move(run, 1000, 4, -35, 20, watch);
  EXPECT_GT(deepest, k_inner - 1.2);
  EXPECT_GT(strongest, 4) << "the hand perceives the obstruction";
  EXPECT_TRUE(events_of<CatheterEntered>(run.engine()).empty());
  EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), 1u);
  // Every press is answered.
  const auto press = [&](double z) {
    for (int i = 0; i < 300; ++i) {
      const std::array<haptics::Pose, 2> poses{haptics::Pose{{0, 0, 12}, k_upright, false},
                                               haptics::Pose{{0.2, 0.1, z}, k_upright, i > 50}};
      run.step(std::span<const haptics::Pose>(poses));
    }
  };
  press(-8);
  EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), 2u);
  press(-8);
  EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), 3u);
  // It can be drawn out, and bone blocks it again.
  move(run, 1000, -8, 4, 20, k_ignore);
  EXPECT_FALSE(state_of(run).is_blocked);
  EXPECT_TRUE(events_of<CatheterWithdrawn>(run.engine()).empty());
  EXPECT_FALSE(run.engine().servo_scene()->hands[1].passable_items.contains(0));
}

TEST(Catheter, StaysInTheHeadUntilItIsDrawnOut) {
  const Slab bench;
  sim::Lockstep run = bench.run();
  drill_hole(run);
  move(run, 1000, 4, -20, 40, k_ignore);
  ASSERT_TRUE(state_of(run).has_entered);
  EXPECT_TRUE(run.apply_and_finish({sim::RemoveInstrument{}, 1}).refused.has_value());
  EXPECT_TRUE(run.apply_and_finish({Catheter{4, 150, true}, 1}).refused.has_value());
  EXPECT_FALSE(run.apply_and_finish({sim::RemoveInstrument{}, 0}).refused.has_value());
  // An undo restores the bone. It does not undo the passage through the brain.
  run.undo();
  EXPECT_EQ(run.engine().removed_mm3(), 0);
  EXPECT_TRUE(state_of(run).has_entered);
  EXPECT_EQ(measure(run.engine(), "catheter passages"), 1);
  // The overlays show depth marks and, after the pop into the ventricle, the label "CSF".
  const auto labels = [&] {
    std::vector<std::string> all;
    for (const sim::Overlay& overlay : run.engine().overlays())
      for (const auto& label : overlay.labels) all.push_back(label.text);
    return all;
  };
  const auto has = [](const std::vector<std::string>& all, const char* text) {
    return std::find(all.begin(), all.end(), text) != all.end();
  };
  EXPECT_TRUE(has(labels(), "5 cm"));
  EXPECT_FALSE(has(labels(), "CSF"));
  move(run, 1000, -20, -36, 40, k_ignore);
  EXPECT_TRUE(has(labels(), "CSF"));
}

TEST(Catheter, ItsHubStopsAtTheHead) {
  const Slab bench;
  sim::Lockstep run = bench.run(1000, {}, {.length = 40});
  drill_hole(run);
  const ServoRecord deep = move(run, 1000, 4, -50, 40, k_ignore);
  EXPECT_NEAR(deep.force_world.z, std::min(5.0, 50 - 6.3 - 40) + 0.05, 0.3);
}

TEST(Catheter, LockstepReplayAndSeekGiveTheSameState) {
  const sim::Folder folder;
  const std::string path = folder.file("catheter.session");
  const Slab bench;
  std::uint64_t state = 0, inside = 0, inside_tick = 0;
  {
    haptics::ServoOptions options;
    const auto start = bench.hands();
    sim::SceneDescription spec = sim::describe_scene(std::span(start), options);
    spec.plan = *bench.plan;
    auto writer = sim::SessionWriter::create(path, spec, bench.base(), catalogue());
    ASSERT_TRUE(writer.is_ok()) << writer.error().message();
    sim::Lockstep run(sim::Engine(bench.hands(), 1e-3, catalogue(), {}, bench.plan), {}, 1000,
                      writer.value().get());
    drill_hole(run);
    move(run, 1000, 4, -25, 60, k_ignore);
    inside_tick = run.engine().state().next_tick, inside = run.engine().state().hash();
    move(run, 1000, -25, -36, 60, k_ignore);
    EXPECT_FALSE(run.apply_and_finish({JudgeCatheter{}, 1}).refused.has_value());
    move(run, 1000, -36, 4, 100, k_ignore);
    state = run.engine().state().hash();
    ASSERT_FALSE(writer.value()->finish(run.engine()));
  }
  const sim::Verdict verdict = sim::replay(path, bench.base(), catalogue());
  sim::expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
  auto opened = sim::SessionReader::open(path, catalogue());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto run = sim::Replay::open(opened.value(), bench.base());
  ASSERT_TRUE(run.is_ok()) << run.error().message();
  ASSERT_FALSE(run.value()->seek(inside_tick));
  EXPECT_EQ(run.value()->engine().state().hash(), inside);
}

}  // namespace
}  // namespace trephine::ventriculostomy
