// Engine: equal input gives an equal state through each driver.
#include <deque>
#include <map>
#include <random>
#include <thread>

#include "sim/api/core_command.h"
#include "sim/drivers/live_session.h"
#include "tests/sim/session_fixture.h"
#include "tests/sim/toy_bench.h"

namespace trephine::sim {
namespace {

/// Hashes of the state after ticks, by tick.
using Hashes = std::map<std::uint64_t, std::uint64_t>;

void expect_hashes(const std::string& path, const ToyBench& bench, const Hashes& hashes, unsigned seed) {
  auto session = SessionReader::open(path, toys());
  ASSERT_TRUE(session.is_ok()) << session.error().message();
  const auto opened = Replay::open(session.value(), bench.scene.base);
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  Replay& replay = *opened.value();
  std::size_t compared = 0;
  for (;;) {
    const auto stepped = replay.step();
    ASSERT_TRUE(stepped.is_ok()) << stepped.error().message();
    if (!stepped.value()) break;
    const auto expected = hashes.find(replay.record().tick);
    if (expected == hashes.end()) continue;
    ASSERT_EQ(replay.engine().snapshot()->hash(), expected->second) << "tick " << expected->first;
    ++compared;
  }
  EXPECT_EQ(compared, hashes.size());
  if (replay.mismatch()) ADD_FAILURE() << replay.mismatch()->what << ' ' << replay.mismatch()->replayed;
  // Compares the states after seeking forward and back.
  std::mt19937 random(seed);
  for (int i = 0; i < 6; ++i) {
    auto at = hashes.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(random() % hashes.size()));
    ASSERT_FALSE(replay.seek(at->first + 1));
    EXPECT_EQ(replay.engine().snapshot()->hash(), at->second) << "sought " << at->first;
  }
}

TEST(Engine, ARandomLogGivesOneStateThroughLockstepReplayAndSeek) {
  const Folder folder;
  std::uint64_t refused = 0, taken = 0, jobs = 0, undone = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const std::string path = folder.file((std::to_string(seed) + ".session").c_str());
    ToyBench bench;
    auto writer = bench.toy_writer(path);
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    std::mt19937 random(seed);
    const haptics::PosePath request = drilling_path(20);
    Hashes hashes;
    for (int i = 0; i < 2500; ++i) {
      run.step(request.at(1e-3 * i));
      if (i % 10 != 0) continue;
      hashes[static_cast<std::uint64_t>(i)] = run.engine().snapshot()->hash();
      for (int n = static_cast<int>(random() % 3); n > 0; --n) {
        const std::uint64_t before = run.engine().state().hash();
        const Command command = with_hash(random_command(random, run.engine().jobs()), run.engine());
        const Outcome outcome = run.apply(command);
        if (outcome.refused) {
          EXPECT_EQ(run.engine().state().hash(), before);
          EXPECT_FALSE(outcome.refused->what.empty());
        }
        (outcome.refused ? refused : taken) += 1;
        jobs += outcome.job_hash.has_value();
        undone += command.request.as<Undo>() && outcome.is_changed;
      }
    }
    EXPECT_FALSE(writer->finish(run.engine()));
    expect_hashes(path, bench, hashes, seed);
  }
  EXPECT_GT(refused, 80u);
  EXPECT_GT(taken, 400u);
  EXPECT_GT(jobs, 10u);
  EXPECT_GT(undone, 50u);
}

// Simulates the threads of a live operation in random order: ticks run ahead of the edits, and commands
// arrive in bursts.
TEST(Engine, AnyInterleavingOfServoEditsAndCommandsGivesOneState) {
  const Folder folder;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const std::string path = folder.file((std::to_string(seed) + ".session").c_str());
    ToyBench bench;
    auto writer = bench.toy_writer(path);
    Engine engine = bench.engine();
    haptics::ServoCore core({}, 1e-3);
    std::deque<haptics::ServoRecord> ring;
    auto published = engine.servo_scene();
    const haptics::PosePath request = drilling_path(20);
    std::mt19937 random(seed);
    Hashes hashes;
    for (int tick = 0; tick < 2500 || !ring.empty();) {
      const bool wants_tick = random() % 2 == 0;
      if (tick < 2500 && (ring.empty() || (wants_tick && ring.size() < 40))) {
        const haptics::DenormalsFlushed flushed;
        haptics::ServoInput input;
        input.pose = request.at(1e-3 * tick++);
        ring.push_back(core.step(*published, input));
        continue;
      }
      const haptics::ServoRecord record = ring.front();
      ring.pop_front();
      const Outcome outcome = engine.apply(record);
      writer->add(record, engine, outcome);
      if (outcome.is_changed) published = engine.servo_scene();
      if (random() % 12 != 0) continue;
      hashes[record.tick] = engine.snapshot()->hash();
      for (int n = static_cast<int>(random() % 4); n > 0; --n) {
        const Command command = with_hash(random_command(random, engine.jobs()), engine);
        const Outcome done = engine.apply(command);
        writer->add(command, engine, done);
        if (done.is_changed) published = engine.servo_scene();
      }
    }
    EXPECT_FALSE(writer->finish(engine));
    expect_hashes(path, bench, hashes, seed);
  }
}

