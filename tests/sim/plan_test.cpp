// Plans, time and results in the state of an operation.
#include "tests/sim/toy_bench.h"

namespace trephine::sim {
namespace {

volume::SurgicalPlan sample_plan() {
  volume::SurgicalPlan plan;
  plan.trajectories.push_back({"L4 left pedicle", {1.5, 2, 3}, {-4, 5, 6.25}, 5.5, "screws", "left", "L4"});
  plan.trajectories.push_back({"access", {0, 0, 1}, {0, 0, -1}});
  plan.landmarks.push_back({"nasion", {0.1, -80, 12}});
  plan.outlines.push_back({"flap", {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}});
  plan.planes.push_back({"band", {0, 0, 40}, {0, 0.6, 0.8}});
  plan.targets.push_back({"tumour", "tumour"});
  return plan;
}

TEST(Plan, IsPartOfASceneDescription) {
  const haptics::TouchScene scene = small_bone();
  Bench bench;
  SessionHeader header = bench.header();
  header.plan = sample_plan();
  const std::string text = encode(header);
  const auto back = decode_header(text);
  ASSERT_TRUE(back.is_ok()) << back.error().message();
  EXPECT_EQ(back.value().plan, header.plan);
  EXPECT_EQ(encode(back.value()), text);
  for (const char* lines :
       {"trajectory=", "trajectory=a", "trajectory=access\ntrajectory_entry=1 2 3", "trajectory_entry=1 2",
        "trajectory_entry=1 2 x", "trajectory_diameter=101", "trajectory_side=up", "plane_normal=0 0 0.5",
        "plane=flat\nplane_normal=0 0 nan", "outline=two points\noutline_point=0 0 0\noutline_point=1 0 0",
        "outline_point=1 2", "target=without a label", "landmark=nasion", "landmark_at=1e9 0 0",
        "trajectory_colour=red"})
    EXPECT_FALSE(decode_header(text + lines + "\n").is_ok()) << lines;
  // A line of an object is refused if the line with the object's name does not precede it.
  for (const char* line : {"trajectory_entry=1 2 3", "trajectory_side=left", "outline_point=1 2 3",
                           "plane_at=1 2 3", "target_label=tumour", "landmark_at=1 2 3"})
    EXPECT_FALSE(decode_header(encode(bench.header()) + line + "\n").is_ok()) << line;
}

TEST(Plan, IsInTheStateOfLockstepAndReplayWithoutItsCase) {
  const Folder folder;
  const std::string path = folder.file("planned.session");
  const ToyBench bench;
  SceneDescription spec = describe_scene(bench.scene, *bench.method, {}, burr_spec());
  spec.plan = sample_plan();
  auto start = build_scene(spec, bench.scene.base, toys());
  ASSERT_TRUE(start.is_ok()) << start.error().message();
  const auto plan = start.value().plan;
  ASSERT_NE(plan, nullptr);
  const SessionHeader header = describe_built_scene(spec, start.value());
  EXPECT_EQ(header.plan, spec.plan);
  auto writer = SessionWriter::create(path, header, bench.scene.base, toys());
  ASSERT_TRUE(writer.is_ok()) << writer.error().message();
  Lockstep run(Engine(start.value().hands, 1e-3, toys(), {}, plan), {}, 1000, writer.value().get());
  for (int i = 0; i < 300; ++i) run.step(drilling_path(1).at(1e-3 * i));
  EXPECT_EQ(run.engine().state().dt, 1e-3);
  EXPECT_NEAR(run.engine().state().seconds(), 0.3, 1e-12);
  EXPECT_EQ(*run.engine().snapshot()->plan, sample_plan());
  ASSERT_FALSE(writer.value()->finish(run.engine()));

  auto opened = SessionReader::open(path, toys());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto replay = Replay::open(opened.value(), bench.scene.base);
  ASSERT_TRUE(replay.is_ok()) << replay.error().message();
  for (const std::uint64_t tick : {300u, 100u, 0u, 250u}) {
    ASSERT_FALSE(replay.value()->seek(tick)) << tick;
    const OperationState& state = replay.value()->engine().state();
    ASSERT_NE(state.plan, nullptr) << tick;
    EXPECT_EQ(*state.plan, sample_plan()) << tick;
    EXPECT_NEAR(state.seconds(), 1e-3 * static_cast<double>(tick), 1e-12);
  }
  // If the operation has no plan, its state has a null pointer.
  EXPECT_EQ(bench.engine().state().plan, nullptr);
}

/// Returns the measure `found` of the toy module.
Measure found(const Engine& engine) {
  for (Measure& measure : engine.measures())
    if (measure.name == "found") return measure;
  return {};
}

TEST(ModuleResult, IsStaleAfterACutAndAfterUndo) {
  const Folder folder;
  const std::string path = folder.file("results.session");
  const ToyBench bench;
  std::vector<std::pair<std::uint64_t, bool>> expected;  // tick, is_stale
  {
    auto writer = bench.toy_writer(path);
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    const auto note = [&] {
      run.step({{0, 0, 40}, {1, 0, 0, 0}, false});
      expected.emplace_back(run.engine().state().next_tick, found(run.engine()).is_stale);
    };
    const dvec3 outside(0, 0, 90);  // a flood there removes nothing
    note();
    ASSERT_FALSE(run.apply_and_finish({ToyFlood{outside}, 0}).refused);
    EXPECT_NE(found(run.engine()).value, 0);
    note();
    ASSERT_FALSE(run.apply({ToyMark{dvec3(1)}, 0}).refused);  // changes no anatomy
    note();
    ASSERT_FALSE(run.apply({ToyCarve{dvec3(0)}, 0}).refused);
    note();
    ASSERT_FALSE(run.apply_and_finish({ToyFlood{outside}, 0}).refused);
    note();
    run.undo(), run.undo();  // the change by the flood, then the cut
    note();
    ASSERT_FALSE(writer->finish(run.engine()));
  }
  const std::vector<bool> stale{false, false, false, true, false, true};
  ASSERT_EQ(expected.size(), stale.size());
  for (std::size_t i = 0; i < stale.size(); ++i) EXPECT_EQ(expected[i].second, stale[i]) << i;
  // A replay has the same values at each of these ticks.
  expect_same(replay(path, bench.scene.base, toys()));
  auto opened = SessionReader::open(path, toys());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto run = Replay::open(opened.value(), bench.scene.base);
  ASSERT_TRUE(run.is_ok()) << run.error().message();
  for (const std::size_t i : {5u, 0u, 3u, 1u, 4u}) {
    ASSERT_FALSE(run.value()->seek(expected[i].first)) << i;
    EXPECT_EQ(found(run.value()->engine()).is_stale, stale[i]) << i;
  }
}

/// A job that ends after a cut describes the anatomy in which it began. Its result is therefore stale.
TEST(ModuleResult, OfAJobDescribesTheAnatomyInWhichItBegan) {
  const ToyBench bench;
  Engine engine = bench.engine();
  const Outcome begun = engine.apply(Command(ToyFlood{dvec3(0, 0, 90)}, 0));
  ASSERT_FALSE(begun.refused);
  ASSERT_FALSE(engine.apply(Command(ToyCarve{dvec3(0)}, 0)).refused);
  ASSERT_FALSE(engine.apply(Command(engine.run_job(begun.job), 0)).refused);
  EXPECT_TRUE(found(engine).is_stale);
}

}  // namespace
}  // namespace trephine::sim
