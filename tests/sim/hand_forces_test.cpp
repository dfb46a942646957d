// Forces of an instrument that depend on its state, and items through which the instrument passes.
#include <chrono>
#include <glm/gtc/quaternion.hpp>
#include <thread>

#include "haptics/methods/methods.h"
#include "sim/drivers/live_session.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

/// A toy probe. When the hand presses it onto bone, without a button, the probe makes a track, in which it
/// passes through bone.
struct ToyProbe {
  double resistance = 2;  ///< N
  static const Schema& schema() {
    static constexpr Field fields[] = {
        field<&ToyProbe::resistance>("resistance", {.unit = "N", .low = 0.1, .high = 10})};
    static constexpr Schema table{"toy-probe", 1, fields};
    return table;
  }
};
struct ToyProbeState {
  bool has_entered = false;
  dvec3 start{0.0}, ahead{0, 0, -1};
  std::int64_t tracks = 0;
  static const Schema& schema() {
    static constexpr Field fields[] = {
        field<&ToyProbeState::has_entered>("entered"), field<&ToyProbeState::start>("start"),
        field<&ToyProbeState::ahead>("ahead"), field<&ToyProbeState::tracks>("tracks")};
    static constexpr Schema table{"toy-probe-state", 1, fields};
    return table;
  }
};

void step(const ToyProbe&, ToyProbeState& state, const InstrumentInput& input, Work& work) {
  const haptics::ServoRecord& tick = input.tick;
  if (input.is_fresh) state.has_entered = false;
  if (!state.has_entered && tick.has_contact && glm::length(tick.contact_force_world) > 0.6) {
    state.has_entered = true, ++state.tracks;
    state.start = tick.proxy_world;
    state.ahead = haptics::unit_of(tick.pose.orientation) * dvec3(0, 0, -1);
  }
  if (!state.has_entered) return;
  const double tip = glm::dot(tick.proxy_world - state.start, state.ahead);
  if (tip < -0.2) state.has_entered = false;
  if (tip > 0.5)
    work.remove({tick.proxy_world - 0.5 * state.ahead, tick.proxy_world - 0.5 * state.ahead, 0.8, false});
}
HandForces forces(const ToyProbe& probe, const ToyProbeState& state) {
  if (!state.has_entered) return {};
  haptics::Insertion track;
  track.start_world = state.start, track.direction_world = state.ahead;
  track.layers[0] = {0, -1, probe.resistance, probe.resistance};
  track.layer_count = 1;
  HandForces result;
  result.effects[0] = haptics::Effect{track, 8};
  result.passable_items.set(0, true);
  return result;
}
bool is_working(const ToyProbe&, const ToyProbeState& state) { return state.has_entered; }

class ProbeModule final : public Module {
 public:
  std::string_view name() const noexcept override { return "toy-probes"; }
  std::span<const InstrumentType* const> instruments() const override {
    static const std::array all{&instrument_type<step, nullptr, nullptr, nullptr, forces, is_working>()};
    return all;
  }
};

const Catalogue& probes() {
  static const ProbeModule module;
  static const Catalogue all({&module});
  return all;
}
Instrument probe(double resistance = 2) {
  return {*probes().find_instrument("toy-probe"), ToyProbe{resistance}};
}

struct ProbeBench {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method = haptics::make_method("subvoxel").value();
  ProbeBench() {
    data_tools::PhantomOptions o;
    o.size = glm::ivec3(48);
    o.spacing_mm = dvec3(0.5);
    o.psf_sigma_voxels = 1;
    o.parameters = {{"thickness", 8}, {"angle", 0}};
    scene = scenes::phantom_scene("plate", o);
    EXPECT_FALSE(method->prepare(scene));
  }
  std::unique_ptr<SessionWriter> writer(const std::string& path) const {
    return SessionWriter::create(path, describe_scene(scene, *method, {}, {HandSpec(probe())}), scene.base,
                                 probes())
        .value();
  }
};

const ToyProbeState& state_of(const Engine& engine) {
  return *engine.state().settings.hands[0].state.as<ToyProbeState>();
}

/// Moves the hand from one height to another at 20 mm/s. Returns the last record.
haptics::ServoRecord move(Lockstep& run, double from, double to, bool expects_force = false) {
  haptics::ServoRecord record;
  const double step = from > to ? -0.02 : 0.02;
  for (double z = from; (step < 0) == (z > to); z += step) {
    record = run.step({{0.3, 0.2, z}, {1, 0, 0, 0}, false});
    if (expects_force) {
      EXPECT_NEAR(record.force_world.z, 2, 0.06) << z;
    }
  }
  return record;
}

