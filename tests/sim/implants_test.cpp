// Implants: bodies that a job adds, fixed or movable, and their motion to their final position.
#include <glm/gtc/quaternion.hpp>

#include "tests/sim/toy_bench.h"

namespace trephine::sim {
namespace {

constexpr double k_above = 6;  // mm, height of the implants above the middle of the plate

/// Runs `ticks` ticks with the hand at rest at a position. Returns the last record.
haptics::ServoRecord rest(Lockstep& run, const dvec3& at, int ticks = 1) {
  haptics::ServoRecord record;
  for (int i = 0; i < ticks; ++i) record = run.step({at, {1, 0, 0, 0}, false});
  return record;
}

TEST(Implants, TwelveFixedOnesAreTouchedUndoneAndReplayed) {
  const Folder folder;
  const std::string path = folder.file("implants.session");
  const ToyBench bench;
  std::uint64_t state = 0, planted_at = 0;
  {
    auto writer = bench.toy_writer(path);
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    rest(run, {0, 0, 40}, 5);
    ASSERT_FALSE(run.apply_and_finish({ToyPlant{{-8, 0, k_above}, 12}, 0}).refused);
    ASSERT_EQ(run.engine().state().undoable.bodies.size(), 12u);
    int added = 0;
    const Chronicle& chronicle = run.engine().state().chronicle;
    for (std::size_t i = 0; i < chronicle.size(); ++i) {
      const auto* event = chronicle[i].value.as<BodyAdded>();
      if (event == nullptr) continue;
      EXPECT_NEAR(event->size, 1, 1e-6);
      ++added;
    }
    EXPECT_EQ(added, 12);
    rest(run, {0, 0, 40});
    planted_at = run.engine().state().next_tick;  // a tick after the implants were added
    for (const Body& body : run.engine().state().undoable.bodies) {
      EXPECT_EQ(body.mover, -1);
      EXPECT_EQ(body.matter, volume::Matter::titanium);
      EXPECT_TRUE(body.is_implant && body.is_fixed);
    }
    // The hand rests on the first cube, half a millimetre above the cube's centre.
    rest(run, {-8, 0, k_above + 4}, 5);
    for (double z = k_above + 4; z > k_above; z -= 0.05) rest(run, {-8, 0, z});
    const haptics::ServoRecord on_top = rest(run, {-8, 0, k_above}, 20);
    EXPECT_TRUE(on_top.has_contact);
    EXPECT_NEAR(on_top.proxy_world.z, k_above + 0.5, 1e-3);
    EXPECT_GT(on_top.force_world.z, 0.1);
    // A fixed body can be neither grasped nor placed.
    const Id first = run.engine().state().undoable.bodies[0].id;
    for (const Command& command : {Command(HoldBody{first}, 0), Command(PlaceBody{first, dvec3(0)}, 0)}) {
      const Outcome outcome = run.apply(command);
      ASSERT_TRUE(outcome.refused.has_value());
      EXPECT_NE(outcome.refused->what.find("the body is fixed"), std::string::npos);
    }
    const std::vector<Overlay> overlays = run.engine().overlays();
    EXPECT_EQ(overlays[0].matter, volume::Matter::titanium);
    EXPECT_FALSE(overlays[0].is_detached);
    run.undo();
    EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
    EXPECT_FALSE(rest(run, {-8, 0, k_above}, 20).has_contact);
    run.redo();
    EXPECT_EQ(run.engine().state().undoable.bodies.size(), 12u);
    // Each movable implant needs a mover, and there are eight movers.
    ASSERT_FALSE(run.apply_and_finish({ToyPlant{{-8, 5, k_above}, 8, 0, false}, 0}).refused);
    EXPECT_EQ(run.engine().state().undoable.bodies.size(), 20u);
    const Id last = run.engine().state().undoable.bodies.back().id;
    EXPECT_FALSE(run.apply(Command(PlaceBody{last, dvec3(0, 0, 12)}, 0)).refused);
    ASSERT_FALSE(run.apply_and_finish({ToyPlant{{-8, 5, 9}, 1, 0, false}, 0}).refused);
    EXPECT_EQ(run.engine().state().undoable.bodies.size(), 20u) << "discarded";
    const auto& events = run.engine().state().chronicle;
    const auto* discarded = events[events.size() - 1].value.as<JobDiscarded>();
    ASSERT_NE(discarded, nullptr);
    EXPECT_NE(discarded->reason.find("room for 0"), std::string::npos) << discarded->reason;
    rest(run, {0, 0, 40}, 5);
    state = run.engine().state().hash();
    ASSERT_FALSE(writer->finish(run.engine()));
  }
  const Verdict verdict = replay(path, bench.scene.base, toys());
  expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
  auto opened = SessionReader::open(path, toys());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto run = Replay::open(opened.value(), bench.scene.base);
  ASSERT_TRUE(run.is_ok()) << run.error().message();
  ASSERT_FALSE(run.value()->seek(planted_at));
  EXPECT_EQ(run.value()->engine().state().undoable.bodies.size(), 12u);
  ASSERT_FALSE(run.value()->seek(2));
  EXPECT_TRUE(run.value()->engine().state().undoable.bodies.empty());
}

TEST(Implants, OneInMotionIsAtItsPlaceByTheClockAndNotTouched) {
  const Folder folder;
  const std::string path = folder.file("motion.session");
  const ToyBench bench;
  const auto height = [](const Engine& engine) {
    return engine.placement_of(engine.state().undoable.bodies.at(0)).position_world.z;
  };
  std::uint64_t begin = 0;
  {
    auto writer = bench.toy_writer(path);
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    rest(run, {0, 0, 40}, 10);
    ASSERT_FALSE(run.apply_and_finish({ToyPlant{{0, 0, k_above}, 1, 0.4}, 0}).refused);
    begin = run.engine().state().next_tick;
    EXPECT_NEAR(height(run.engine()), k_above + 10, 1e-9);
    EXPECT_TRUE(run.engine().has_moving_surfaces());
    rest(run, {0, 0, k_above}, 100);  // at the final position of the implant
    EXPECT_NEAR(height(run.engine()), k_above + 7.5, 1e-9);
    // The motion has three turns. After a quarter of the time, three quarters of the turns remain.
    const glm::dquat turn = run.engine().placement_of(run.engine().state().undoable.bodies[0]).rotation;
    const dvec3 side = turn * dvec3(1, 0, 0);
    const double angle = -2 * 3.14159265358979 * 3 * 0.75;
    EXPECT_NEAR(side.x, std::cos(angle), 1e-9);
    EXPECT_NEAR(side.y, std::sin(angle), 1e-9);
    EXPECT_FALSE(rest(run, {0, 0, k_above + 7.5}, 1).has_contact) << "an implant in motion is not touched";
    rest(run, {0, 0, 40}, 298);
    EXPECT_TRUE(run.engine().has_moving_surfaces());
    rest(run, {0, 0, 40}, 1);
    EXPECT_FALSE(run.engine().has_moving_surfaces());
    EXPECT_EQ(height(run.engine()), k_above);
    for (double z = k_above + 4; z > k_above; z -= 0.05) rest(run, {0, 0, z});
    EXPECT_NEAR(rest(run, {0, 0, k_above}, 20).proxy_world.z, k_above + 0.5, 1e-3);
    ASSERT_FALSE(writer->finish(run.engine()));
  }
  expect_same(replay(path, bench.scene.base, toys()));
  auto opened = SessionReader::open(path, toys());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto run = Replay::open(opened.value(), bench.scene.base);
  ASSERT_TRUE(run.is_ok()) << run.error().message();
  for (const std::uint64_t ticks : {300u, 50u, 400u, 1u, 200u}) {
    ASSERT_FALSE(run.value()->seek(begin + ticks)) << ticks;
    EXPECT_NEAR(height(run.value()->engine()), k_above + 10 * (1 - static_cast<double>(ticks) / 400), 1e-9);
  }
}

}  // namespace
}  // namespace trephine::sim
