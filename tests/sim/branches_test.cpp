// Branches: named lines of the undo history, with which an operation continues again from an earlier state.
#include "tests/sim/opens_anywhere.h"
#include "tests/sim/toy_bench.h"

namespace trephine::sim {
namespace {

/// Returns a hash of removed matter and marks.
std::uint64_t undoable_of(const Engine& engine) {
  MixHash all;
  all.add(engine.version()->content_hash());
  all.add(static_cast<std::uint64_t>(Toy::toy_undoable(engine.state()).marks));
  return all.value();
}

TEST(Branches, EachKeepsItsWholeHistory) {
  const ToyBench bench;
  Engine engine = bench.engine();
  const auto done = [&](const Command& command) {
    const Outcome outcome = engine.apply(command);
    EXPECT_FALSE(outcome.refused) << outcome.refused->message();
    return outcome;
  };
  const std::uint64_t bare = undoable_of(engine);
  done(ToyCarve{{-3, 0, 0}});
  const std::uint64_t after_first = undoable_of(engine);
  done(ToyCarve{{3, 0, 0}});
  const std::uint64_t after_second = undoable_of(engine);
  done(Undo{});
  // A second branch begins at this state. The first branch keeps the undone change.
  done(BeginBranch{"other"});
  EXPECT_EQ(engine.branch().name, "other");
  EXPECT_EQ(undoable_of(engine), after_first);
  EXPECT_FALSE(engine.can_redo());
  done(ToyCarve{{0, 0, 0}});
  done(ToyMark{});
  const std::uint64_t other = undoable_of(engine);
  Outcome there = done(SwitchBranch{"main"});
  EXPECT_TRUE(there.is_changed && there.is_edit);
  EXPECT_EQ(undoable_of(engine), after_first);
  EXPECT_TRUE(engine.can_redo());
  // The changed box contains only the cut of the other branch.
  const volume::Frame& frame = bench.scene.base->frame;
  EXPECT_TRUE(there.box.contains(volume::voxel_of(frame.volume_from_world({0, 0, 0}))));
  EXPECT_FALSE(there.box.contains(volume::voxel_of(frame.volume_from_world({3, 0, 0}))));
  done(Redo{});
  EXPECT_EQ(undoable_of(engine), after_second);
  there = done(SwitchBranch{"other"});
  EXPECT_EQ(undoable_of(engine), other);
  EXPECT_TRUE(there.box.contains(volume::voxel_of(frame.volume_from_world({3, 0, 0}))));
  for (int n = 0; n < 3; ++n) done(Undo{});
  EXPECT_EQ(undoable_of(engine), bare);
  EXPECT_FALSE(engine.can_undo());
  // A branch that was left with undone changes is resumed at the state in which it was left.
  done(SwitchBranch{"main"});
  EXPECT_EQ(undoable_of(engine), after_second);
  done(SwitchBranch{"other"});
  EXPECT_EQ(undoable_of(engine), bare);
  for (int n = 0; n < 3; ++n) done(Redo{});
  EXPECT_EQ(undoable_of(engine), other);

  for (const auto& [name, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"main", "already exists"},
           {"other", "already exists"},
           {"", "name of the branch is invalid"},
           {"a\nb", "name of the branch is invalid"},
           {std::string(50, 'x'), "name of the branch is invalid"}}) {
    const Outcome refused = engine.apply(BeginBranch{name});
    ASSERT_TRUE(refused.refused) << name;
    EXPECT_NE(refused.refused->what.find(words), std::string::npos) << refused.refused->what;
  }
  EXPECT_NE(engine.apply(SwitchBranch{"other"}).refused->what.find("already active"), std::string::npos);
  EXPECT_NE(engine.apply(SwitchBranch{"third"}).refused->what.find("unknown branch"), std::string::npos);
  EXPECT_EQ(undoable_of(engine), other);
  for (std::size_t n = 2; n < Engine::k_max_branches; ++n)
    done(BeginBranch{std::string("b").append(std::to_string(n))});
  EXPECT_NE(engine.apply(BeginBranch{"more"}).refused->what.find("too many branches"), std::string::npos);
}

TEST(Branches, ShareCommonStates) {
  const ToyBench bench;
  Engine engine = bench.engine();
  for (int i = 0; i < 8; ++i) engine.apply(ToyCarve{{-6 + 1.5 * i, 0, 0}});
  engine.freeze();
  const std::size_t before = engine.history_bytes(), whole = engine.version()->bytes();
  EXPECT_GT(before, whole);
  engine.apply(BeginBranch{"other"});
  EXPECT_LT(engine.history_bytes() - before, 8192u);  // the tables of one state
  engine.apply(ToyCarve{{0, 4, 0}});
  // One more cut adds only its own bricks and tables: all others are shared.
  const std::size_t added = engine.history_bytes() - before;
  EXPECT_GT(added, 10000u);
  EXPECT_LT(added, 3 * whole / 4);
  EXPECT_LT(before, 6 * whole);  // the history has nine states
}

TEST(Branches, AreTheSameInReplayAndAfterSeek) {
  const Folder folder;
  const std::string path = folder.file("branches.session");
  ToyBench bench;
  auto writer = SessionWriter::create(path, describe_scene(bench.scene, *bench.method, {}, burr_spec()),
                                      bench.scene.base, toys(), with_checkpoint_work(1500))
                    .value();
  Lockstep run(bench.engine(), {}, 1000, writer.get());
  const haptics::PosePath request = drilling_path(20);
  int begun = 0, switched = 0;
  for (int i = 0; i < 9000; ++i) {
    run.step(request.at(1e-3 * i));
    if (i % 900 == 450) begun += !run.apply(BeginBranch{std::string("b").append(std::to_string(i))}).refused;
    if (i % 700 == 350)
      switched += !run.apply(SwitchBranch{run.engine().other_branches().empty()
                                              ? "none"
                                              : run.engine().other_branches()[0].name})
                       .refused;
    if (i % 500 == 100) run.undo();
  }
  EXPECT_EQ(begun, 10);
  EXPECT_GT(switched, 8);
  EXPECT_FALSE(writer->finish(run.engine()));
  expect_opens_anywhere(path, toys(), bench.scene.base);
}

}  // namespace
}  // namespace trephine::sim
