// Replay: gives the same bits, seeks to any tick, and detects changed facts.
#include "sim/drivers/replay.h"

#include <deque>
#include <random>
#include <utility>

#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

/// A session of 3000 ticks, opened for a replay.
struct RecordedRun {
  Folder folder;
  std::string path = folder.file("a.session");
  std::uint64_t hash = record_lockstep(path, 3000);  ///< of the last version
  Bench bench;
  SessionReader reader = SessionReader::open(path, drilling_catalogue()).value();
  std::unique_ptr<Replay> run = Replay::open(reader, bench.scene.base).value();
};

TEST(Replay, SeeksForwardAndBackToTheSameState) {
  const RecordedRun recorded;
  Replay& run = *recorded.run;
  ASSERT_FALSE(run.seek(1700).has_value());
  EXPECT_EQ(run.next_tick(), 1700u);
  const std::uint64_t middle = run.engine().version()->content_hash();
  const dvec3 force = run.record().force_world;
  ASSERT_FALSE(run.seek(5000).has_value());
  EXPECT_EQ(run.next_tick(), 3000u);
  EXPECT_EQ(run.engine().version()->content_hash(), recorded.hash);
  ASSERT_FALSE(run.seek(1700).has_value());
  EXPECT_EQ(run.engine().version()->content_hash(), middle);
  EXPECT_EQ(run.record().force_world, force);
  EXPECT_NE(middle, recorded.hash);
  EXPECT_FALSE(run.mismatch().has_value());
}

/// A seek in parts arrives at the same state, also at the end, and from the middle of another seek.
TEST(Replay, SeeksInPartsToTheSameState) {
  const RecordedRun recorded;
  const auto& run = recorded.run;
  ASSERT_FALSE(run->seek(1700).has_value());
  const std::uint64_t middle = run->engine().version()->content_hash();
  const auto go_to = [&](std::uint64_t tick) {
    int parts = 1;
    while (!run->seek_for(tick, 0).value()) ++parts;
    return parts;
  };
  EXPECT_GT(go_to(5000), 100) << "each part is at least a tick";
  EXPECT_EQ(run->engine().version()->content_hash(), recorded.hash);
  EXPECT_EQ(go_to(5000), 1) << "it is there";
  EXPECT_FALSE(run->seek_for(200, 0).value());
  go_to(1700);
  EXPECT_EQ(run->next_tick(), 1700u);
  EXPECT_EQ(run->engine().version()->content_hash(), middle);
  EXPECT_FALSE(run->mismatch().has_value());
}

enum class PlantedFault { none, force, stated_force, removed_volume, voxels };

/// Writes a session with one changed fact.
void write_session_with(PlantedFault planted, const std::string& path) {
  Bench bench;
  Engine edits(bench.scene, bench.method, drilling::burr(bench.burr), 1e-3);
  haptics::ServoCore core({}, 1e-3);
  SessionHeader header = bench.header();
  describe(drilling_catalogue(), header);
  ItemEncoder items(types_of(header, drilling_catalogue()));
  const haptics::PosePath request = drilling_path(10);
  std::string true_bytes, forged_bytes;
  for (int i = 0; i < 600; ++i) {
    haptics::ServoInput input;
    input.pose = request.at(1e-3 * i);
    haptics::ServoRecord record = core.step(*edits.servo_scene(), input);
    const Outcome outcome = edits.apply(record);
    if (planted == PlantedFault::force && i == 400) record.force_world.x += 1e-12;
    if (planted == PlantedFault::stated_force && i == 599) {
      // The last tick has another force, but the checksum of the true force.
      ItemEncoder other = items;
      haptics::ServoRecord changed = record;
      changed.force_world.x += 1;
      other.add(changed);
      items.add(record);
      true_bytes = ItemEncoder(items).fetch_bytes(), forged_bytes = other.fetch_bytes();
      forged_bytes.replace(forged_bytes.size() - 4, 4, true_bytes, true_bytes.size() - 4, 4);
    } else {
      items.add(record);
    }
    if (outcome.is_changed) {
      const bool is_wrong_volume =
          std::exchange(planted, planted == PlantedFault::removed_volume ? PlantedFault::none : planted) ==
          PlantedFault::removed_volume;
      items.add(
          VersionItem{edits.serial(), record.tick, edits.version()->ledger().total() + is_wrong_volume});
    }
  }
  const Command undo{Undo{}};
  edits.apply(undo);
  items.add(CommandItem{undo});
  items.add(HashItem{edits.serial(),
                     edits.version()->content_hash() ^ (planted == PlantedFault::voxels ? 1u : 0u)});
  const std::string log = forged_bytes + items.fetch_bytes().substr(true_bytes.size());
  write_session(path, header, log);
}