/// Runs a live session over the plate, and calls during(session) while it runs. Returns the final state.
template <class During>
std::shared_ptr<const OperationState> run_live(ToyBench& bench, const std::string& path, During&& during) {
  auto writer = bench.toy_writer(path);
  haptics::VirtualDevice device(drilling_path(20), {});
  haptics::Device* devices[] = {&device};
  LiveSession live(devices, bench.engine(), {}, writer.get());
  EXPECT_FALSE(live.start().has_value());
  during(live);
  live.stop();
  EXPECT_FALSE(writer->finish(live.engine()));
  return std::make_shared<const OperationState>(live.engine().state());
}

template <class Done>
bool wait_until(Done&& done) {
  for (int i = 0; i < 2000; ++i) {
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

// An undo occurs while a job of 600 ms runs. The result of the job is rebased onto the new state, or
// discarded if the job is strict.
TEST(Engine, AJobWithAnUndoInItsMiddleIsTheSameLiveAndReplayed) {
  const Folder folder;
  for (const bool is_strict : {false, true}) {
    ToyBench bench;
    const std::string path = folder.file(is_strict ? "strict.session" : "rebased.session");
    const auto last = run_live(bench, path, [&](LiveSession& live) {
      EXPECT_TRUE(wait_until([&] { return live.fetch_state().removed_mm3 > 1; }));
      live.apply(ToyFlood{{0, 0, 0}, 600, is_strict});
      EXPECT_TRUE(wait_until([&] { return live.fetch_state().job == "toy-flood"; }));
      live.undo();
      EXPECT_TRUE(wait_until([&] {
        const auto now = live.snapshot().get();
        return Toy::toy_undoable(*now).flooded != 0 || now->chronicle.size() > 0;
      }));
      const LiveState ended = live.fetch_state();
      EXPECT_EQ(ended.job, "");
      ASSERT_EQ(ended.failed.has_value(), is_strict);
      if (is_strict) {
        EXPECT_EQ(ended.failed->what, "the command has had no effect");
        EXPECT_NE(ended.failed->found.find("the anatomy changed"), std::string::npos);
      }
      EXPECT_FALSE(live.fetch_state().failed) << "reported twice";
    });
    EXPECT_EQ(Toy::toy_undoable(*last).flooded != 0, !is_strict);
    std::size_t discarded = 0;
    for (std::size_t i = 0; i < last->chronicle.size(); ++i)
      discarded += last->chronicle[i].value.as<JobDiscarded>() != nullptr;
    EXPECT_EQ(discarded, is_strict ? 1u : 0u);
    const Verdict v = replay(path, bench.scene.base, toys());
    expect_same(v);
    EXPECT_EQ(v.state, last->hash());
  }
}

// A replay detects a result of a job, and an event, that it does not reproduce.
TEST(Engine, AnImpureJobAndADifferingEventAreDetected) {
  const Folder folder;
  ToyBench bench;
  const std::string path = folder.file("impure.session");
  {
    auto writer = bench.toy_writer(path);
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    for (int i = 0; i < 20; ++i) {
      run.step({{0, 0, 5}, {1, 0, 0, 0}, false});
      if (i == 5) run.apply(ToyFlood{});
      if (i == 10) run.apply(with_hash(AdoptJob{{1}}, run.engine()));
    }
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  expect_same(replay(path, bench.scene.base, toys()));
  Toy::salt = 1;
  const Verdict other_result = replay(path, bench.scene.base, toys());
  Toy::salt = 0;
  ASSERT_TRUE(other_result.mismatch);
  EXPECT_EQ(other_result.mismatch->what, "job");
  EXPECT_EQ(other_result.mismatch->tick, 11u);
  Toy::event_salt = 1;
  const Verdict other_event = replay(path, bench.scene.base, toys());
  Toy::event_salt = 0;
  ASSERT_TRUE(other_event.mismatch);
  EXPECT_EQ(other_event.mismatch->what, "event");
}

// The burr is changed in contact, with the button down.
TEST(Engine, ABurrChangedInContactIsTheSameLiveAndReplayed) {
  const Folder folder;
  ToyBench bench;
  const std::string path = folder.file("burr.session");
  int changes = 0;
  const auto last = run_live(bench, path, [&](LiveSession& live) {
    for (; changes < 8; ++changes) {
      EXPECT_TRUE(wait_until([&] {
        const LiveState now = live.fetch_state();
        return now.newest.has_contact && now.newest.pose.is_pressed();
      }));
      live.apply(drilling::Burr{changes % 2 == 0 ? 5.0 : 2.0, 60, 40});
      std::this_thread::sleep_for(std::chrono::milliseconds(40));
    }
    // A burr out of its range is refused, reported, and not recorded.
    live.apply(drilling::Burr{99});
    std::optional<Error> refused;
    EXPECT_TRUE(wait_until([&] { return (refused = live.fetch_state().refused).has_value(); }));
    if (refused) {
      EXPECT_NE(refused->message().find("burr diameter"), std::string::npos) << refused->message();
    }
  });
  EXPECT_EQ(last->settings.hands[0].parameters.as<drilling::Burr>()->diameter, 2);
  const Verdict v = replay(path, bench.scene.base, toys());
  expect_same(v);
  EXPECT_EQ(v.state, last->hash());
  EXPECT_EQ(v.counts.commands, static_cast<std::uint64_t>(changes));
}

// A session lists its modules. If one of them is missing, the session can be read, but not replayed.
TEST(Engine, WithoutItsModuleASessionIsReadAndNotReplayed) {
  const Folder folder;
  ToyBench bench;
  const std::string path = folder.file("toy.session");
  {
    auto writer = bench.toy_writer(path);
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    for (int i = 0; i < 30; ++i) {
      run.step({{0, 0, 5}, {1, 0, 0, 0}, false});
      if (i == 10) run.apply(ToyMark{{1, 2, 0}});
    }
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  auto session = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(session.is_ok());
  const auto refused = Replay::open(session.value(), bench.scene.base);
  ASSERT_FALSE(refused.is_ok());
  EXPECT_NE(refused.error().message().find("toy"), std::string::npos) << refused.error().message();
  int ticks = 0, unknown = 0;
  for (LogItem item; session.value().next(item).value();) {
    ticks += std::holds_alternative<TickItem>(item);
    if (const auto* one = std::get_if<UnknownItem>(&item)) {
      ++unknown;
      const NamedVersion& type = session.value().header().types[one->type];
      EXPECT_TRUE(type.name == "toy-mark" || type.name == "toy-marked") << type.name;
    }
  }
  EXPECT_EQ(ticks, 30);
  EXPECT_EQ(unknown, 2);
}

// A tool that becomes a ball inside its own narrower hole is led out. When it becomes a point again, it
// reaches the hand.
TEST(Engine, ATooLargeToolIsLedOutOfTheHoleOfASmallerOne) {
  ToyBench bench;
  Lockstep run(bench.engine(), {}, 1000);
  run.apply(drilling::Burr{1, 60, 40});
  for (int i = 0; i < 1500; ++i) run.step({{0, 0, std::max(0.0, 4 - 0.005 * i)}, {1, 0, 0, 0}, true});
  ASSERT_LT(run.last_record().proxy_world.z, 1.2);  // the plate's face is near 2
  for (const double radius : {1.0, 0.0}) {
    const Outcome begun = run.apply(ToolGeometry{radius});
    ASSERT_FALSE(begun.refused);
    // Until the new tool is adopted, the hand has the old tool.
    run.step({{0, 0, 0}, {1, 0, 0, 0}, false});
    EXPECT_FALSE(run.last_record().is_escaping);
    ASSERT_TRUE(run.apply(run.engine().run_job(begun.job)).is_changed);
    EXPECT_EQ(run.engine().scene().tool->radius(), radius);
    int led = 0;
    for (int i = 0; i < 600; ++i) {
      const haptics::ServoRecord r = run.step({{0, 0, 0}, {1, 0, 0, 0}, false});
      led += r.is_escaping;
      EXPECT_FALSE(r.is_buried);
      EXPECT_LE(glm::length(r.force_world), 3.3);
    }
    EXPECT_EQ(led > 0, radius > 0);
    if (radius > 0) {
      EXPECT_GT(run.last_record().proxy_world.z, 2.2);
    } else {
      EXPECT_LT(run.last_record().proxy_world.z, 1.2);
    }
  }
}

/// Refuses every request.
class Strict final : public Module {
 public:
  std::string_view name() const noexcept override { return "strict"; }
  Status allows(const Command&, const OperationState&) const override { return Error{.what = "not now"}; }
};

TEST(Engine, AGuardRefusesRequestsButNotDerivedData) {
  const ToyBench bench;
  const Strict strict;
  Engine engine(bench.scene, *bench.method, drilling::burr(k_burr), 1e-3, Catalogue({&strict}));
  for (const Command& request : {Command(Undo{}), Command(Note{"no"}), Command(drilling::Burr{2}),
                                 Command(SwitchItem{0, false}), Command(ToolGeometry{1})})
    EXPECT_EQ(engine.apply(request).refused.value_or(Error{}).what, "not now");
  EXPECT_FALSE(engine.apply(Resume{}).refused);
  EXPECT_FALSE(engine.apply(Adopt{DerivedKind::offset_fields, 0, 3}).refused);
}

TEST(Engine, CommandsOfEveryEngineAreRowsOfOneTable) {
  std::string all, of_drivers, unguarded, unheard, settings, in_every_step, named, without_transition;
  for (const CoreCommand& row : core_commands()) {
    const std::string name = std::string(row.type->schema->name) + ' ';
    EXPECT_EQ(find_core_command(*row.type), &row) << name;
    all += name;
    if (!row.is_for_users) of_drivers += name;
    if (!row.is_guarded) unguarded += name;
    if (!row.is_passed_to_modules) unheard += name;
    if (row.restore) settings += name;
    if (row.step_rule == StepRule::every_step) in_every_step += name;
    if (row.step_rule == StepRule::named) named += name;
    if (!row.causes_transitions) without_transition += name;
  }
  EXPECT_EQ(all,
            "undo redo begin-branch switch-branch note resume remove-instrument switch-item place-model "
            "set-effect tool-geometry take-instrument free-pieces hold-body release-body place-body "
            "discard-body adopt adopt-job cancel-job go-to-step ");
  EXPECT_EQ(of_drivers, "resume adopt adopt-job cancel-job ");
  EXPECT_EQ(unguarded, "resume adopt adopt-job ");
  EXPECT_EQ(unheard, "adopt adopt-job ");
  EXPECT_EQ(settings, "switch-item place-model set-effect adopt ");
  EXPECT_EQ(in_every_step,
            "undo redo begin-branch switch-branch note remove-instrument free-pieces release-body cancel-job "
            "go-to-step ");
  EXPECT_EQ(named, "switch-item place-model set-effect tool-geometry place-body discard-body ");
  EXPECT_EQ(without_transition, "undo redo begin-branch switch-branch resume go-to-step ");
  EXPECT_EQ(find_core_command(value_type<drilling::Burr>()), nullptr);
}

TEST(Engine, SettingsInAnotherOrderGiveTheSameState) {
  const ToyBench bench;
  std::uint64_t hashes[2];
  for (const bool is_turned : {false, true}) {
    Engine engine = bench.engine();
    std::vector<Command> commands{SetEffect{{2}, "viscous damping=0.001"},
                                  SetEffect{{10}, "spring anchor=0,0,4 stiffness=0.02"},
                                  SetEffect{{3}, "constant force=0,0,0.1"}, SwitchItem{0, false}};
    if (is_turned) std::reverse(commands.begin(), commands.end());
    for (const Command& one : commands) EXPECT_FALSE(engine.apply(one).refused);
    hashes[is_turned] = engine.state().hash();
    const auto& laws = engine.servo_scene()->hands[0].laws->laws();
    ASSERT_EQ(laws.size(), 3u);
    EXPECT_TRUE(laws[0].id == 2 && laws[1].id == 3 && laws[2].id == 10);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Engine, AToolThatDoesNotFitIsRefusedAndNotAdopted) {
  const ToyBench bench;
  Engine engine = bench.engine();
  for (const double radius : {1e-9, 0.009, 6.5})
    EXPECT_TRUE(engine.apply(ToolGeometry{radius}).refused) << radius;
  drilling::Burr round{2, 60, 40};
  round.is_round = true;
  EXPECT_TRUE(engine.apply(round).refused);  // the tool still touches as a point
  engine.apply(engine.run_job(engine.apply(ToolGeometry{0.4}).job));
  EXPECT_FALSE(engine.apply(round).refused);
  EXPECT_TRUE(engine.apply(ToolGeometry{1.5}).refused);  // larger than the cut of the burr
  const Outcome begun = engine.apply(ToolGeometry{0.9});
  ASSERT_FALSE(begun.refused);
  round.diameter = 1;  // the instrument changes before the geometry is adopted
  EXPECT_FALSE(engine.apply(round).refused);
  EXPECT_FALSE(engine.apply(engine.run_job(begun.job)).is_changed);
  EXPECT_EQ(engine.scene().tool->radius(), 0.4);
  EXPECT_EQ(engine.state().chronicle[0].value.as<JobDiscarded>()->job.value, begun.job.value);
}

// The hash of a geometry job's result is equal for an equal radius, and differs for another radius and after
// a cut.
TEST(Engine, AGeometryIsDistinguishedByItsHash) {
  const ToyBench bench;
  Engine engine = bench.engine();
  const auto hash_of = [&](double radius) {
    const Outcome begun = engine.apply(ToolGeometry{radius});
    return engine.run_job(begun.job).hash;
  };
  const std::int64_t one = hash_of(1), again = hash_of(1), larger = hash_of(1.25);
  engine.apply(ToyCarve{{0, 0, 1}});
  EXPECT_EQ(one, again);
  EXPECT_NE(one, larger);
  EXPECT_NE(one, hash_of(1));
}

TEST(Engine, ASessionOfOnlyModuleWorkIsKept) {
  const Folder folder;
  const ToyBench bench;
  for (const bool is_marked : {false, true}) {
    const std::string path = folder.file(is_marked ? "marked.session" : "idle.session");
    WriterOptions options;
    options.is_removed_when_empty = true;
    auto writer = SessionWriter::create(path, describe_scene(bench.scene, *bench.method, {}, burr_spec()),
                                        bench.scene.base, toys(), options)
                      .value();
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    run.step({{0, 0, 5}, {1, 0, 0, 0}, false});
    run.apply(is_marked ? Command(ToyMark{}) : Command(SetEffect{{0}, "viscous damping=0.001"}));
    EXPECT_FALSE(writer->finish(run.engine()));
    EXPECT_EQ(fs::exists(path), is_marked);
  }
}

TEST(Engine, ASnapshotIsReturnedBeforeDuringAndAfterALiveRun) {
  const ToyBench bench;
  haptics::VirtualDevice device(drilling_path(20), {});
  haptics::Device* devices[] = {&device};
  LiveSession live(devices, bench.engine(), {});
  EXPECT_TRUE(live.snapshot().get());
  ASSERT_FALSE(live.start());
  EXPECT_TRUE(live.snapshot().get());
  live.apply(ToyMark{});
  auto last = live.snapshot();
  live.stop();
  EXPECT_EQ(Toy::toy_undoable(*last.get()).marks, 1);
  EXPECT_EQ(Toy::toy_undoable(*live.snapshot().get()).marks, 1);
}

TEST(Engine, EventsMeasuresAndGuardsOfModules) {
  ToyBench bench;
  Engine engine = bench.engine();
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(engine.apply(ToyMark{{1.0 * i, 0, 0}}).refused);
  const Outcome eleventh = engine.apply(ToyMark{});
  ASSERT_TRUE(eleventh.refused);
  EXPECT_EQ(eleventh.refused->what, "too many marks");
  EXPECT_EQ(engine.state().chronicle.size(), 10u);
  EXPECT_EQ(engine.state().chronicle[3].position_world, dvec3(3, 0, 0));
  engine.apply(Undo{});
  EXPECT_EQ(Toy::toy_undoable(engine.state()).marks, 9);
  // Undo keeps events and settings.
  EXPECT_EQ(engine.state().chronicle.size(), 10u);
  EXPECT_EQ(engine.state().settings.modules[1]->as<ToySettings>()->heard, 10);
  const std::vector<Measure> all = engine.measures();
  EXPECT_TRUE(std::any_of(all.begin(), all.end(),
                          [](const Measure& m) { return m.name == "marks" && m.value == 9; }));
  EXPECT_TRUE(std::any_of(all.begin(), all.end(),
                          [](const Measure& m) { return m.name == "undos" && m.value == 1; }));
  // A snapshot is immutable.
  const auto before = engine.snapshot();
  const std::uint64_t hash = before->hash();
  engine.apply(ToyCarve{{0, 0, 0}});
  EXPECT_GT(engine.removed_mm3(), 1);
  EXPECT_EQ(before->hash(), hash);
  EXPECT_NE(engine.state().hash(), hash);
  engine.apply(ToyMend{});
  EXPECT_EQ(engine.removed_mm3(), 0);
  engine.apply(Undo{});
  EXPECT_GT(engine.removed_mm3(), 1);
}

}  // namespace
}  // namespace trephine::sim