TEST(HandForces, DependOnTheStateOfTheInstrument) {
  const Folder folder;
  const std::string path = folder.file("probe.session");
  const ProbeBench bench;
  std::uint64_t state = 0, inside_tick = 0;
  std::uint64_t inside = 0;
  {
    auto writer = bench.writer(path);
    Lockstep run(Engine(bench.scene, *bench.method, probe(), 1e-3, probes()), {}, 1000, writer.get());
    move(run, 8, 4);
    EXPECT_FALSE(state_of(run.engine()).has_entered);
    move(run, 4, 0);
    EXPECT_TRUE(state_of(run.engine()).has_entered);
    EXPECT_TRUE(run.engine().servo_scene()->hands[0].passable_items.contains(0));
    const haptics::ServoRecord in = move(run, 0, -1, true);
    EXPECT_FALSE(in.has_contact) << "bone lets the probe through";
    EXPECT_NEAR(in.proxy_world.z, in.pose.position_world.z + 2, 0.05) << "the tip is at the end of its track";
    EXPECT_GT(run.engine().removed_mm3(), 1);
    EXPECT_TRUE(run.engine().is_in_stroke());
    EXPECT_EQ(run.engine().stroke_count(), 0u) << "one stroke, without a button";
    inside_tick = run.engine().state().next_tick, inside = run.engine().state().hash();
    // Through the far side.
    int lost = 0;
    for (double z = -1; z > -8; z -= 0.02) {
      const haptics::ServoRecord r = run.step({{0.3, 0.2, z}, {1, 0, 0, 0}, false});
      for (std::size_t e = 0; e < r.event_count; ++e)
        if (r.events[e].kind == haptics::TouchEvent::lost_resistance) {
          ++lost;
          EXPECT_NEAR(r.proxy_world.z, -4, 0.8);
        }
    }
    EXPECT_EQ(lost, 1);
    // The probe is drawn out: bone blocks it again, and all cuts of the track are one stroke.
    const haptics::ServoRecord out = move(run, -8, 8);
    EXPECT_FALSE(state_of(run.engine()).has_entered);
    EXPECT_FALSE(run.engine().servo_scene()->hands[0].passable_items.contains(0));
    EXPECT_LT(glm::length(out.force_world), 1e-6);
    EXPECT_EQ(run.engine().stroke_count(), 1u);
    const double removed = run.engine().removed_mm3();
    run.undo();
    EXPECT_EQ(run.engine().removed_mm3(), 0);
    EXPECT_GT(removed, 5);
    const haptics::ServoRecord again = move(run, 8, 3.4);
    EXPECT_TRUE(again.has_contact) << "the restored bone blocks";
    move(run, 3.4, 1);
    EXPECT_TRUE(state_of(run.engine()).has_entered);
    run.undo();  // within the track
    move(run, 1, 8);
    state = run.engine().state().hash();
    ASSERT_FALSE(writer->finish(run.engine()));
  }
  const Verdict verdict = replay(path, bench.scene.base, probes());
  expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
  // The session is opened in the middle of the track: the state is equal, and the replay ends without
  // mismatch.
  auto opened = SessionReader::open(path, probes());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto run = Replay::open(opened.value(), bench.scene.base);
  ASSERT_TRUE(run.is_ok()) << run.error().message();
  ASSERT_FALSE(run.value()->seek(inside_tick));
  EXPECT_EQ(run.value()->engine().state().hash(), inside);
  EXPECT_TRUE(run.value()->engine().servo_scene()->hands[0].passable_items.contains(0));
  while (true) {
    const auto stepped = run.value()->step();
    ASSERT_TRUE(stepped.is_ok()) << stepped.error().message();
    if (!stepped.value()) break;
  }
  EXPECT_FALSE(run.value()->mismatch().has_value());
  EXPECT_EQ(run.value()->engine().state().hash(), state);
}

// Two hands in a live session make a track each. The replay gives the same bits.
TEST(HandForces, TwoLiveHandsReplayToTheBit) {
  const Folder folder;
  const std::string path = folder.file("probes.session");
  const ProbeBench bench;
  SceneDescription header = describe_scene(bench.scene, *bench.method, {}, {HandSpec(probe())});
  header.hands.push_back(header.hands[0]);
  auto writer = SessionWriter::create(path, header, bench.scene.base, probes()).value();
  const auto device_at = [](double x, double deepest) {
    return haptics::PlaybackDevice(
        haptics::PosePath::from_samples({{0, {{x, 0, 8}, {1, 0, 0, 0}, false}},
                                         {0.2, {{x, 0, 5}, {1, 0, 0, 0}, false}},
                                         {0.8, {{x, 0, deepest}, {1, 0, 0, 0}, false}},
                                         {1.4, {{x, 0, deepest}, {1, 0, 0, 0}, false}}},
                                        "test")
            .value());
  };
  haptics::PlaybackDevice left = device_at(-4, -1), right = device_at(4, 1);
  haptics::Device* devices[] = {&left, &right};
  const HandStart hand{haptics::ServoHand(haptics::borrowed(bench.scene), haptics::borrowed(*bench.method),
                                          haptics::TouchState(nullptr)),
                       probe()};
  LiveSession live(devices, Engine({hand, hand}, 1e-3, probes()), {}, writer.get());
  ASSERT_FALSE(live.start().has_value());
  for (int i = 0; i < 10000 && live.fetch_state().newest.t < 1.4; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  live.stop();
  ASSERT_FALSE(writer->finish(live.engine()));
  for (std::size_t h = 0; h < 2; ++h) {
    const auto& state = *live.engine().state().settings.hands[h].state.as<ToyProbeState>();
    EXPECT_TRUE(state.has_entered) << h;
    EXPECT_NEAR(state.start.x, h == 0 ? -4 : 4, 0.3);
    EXPECT_TRUE(live.engine().servo_scene()->hands[h].passable_items.contains(0)) << h;
  }
  EXPECT_GT(live.engine().removed_mm3(), 1);
  const Verdict verdict = replay(path, bench.scene.base, probes());
  expect_same(verdict);
  EXPECT_EQ(verdict.state, live.engine().state().hash());
}

}  // namespace
}  // namespace trephine::sim