TEST(Replay, EveryPlantedFaultIsDetected) {
  const Folder folder;
  const std::string path = folder.file("faulty.session");
  const std::pair<PlantedFault, const char*> planted_faults[] = {
      {PlantedFault::none, ""},
      {PlantedFault::force, "force"},
      {PlantedFault::stated_force, "force"},
      {PlantedFault::removed_volume, "removed volume"},
      {PlantedFault::voxels, "voxels"}};
  for (const auto& [planted, what] : planted_faults) {
    write_session_with(planted, path);
    const Verdict v = replay(path);
    EXPECT_EQ(v.error, "");
    ASSERT_EQ(v.mismatch.has_value(), planted != PlantedFault::none) << what;
    if (v.mismatch) {
      EXPECT_EQ(v.mismatch->what, what);
      EXPECT_FALSE(v.mismatch->recorded.empty());
    }
    if (planted == PlantedFault::force) {
      EXPECT_EQ(v.mismatch->tick, 400u);
    }
  }
}

TEST(Replay, CommandsAfterTheLastTickAreReplayedToo) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  Bench bench;
  {
    auto writer = bench.writer(path);
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    const haptics::PosePath request = drilling_path(10);
    for (int i = 0; i < 550; ++i) run.step(request.at(1e-3 * i));
    ASSERT_GT(run.engine().removed_mm3(), 0);
    run.undo();
    ASSERT_EQ(run.engine().removed_mm3(), 0);
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  const auto run_of = Replay::open(opened.value(), bench.scene.base).value();
  Replay& run = *run_of;
  ASSERT_FALSE(run.seek(opened.value().tick_count()).has_value());
  EXPECT_EQ(run.engine().removed_mm3(), 0);
  EXPECT_EQ(run.engine().version()->content_hash(), opened.value().end()->hash);
}

// Recorded live by a g++ 12 release build under load, with 20 undos in contact: every compiler and preset
// must give the same bits.
TEST(Replay, ARecordingOfAnotherBuildReplaysToTheBit) {
  const std::string path = TREPHINE_SOURCE_DIR "/tests/sim/live-20-undos.session";
  const Verdict v = replay(path);
  expect_same(v);
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  ASSERT_TRUE(opened.value().end().has_value());
  EXPECT_EQ(v.hash, opened.value().end()->hash);
  EXPECT_EQ(v.removed, opened.value().end()->removed_mm3);
  EXPECT_GE(v.counts.commands, 20u);
  EXPECT_GT(v.removed, 0);
}

// Simulates the two threads of a live session in random order: ticks run ahead of the edits, and undos and
// redos arrive in bursts, also while a tool is led out. Each recording replays to the bit.
TEST(Replay, AnyInterleavingOfServoAndEditsReplaysToTheBit) {
  const Folder folder;
  std::mt19937 random(4);
  int led_ticks = 0, commands = 0;
  for (int round = 0; round < 12; ++round) {
    const std::string path = folder.file("model.session");
    fs::remove(path);
    Bench bench;
    auto writer = bench.writer(path);
    Engine edits(bench.scene, bench.method, drilling::burr(bench.burr), 1e-3);
    haptics::ServoCore core({}, 1e-3);
    std::deque<haptics::ServoRecord> ring;
    std::deque<Command> waiting;
    // A burr with spin drag has its own force, which is off while the tool is led out.
    if (round % 2 == 1) waiting.push_back(drilling::Burr{.diameter = 3});
    auto published = edits.servo_scene();
    const haptics::PosePath request = drilling_path(20);
    for (int tick = 0; tick < 3000;) {
      if (random() % 3 != 0 && ring.size() < 40) {
        haptics::ServoInput input;
        input.pose = request.at(1e-3 * tick++);
        ring.push_back(core.step(*published, input));
        led_ticks += ring.back().is_escaping;
      }
      if (random() % 3 != 0 && !ring.empty()) {
        const haptics::ServoRecord record = ring.front();
        ring.pop_front();
        const Outcome outcome = edits.apply(record);
        if (outcome.is_changed) published = edits.servo_scene();
        writer->add(record, edits, outcome);
      }
      if (random() % 300 == 0)
        for (unsigned i = 0, n = 1 + random() % 4; i < n; ++i)
          waiting.push_back(random() % 3 == 0 ? Command(Redo{}) : Command(Undo{}));
      // Several commands are applied at once: the servo may never read the states between them.
      while (!waiting.empty()) {
        const Outcome outcome = edits.apply(waiting.front());
        if (outcome.is_changed) published = edits.servo_scene();
        writer->add(waiting.front(), edits, outcome);
        waiting.pop_front();
        ++commands;
      }
    }
    EXPECT_FALSE(writer->finish(edits).has_value());
    const Verdict v = replay(path);
    expect_same(v);
    EXPECT_EQ(v.hash, edits.version()->content_hash());
  }
  EXPECT_GT(led_ticks, 100);
  EXPECT_GT(commands, 100);
}

}  // namespace
}  // namespace trephine::sim
