// TakeInstrument: one command sets an instrument and the balls with which it touches.
#include <chrono>
#include <thread>

#include "modules/drilling/perforator.h"
#include "sim/drivers/live_session.h"
#include "tests/sim/session_fixture.h"
#include "volume/base/work_counters.h"

namespace trephine::sim {
namespace {

/// A plate of 8 mm in voxels of 0.5 mm. The hand touches it with a point at the start.
struct TrayBench {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method = haptics::make_method("subvoxel").value();
  TrayBench() {
    data_tools::PhantomOptions o;
    o.size = glm::ivec3(64);
    o.spacing_mm = dvec3(0.5);
    o.psf_sigma_voxels = 1;
    o.parameters = {{"thickness", 8}, {"angle", 0}};
    scene = scenes::phantom_scene("plate", o);
    EXPECT_FALSE(haptics::set_smallest_burr(scene, 3));
    EXPECT_FALSE(method->prepare(scene));
  }
  Engine engine() const {
    return Engine(scene, *method, drilling::burr({3, 30, 20, false}), 1e-3, drilling_catalogue());
  }
  std::unique_ptr<SessionWriter> writer(const std::string& path) const {
    const SessionHeader header =
        describe_scene(scene, *method, {}, {HandSpec(drilling::burr({3, 30, 20, false}))});
    return SessionWriter::create(path, header, scene.base, drilling_catalogue()).value();
  }
};

std::string tool_of(const Engine& engine) { return std::string(engine.state().settings.hands[0].name()); }
double radius_of(const Engine& engine) { return engine.servo_scene()->hands[0].scene->tool->radius(); }

TEST(TakeInstrument, BringsItsBallAndReplaysToTheBit) {
  const Folder folder;
  const std::string path = folder.file("tray.session");
  const TrayBench bench;
  std::uint64_t state = 0;
  {
    auto writer = bench.writer(path);
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    for (int i = 0; i < 20; ++i) run.step({{0, 0, 12}, {1, 0, 0, 0}, false});
    const Instrument perforator = drilling::perforator({});
    const double radius =
        perforator.type->needs(perforator.parameters.data(), *bench.scene.base).tool->radius();
    ASSERT_GE(radius, 5);
    // The hand keeps its burr until the job of the command is adopted.
    const Outcome begun = run.apply(Command(TakeInstrument{"perforator", "diameter=13"}, 0));
    ASSERT_FALSE(begun.refused) << begun.refused->message();
    EXPECT_EQ(tool_of(run.engine()), "burr");
    run.step({{0, 0, 12}, {1, 0, 0, 0}, false});
    run.apply(Command(run.engine().run_job(begun.job), 0));
    EXPECT_EQ(tool_of(run.engine()), "perforator");
    EXPECT_EQ(run.engine().state().settings.hands[0].parameters.as<drilling::Perforator>()->diameter, 13);
    EXPECT_DOUBLE_EQ(radius_of(run.engine()), radius);
    // The perforator touches with its ball, and its force law is set.
    haptics::ServoRecord record;
    for (double z = 12; z > 8; z -= 0.02) record = run.step({{0, 0, z}, {1, 0, 0, 0}, false});
    EXPECT_TRUE(record.has_contact);
    EXPECT_NEAR(record.proxy_world.z, 4 + radius, 0.2);
    EXPECT_NE(run.engine().servo_scene()->hands[0].laws, nullptr);
    for (int i = 0; i < 30; ++i) run.step({{0, 0, 14}, {1, 0, 0, 0}, false});
    // A burr touches with a point again, as at the start.
    ASSERT_FALSE(run.apply_and_finish({TakeInstrument{"burr", "diameter=4 removal_rate=30"}, 0}).refused);
    EXPECT_EQ(tool_of(run.engine()), "burr");
    EXPECT_EQ(radius_of(run.engine()), 0);
    ASSERT_FALSE(run.apply_and_finish({TakeInstrument{"burr", "diameter=5 removal_rate=30"}, 0}).refused);
    EXPECT_EQ(run.engine().state().settings.hands[0].parameters.as<drilling::Burr>()->diameter, 5);
    for (int i = 0; i < 30; ++i) run.step({{0, 0, 14}, {1, 0, 0, 0}, false});
    state = run.engine().state().hash();
    ASSERT_FALSE(writer->finish(run.engine()));
  }
  const Verdict verdict = replay(path, bench.scene.base);
  expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto run = Replay::open(opened.value(), bench.scene.base);
  ASSERT_TRUE(run.is_ok()) << run.error().message();
  ASSERT_FALSE(run.value()->seek(150));
  EXPECT_EQ(tool_of(run.value()->engine()), "perforator");
  ASSERT_FALSE(run.value()->seek(10));
  EXPECT_EQ(tool_of(run.value()->engine()), "burr");
}

TEST(TakeInstrument, IsRefusedWithItsReason) {
  const TrayBench bench;
  Engine engine = bench.engine();
  const auto refusal = [&](const char* instrument, const char* parameters) {
    const Outcome outcome = engine.apply(Command(TakeInstrument{instrument, parameters}, 0));
    return outcome.refused ? outcome.refused->message() : std::string();
  };
  EXPECT_NE(refusal("scalpel", "").find("unknown instrument"), std::string::npos);
  EXPECT_NE(refusal("", "").find("no instrument selected"), std::string::npos);
  EXPECT_NE(refusal("perforator", "diameter=100").find("diameter"), std::string::npos);
  EXPECT_NE(refusal("perforator", "colour=red").find("colour"), std::string::npos);
  EXPECT_NE(refusal("perforator", "diameter=10 inner=11").find("inner"), std::string::npos);
  EXPECT_TRUE(engine.jobs().empty());
  EXPECT_EQ(tool_of(engine), "burr");
  // If two requests are pending, the hand keeps the instrument whose job is adopted last.
  const Outcome first = engine.apply(Command(TakeInstrument{"perforator", ""}, 0)),
                second = engine.apply(Command(TakeInstrument{"burr", "diameter=4 removal_rate=30"}, 0));
  ASSERT_FALSE(first.refused || second.refused);
  engine.apply(Command(engine.run_job(first.job), 0));
  EXPECT_EQ(tool_of(engine), "perforator");
  engine.apply(Command(engine.run_job(second.job), 0));
  EXPECT_EQ(tool_of(engine), "burr");
  EXPECT_EQ(radius_of(engine), 0);
}

/// A live session prepares instruments in the background; the hand then takes them without new fields. The
/// end of the session cancels a preparation.
TEST(LiveSession, PreparesInstrumentsThatMayBeTakenNext) {
  TrayBench bench;
  bench.scene.offset_cache = haptics::make_offset_cache();
  haptics::VirtualDevice device(
      haptics::PosePath::from_samples(
          {{0, {{0, 0, 12}, {1, 0, 0, 0}, false}}, {60, {{0, 0, 12}, {1, 0, 0, 0}, false}}}, "test")
          .value(),
      {});
  haptics::Device* devices[] = {&device};
  LiveSession live(devices, bench.engine(), {});
  ASSERT_FALSE(live.start().has_value());
  const auto fields = [] { return work_counters().offset_fields.load(); };
  const auto reaches = [](const auto& condition) {
    for (int i = 0; i < 20000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return condition();
  };
  const long before = fields();
  // An unknown instrument and one without a ball need no preparation.
  live.prepare_instruments({{"unknown", ""}, {"burr", "diameter=3"}, {"perforator", "diameter=13"}});
  ASSERT_TRUE(reaches([&] { return fields() > before; }));
  live.apply(Command(TakeInstrument{"perforator", "diameter=13"}, 0));
  ASSERT_TRUE(reaches([&] { return live.fetch_state().tool.name() == "perforator"; }));
  EXPECT_EQ(fields(), before + 1);
  live.prepare_instruments({{"perforator", "diameter=12"}});
  live.stop();
}

}  // namespace
}  // namespace trephine::sim
