// Detached bodies: touched, grasped, released, restored by undo.
#include <algorithm>
#include <array>
#include <chrono>
#include <thread>

#include "haptics/device/device.h"
#include "sim/drivers/live_session.h"
#include "tests/sim/crowd.h"
#include "tests/sim/opens_anywhere.h"
#include "tests/sim/saw_bench.h"

namespace trephine::sim {
namespace {

const PieceFreed* find_freed(const Engine& engine) {
  const Chronicle& all = engine.state().chronicle;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (const auto* freed = all[i].value.as<PieceFreed>()) return freed;
  return nullptr;
}

// Hand 2 saws a disk out, and lifts it against hand 1, which rests on the disk.
TEST(Bodies, ADiskIsSawnOutAndLiftedAgainstTheOtherHand) {
  const Folder folder;
  const std::string path = folder.file("disk.session");
  SawBench bench;
  {
    auto writer = bench.writer(path, with_checkpoint_work(1500));
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    const haptics::PosePath first = resting(), second = sawing();
    double resting_at = 0, at_freedom = 0, at_lift = 0, min_after = 1e9, max_after = -1e9;
    double force_before = 0, force_after = 0;
    std::int64_t removed = 0;
    for (int i = 0; i < static_cast<int>(1000 * k_end); ++i) {
      const double t = 1e-3 * i;
      const haptics::Pose poses[2] = {first.at(t), second.at(t)};
      const auto records = run.step(poses);
      const haptics::ServoRecord& rests = records[0];
      if (i == 3000) resting_at = rests.proxy_world.z, force_before = glm::length(rests.force_world);
      if (i == static_cast<int>(1000 * k_sawn)) {
        removed = run.engine().version()->ledger().total();
        const Outcome freed = detach_pieces(run);
        EXPECT_TRUE(freed.is_changed && freed.is_edit);
        ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
        EXPECT_FALSE(run.apply({RemoveInstrument{}, 1}).refused);
      }
      if (i == static_cast<int>(1000 * k_sawn) + 50) at_freedom = rests.proxy_world.z;
      if (i == static_cast<int>(1000 * k_lift)) {
        at_lift = rests.proxy_world.z;
        EXPECT_FALSE(run.apply({HoldBody{{1}}, 1}).refused);
      }
      if (i > static_cast<int>(1000 * k_sawn)) {
        min_after = std::min(min_after, rests.proxy_world.z);
        max_after = std::max(max_after, rests.proxy_world.z);
      }
      force_after = glm::length(rests.force_world);
    }
    // The detached disk does not count as removed matter. A hand that rests on the disk perceives no change.
    EXPECT_EQ(run.engine().version()->ledger().total(), removed);
    const PieceFreed* freed = find_freed(run.engine());
    ASSERT_NE(freed, nullptr);
    const double r = k_circle - k_saw;
    EXPECT_NEAR(freed->size, 3.14159265 * r * r * 4 / std::cos(0.1745), 0.06 * freed->size);
    EXPECT_NEAR(at_freedom, resting_at, 0.1);
    EXPECT_NEAR(at_lift, resting_at, 0.1);
    EXPECT_GT(min_after, resting_at - 0.1);
    // The disk is lifted by 3 mm. It lifts the proxy of the hand that rests on it, against the spring of that
    // hand.
    EXPECT_GT(max_after, resting_at + 2.5);
    EXPECT_GT(force_after, force_before + 0.8);
    // The disk is released at its current position. Undo returns it to its original position.
    EXPECT_FALSE(run.apply({ReleaseBody{}, 1}).refused);
    EXPECT_NEAR(run.engine().state().undoable.bodies[0].placement.position_world.z, 3, 0.6);
    EXPECT_EQ(run.engine().state().undoable.bodies[0].holder, -1);
    run.apply({DiscardBody{{1}}, 0});
    EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
    const std::int64_t without = run.engine().version()->ledger().detached_units;
    EXPECT_GT(without, 0);
    for (int n = 0; n < 2; ++n) run.undo();  // discard and release; a grasp is not undoable
    ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
    EXPECT_EQ(run.engine().state().undoable.bodies[0].placement, haptics::Placement{});
    run.undo();
    EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
    EXPECT_EQ(run.engine().version()->ledger().detached_units, 0);
    for (int n = 0; n < 40; ++n) {
      const haptics::Pose poses[2] = {first.at(k_end), second.at(k_end)};
      run.step(poses);
    }
    for (int n = 0; n < 3; ++n) run.redo();
    EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
    EXPECT_EQ(run.engine().version()->ledger().detached_units, without);
    run.undo();
    for (int n = 0; n < 300; ++n) {
      const haptics::Pose poses[2] = {first.at(k_end), second.at(k_end)};
      run.step(poses);
    }
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  expect_opens_anywhere(path, drilling_catalogue(), bench.scene.base);
}

TEST(Bodies, AreTheSameLiveInReplayAndAfterSeek) {
  const Folder folder;
  const std::string path = folder.file("live.session");
  SawBench bench;
  std::uint64_t state = 0;
  {
    auto writer = bench.writer(path, with_checkpoint_work(1500));
    haptics::PlaybackDevice first(resting()), second(sawing());
    const std::array<haptics::Device*, 2> devices{&first, &second};
    LiveSession live(devices, bench.engine(), {}, writer.get());
    ASSERT_FALSE(live.start());
    const auto wait_for = [&](auto&& is_so) {
      for (int i = 0; i < 12000 && !is_so(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    wait_for([&] { return live.fetch_state().newest.t > k_sawn; });
    live.apply(FreePieces{});
    live.apply({RemoveInstrument{}, 1});
    wait_for([&] { return !live.snapshot().get()->undoable.bodies.empty(); });
    live.apply({HoldBody{{1}}, 1});
    wait_for([&] { return live.fetch_state().newest.t > k_end + 0.1; });
    live.apply({ReleaseBody{}, 1});
    live.undo();
    live.redo();
    wait_for([&] { return live.fetch_state().newest.t > k_end + 0.4; });
    live.stop();
    ASSERT_EQ(live.engine().state().undoable.bodies.size(), 1u);
    state = live.engine().state().hash();
    EXPECT_FALSE(writer->finish(live.engine()));
  }
  const Verdict verdict = replay(path, bench.scene.base);
  expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
  expect_opens_anywhere(path, drilling_catalogue(), bench.scene.base, 3);
}

TEST(Bodies, InvalidCommandsAreRefusedWithAReasonAndChangeNothing) {
  SawBench bench;
  Lockstep run(bench.engine(), {}, 1000);
  const auto expect_refused = [&](const Command& command, const char* words) {
    const std::uint64_t before = run.engine().snapshot()->hash();
    const Outcome outcome = run.apply(command);
    ASSERT_TRUE(outcome.refused) << words;
    EXPECT_NE(outcome.refused->message().find(words), std::string::npos) << outcome.refused->message();
    EXPECT_EQ(run.engine().snapshot()->hash(), before);
  };
  expect_refused(FreePieces{3}, "unknown shape");
  expect_refused(FreePieces{-1}, "item");
  expect_refused(FreePieces{0, -1}, "smallest");
  expect_refused(HoldBody{{1}}, "unknown body");
  expect_refused(DiscardBody{{1}}, "unknown body");
  expect_refused(ReleaseBody{}, "holds no body");

  // An event reports that nothing was detached.
  const Outcome begun = run.apply(FreePieces{});
  run.apply(run.engine().run_job(begun.job));
  const Chronicle& events = run.engine().state().chronicle;
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].value.as<JobDiscarded>()->reason, "no part is disconnected");

  // Two hands cannot hold one body.
  const haptics::PosePath first = resting(), second = sawing();
  saw(run);
  {
    // The result of a job is discarded if a cut is made while the job runs.
    const Outcome early = run.apply(FreePieces{});
    const AdoptJob adopt = run.engine().run_job(early.job);
    haptics::Pose cuts[2] = {first.at(k_sawn), second.at(k_sawn)};
    cuts[1].position_world = {8, 8, 1};
    cuts[1].buttons = 1;
    run.step(cuts);
    cuts[1].buttons = 0;
    run.step(cuts);
    run.apply(adopt);
    EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
    EXPECT_EQ(events[1].value.as<JobDiscarded>()->reason, "the anatomy changed meanwhile; start it again");
  }
  detach_pieces(run);
  ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
  const Id id = run.engine().state().undoable.bodies[0].id;
  expect_refused(HoldBody{{id.value + 1}}, "unknown body");
  EXPECT_FALSE(run.apply({HoldBody{id}, 1}).refused);
  expect_refused(Command(HoldBody{id}, 0), "held by a hand");
  expect_refused(Command(HoldBody{id}, 1), "held by a hand");
  expect_refused(Command(ReleaseBody{}, 0), "holds no body");
  expect_refused(PlaceModel{run.engine().state().undoable.bodies[0].mover, dvec3(0)}, "unknown moving model");
  expect_refused(SwitchItem{1, false}, "unknown item");
  // After Resume, with which a session continues, no hand holds a body.
  run.apply(Resume{});
  EXPECT_EQ(run.engine().state().undoable.bodies[0].holder, -1);
  expect_refused(Command(HoldBody{id}, 1), "the hand's position is unknown");

  // The method implicit does not support detached bodies.
  SawBench other("implicit");
  Lockstep elsewhere(other.engine(), {}, 1000);
  const Outcome no = elsewhere.apply(FreePieces{});
  ASSERT_TRUE(no.refused);
  EXPECT_NE(no.refused->message().find("does not support detached bodies"), std::string::npos);
}

// Neither release nor undo pushes a hand near the body.
TEST(Bodies, NoHandIsPushedByReleaseOrUndo) {
  SawBench bench;
  Lockstep run(bench.engine(), {}, 1000);
  haptics::Pose poses[2];
  double max_force = 0;
  const auto step = [&] {
    for (const haptics::ServoRecord& r : run.step(poses)) {
      max_force = std::max(max_force, glm::length(r.force_world));
      EXPECT_LT(glm::length(r.proxy_world - r.pose.position_world), 0.2);
    }
  };
  saw(run);
  run.apply({RemoveInstrument{}, 1});
  detach_pieces(run);
  poses[0] = resting().at(k_sawn), poses[1] = sawing().at(k_sawn);
  poses[0].position_world = {0, 0, 9};  // away from the body
  for (int i = 0; i < 600; ++i) run.step(poses);
  max_force = 0;
  // Hand 2 moves next to the disk, grasps it, and carries it 30 mm along an arc and down again.
  for (int i = 0; i <= 300; ++i) poses[1].position_world = {k_circle, 0, 8 - 0.01 * i}, step();
  EXPECT_FALSE(run.apply({HoldBody{{1}}, 1}).refused);
  for (int i = 0; i <= 600; ++i) {
    poses[1].position_world = {k_circle + 0.05 * i, 0, 5 + 8 * std::sin(3.14159265 * i / 600)};
    step();
  }
  EXPECT_FALSE(run.apply({ReleaseBody{}, 1}).refused);
  for (int i = 0; i < 100; ++i) step();
  EXPECT_NEAR(run.engine().state().undoable.bodies[0].placement.position_world.x, 30, 0.1);
  // Hand 1 is in the air between the original and the new position during undo and redo.
  poses[0].position_world = {20, 0, 9};
  for (int i = 0; i < 100; ++i) step();
  for (int n = 0; n < 3; ++n) {
    run.undo();
    for (int i = 0; i < 60; ++i) step();
    EXPECT_EQ(run.engine().state().undoable.bodies[0].holder, -1);
    run.redo();
    for (int i = 0; i < 60; ++i) step();
  }
  EXPECT_FALSE(run.apply({HoldBody{{1}}, 1}).refused);
  poses[1].position_world.z += 4;
  for (int i = 0; i < 60; ++i) step();
  run.undo();  // undoes the release: the hand has already grasped the disk again, and keeps it
  for (int i = 0; i < 60; ++i) step();
  EXPECT_EQ(run.engine().state().undoable.bodies[0].holder, 1);
  EXPECT_LT(max_force, 1e-9);
}

TEST(Bodies, ToolsAndBodiesMayChangeTogether) {
  SawBench bench;
  Lockstep run(bench.engine(), {}, 1000);
  haptics::Pose poses[2] = {resting().at(k_sawn), sawing().at(k_sawn)};
  saw(run);
  run.apply({RemoveInstrument{}, 1});
  // Both tools are requested before the body is detached, and adopted afterwards.
  const Outcome begun = run.apply(ToolGeometry{1, {}});
  const AdoptJob ball = run.engine().run_job(begun.job);
  const Outcome chain = run.apply(ToolGeometry{0.5, {{0, 0, 0}, {0, 0, 3}}});
  const AdoptJob several = run.engine().run_job(chain.job);
  detach_pieces(run);
  ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
  // A chain also touches the detached body: the chain rests on the body as a ball does.
  const auto rests_at = [&] {
    poses[0].position_world = {0, 0, 12};
    for (int i = 0; i < 400; ++i) run.step(poses);
    haptics::ServoRecord on;
    for (int i = 0; i < 800 && !on.has_contact; ++i) {
      poses[0].position_world.z = 12 - 0.02 * i;
      on = run.step(poses)[0];
    }
    EXPECT_TRUE(on.has_contact);
    EXPECT_EQ(on.shape, haptics::item_count(*run.engine().tool(0).scene));  // the first body
    return on.proxy_world.z;
  };
  EXPECT_TRUE(run.apply(several).is_changed);
  EXPECT_STREQ(run.engine().tool(0).method->name(), "chain");
  const double chain_rests = rests_at();
  EXPECT_TRUE(run.apply(ball).is_changed);
  EXPECT_NEAR(rests_at() - chain_rests, 0.5, 0.15);  // difference of the radii
  EXPECT_FALSE(run.apply(DiscardBody{{1}}).refused);
  poses[0].position_world = {0, 0, 6};
  for (int i = 0; i < 400; ++i) run.step(poses);
  haptics::ServoRecord r;
  for (int i = 0; i < 400; ++i) {
    poses[0].position_world.z = 6 - 0.02 * i;
    r = run.step(poses)[0];
  }
  EXPECT_FALSE(r.has_contact);  // through the hole
  EXPECT_NEAR(r.proxy_world.z, poses[0].position_world.z, 1e-6);

  // Undo also restores a body while a hand has a chain.
  const Outcome now = run.apply(ToolGeometry{0.5, {{0, 0, 0}, {0, 0, 3}}});
  EXPECT_TRUE(run.apply(run.engine().run_job(now.job)).is_changed);
  EXPECT_FALSE(run.apply(Undo{}).refused);
  EXPECT_EQ(run.engine().state().undoable.bodies.size(), 1u);
}

// The grasp is not undoable state: undo of a cut elsewhere releases nothing.
TEST(Bodies, UndoOfAStrokeReleasesNothing) {
  SawBench bench;
  Lockstep run(bench.engine(), {}, 1000);
  saw(run);
  run.apply({RemoveInstrument{}, 1});
  detach_pieces(run);
  haptics::Pose poses[2];
  poses[0].position_world = {0, 0, 12};
  poses[1].position_world = {k_circle, 0, 8};
  const auto step = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) run.step(poses);
  };
  step(2);
  EXPECT_FALSE(run.apply({HoldBody{{1}}, 1}).refused);
  for (int i = 0; i < 500; ++i) poses[1].position_world.z += 0.04, run.step(poses);
  EXPECT_FALSE(run.apply({drilling::burr({3, 60, 40, true}).parameters, 0}).refused);
  const std::size_t strokes = run.engine().stroke_count();
  poses[0].buttons = 1;
  for (int i = 0; i < 200; ++i) poses[0].position_world = {9, 9 - 0.05 * i, 1}, run.step(poses);
  poses[0].buttons = 0;
  step(3);
  ASSERT_GT(run.engine().stroke_count(), strokes);
  for (const bool is_undo : {true, false, true}) {
    const Outcome moved = is_undo ? run.undo() : run.redo();
    EXPECT_TRUE(moved.is_edit);
    step(20);
    ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
    EXPECT_EQ(run.engine().state().undoable.bodies[0].holder, 1);
  }
  EXPECT_FALSE(run.apply({ReleaseBody{}, 1}).refused);
  EXPECT_NEAR(run.engine().state().undoable.bodies[0].placement.position_world.z, 20, 0.1);
  // Undo of the release leaves the body in no hand; undo of the detachment removes the body, even from a
  // hand.
  run.undo();
  EXPECT_EQ(run.engine().state().undoable.bodies[0].holder, -1);
  EXPECT_FALSE(run.apply({HoldBody{{1}}, 1}).refused);
  run.undo();
  EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
  EXPECT_TRUE(run.apply({ReleaseBody{}, 1}).refused);
}

// A hand has a fault while it touches a body, and the body is discarded during the fault. Checkpoints contain
// no discarded bodies, and the session still opens at any tick.
TEST(Bodies, AFaultOnABodyThatIsThenDiscardedOpensAgain) {
  const Folder folder;
  const std::string path = folder.file("fault.session");
  SawBench bench;
  {
    auto writer = bench.writer(path, with_checkpoint_work(600));
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    const haptics::PosePath first = resting(), second = sawing();
    haptics::Pose poses[2];
    for (int i = 0; i < 3900; ++i) {
      poses[0] = first.at(std::min(1e-3 * i, k_end)), poses[1] = second.at(std::min(1e-3 * i, k_sawn));
      if (i >= 3500 && i < 3800) poses[0].position_world.x = std::nan("");
      run.step(poses);
      if (i == static_cast<int>(1000 * k_sawn)) {
        run.apply({RemoveInstrument{}, 1});
        detach_pieces(run);
      }
      if (i == 3600) {
        EXPECT_FALSE(run.apply(DiscardBody{{1}}).refused);
      }
    }
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  expect_opens_anywhere(path, drilling_catalogue(), bench.scene.base, 3);
}

TEST(Bodies, MoreThanEightAreNotDetachedAndDebrisIsReported) {
  SawBench bench;
  Lockstep run(bench.engine(), {}, 1000);
  // Straight cuts in a grid leave blocks.
  const auto cut = [&](const dvec3& from, const dvec3& to) {
    haptics::Pose poses[2];
    poses[0].position_world = {0, 0, 9};
    poses[0].buttons = 0;
    for (int i = 0; i <= 200; ++i) {
      poses[1].position_world = from + (i / 200.0) * (to - from);
      poses[1].buttons = i < 200;
      run.step(poses);
    }
  };
  const auto cut_through = [&](const dvec3& from, const dvec3& to) {
    for (const double z : {3.2, 1.6, 0.0, -1.6, -3.2}) cut(from + dvec3(0, 0, z), to + dvec3(0, 0, z));
  };
  for (const double at : {-8.0, -3.0, 2.0, 7.0}) {
    cut_through({at, -13, 0}, {at, 13, 0});
    cut_through({-13, at, 0}, {13, at, 0});
  }
  const std::int64_t removed = run.engine().version()->ledger().total();
  const std::uint64_t before = run.engine().snapshot()->undoable.version->content_hash();
  detach_pieces(run);
  EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
  EXPECT_EQ(run.engine().snapshot()->undoable.version->content_hash(), before);
  const Chronicle& events = run.engine().state().chronicle;
  ASSERT_GT(events.size(), 0u);
  const auto* discarded = events[events.size() - 1].value.as<JobDiscarded>();
  ASSERT_NE(discarded, nullptr);
  EXPECT_NE(discarded->reason.find("there is room for 8"), std::string::npos) << discarded->reason;
  // If larger bodies are requested, all blocks are debris.
  const Outcome begun = run.apply(FreePieces{0, 60});
  run.apply(run.engine().run_job(begun.job));
  const Event& last = events[events.size() - 1];
  const auto* debris = last.value.as<DebrisFreed>();
  ASSERT_NE(debris, nullptr) << last.value.words();
  EXPECT_GT(debris->count, 3);
  EXPECT_GT(debris->size, 10);
  EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
  const volume::Version& left = *run.engine().version();
  EXPECT_EQ(left.ledger().total(), removed);
  EXPECT_NEAR(left.mm3_of(left.ledger().detached_units), debris->size, 1e-6);
}

}  // namespace
}  // namespace trephine::sim
