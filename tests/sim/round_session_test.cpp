// Sessions of a round tool: its offset fields are updated after cuts, outside the servo thread, and a replay
// adopts them at the recorded ticks.
#include <chrono>
#include <set>
#include <thread>

#include "haptics/methods/methods.h"
#include "sim/drivers/live_session.h"
#include "tests/sim/round_bench.h"

namespace trephine::sim {
namespace {

/// Returns the largest amount by which a field rebuilt from the version exceeds the field in use, mm. If it
/// is larger than the accuracy of the fields, a ball could enter the remaining matter.
double too_free(const haptics::TouchScene& scene, const Engine& edits) {
  const volume::OffsetField& used = edits.servo_scene()->hands[0].state.offset(scene, 0);
  const auto fresh = volume::OffsetField::build(scene.items[0].field, *scene.items[0].bits,
                                                edits.version().get(), scene.tool->radius(), 1)
                         .value();
  double worst = -1e9;
  for (int z = 0; z < used.size().z; ++z)
    for (int y = 0; y < used.size().y; ++y)
      for (int x = 0; x < used.size().x; ++x)
        // Only near the zero set of the rebuilt field.
        if (std::abs(fresh->at(x, y, z)) < 0.5 * fresh->far_mm())
          worst = std::max(worst, fresh->at(x, y, z) - used.at(x, y, z));
  return worst;
}

TEST(RoundSession, DrillsWithItsWholeBallAndItsFieldIsNeverTooFree) {
  const Folder folder;
  const std::string path = folder.file("round.session");
  std::uint64_t hash = 0;
  double removed = 0;
  {
    RoundBench bench;
    auto writer = bench.writer(path);
    Lockstep run(bench.scene, *bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    const haptics::PosePath request = drilling_path(10);
    int stale = 0, contacts = 0;
    for (int i = 0; i < 3000; ++i) {
      const haptics::ServoRecord r = run.step(request.at(1e-3 * i));
      EXPECT_FALSE(r.is_buried) << i;
      contacts += r.has_contact;
      stale += run.engine().has_stale_fields();
      if (i % 500 == 250) run.undo();
      if (i % 500 == 300) run.redo();
      if (i % 250 == 125) {
        EXPECT_LT(too_free(bench.scene, run.engine()), 0.1) << i;
      }
    }
    EXPECT_GT(contacts, 500);
    EXPECT_GT(stale, 100);  // it hovers over fresh cuts for a while
    EXPECT_GT(run.engine().removed_mm3(), 20);
    hash = run.engine().version()->content_hash();
    removed = run.engine().removed_mm3();
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  const Verdict v = replay(path);
  EXPECT_EQ(v.tool_radius, 1.0);
  expect_same(v);
  EXPECT_EQ(v.hash, hash);
  EXPECT_EQ(v.removed, removed);
  EXPECT_GT(v.counts.commands, 20u);  // undos, redos, and adopted fields
}

/// A replay compares the fields that it derives with those of the session.
TEST(RoundSession, AnotherFieldIsDetected) {
  const Folder folder;
  const std::string path = folder.file("round.session"), copy = folder.file("copy.session");
  RoundBench bench;
  std::vector<haptics::ServoRecord> records;  // complete, unlike those of a log
  {
    auto writer = bench.writer(path);
    Lockstep run(bench.scene, *bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    const haptics::PosePath request = drilling_path(10);
    for (int i = 0; i < 700; ++i) records.push_back(run.step(request.at(1e-3 * i)));
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  auto reader = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(reader);
  std::vector<LogItem> log;
  LogItem read;
  for (auto next = reader.value().next(read); next && next.value(); next = reader.value().next(read))
    log.push_back(read);
  for (const bool is_forged : {false, true}) {
    SCOPED_TRACE(is_forged);
    ItemEncoder encoder(types_of(reader.value().header(), drilling_catalogue()));
    std::set<std::int64_t> hashes;
    for (const LogItem& item : log) {
      if (const auto* tick = std::get_if<TickItem>(&item)) encoder.add(records[tick->record.tick]);
      if (const auto* event = std::get_if<EventItem>(&item)) encoder.add(*event);
      const auto* command = std::get_if<CommandItem>(&item);
      if (!command) continue;
      CommandItem copied = *command;
      if (auto* adopt = copied.command.request.as<Adopt>()) {
        EXPECT_NE(adopt->hash, 0);
        hashes.insert(adopt->hash);
        if (is_forged && hashes.size() == 3) ++adopt->hash;
      }
      encoder.add(copied);
    }
    EXPECT_GT(hashes.size(), 5u) << "each cut gives another field";
    SessionHeader header = reader.value().header();
    write_session(copy, header, encoder.fetch_bytes());
    const Verdict verdict = replay(copy, bench.scene.base);
    EXPECT_EQ(verdict.error, "");
    EXPECT_EQ(verdict.mismatch.has_value(), is_forged) << (verdict.mismatch ? verdict.mismatch->what : "");
  }
}

/// After an undo in contact, a tool is led to a position outside the solid of its own method, not only
/// outside solid voxels. The method therefore does not report it as buried afterwards.
TEST(RoundSession, EveryMethodIsLedOutOfItsOwnSolid) {
  for (const char* name :
       {"subvoxel", "implicit", "path", "explicit", "explicit-cubes", "scene", "scene-sequential"})
    for (const double radius : {0.0, 1.0}) {
      haptics::TouchScene scene = small_bone();
      ASSERT_FALSE(haptics::set_tool_radius(scene, radius, 1).has_value());
      const auto method = haptics::make_method(name).value();
      ASSERT_FALSE(method->prepare(scene).has_value());
      long buried = 0, led = 0;
      for (int round = 0; round < (radius > 0 ? 1 : 2); ++round) {
        drilling::Burr options = k_burr;
        options.is_round = radius > 0;
        Lockstep run(scene, *method, drilling::burr(options), {}, 1000);
        const haptics::PosePath request = drilling_path(20);
        for (int i = 0; i < 2500; ++i) {
          const haptics::ServoRecord r = run.step(request.at(1e-3 * i + 0.013 * round));
          buried += r.is_buried;
          led += r.is_escaping;
          if (i % 500 == (13 * round + 250) % 500) run.undo();
          if (i % 500 == 300) run.redo();
        }
      }
      EXPECT_GT(led, 5) << name << " " << radius;
      // With the method explicit, a cut may move a vertex of the surface net outward, over a proxy that rests
      // there. No other cause buries a proxy.
      EXPECT_LE(buried, std::string(name) == "explicit" ? 3 : 0) << name << " " << radius;
    }
}

/// A burr that is pressed straight down and then held still cuts until its centre is at the hand.
TEST(RoundSession, ReachesTheHandThroughItsCut) {
  RoundBench bench;
  Lockstep run(bench.scene, *bench.method, drilling::burr(bench.burr), {}, 1000);
  haptics::ServoRecord r;
  for (int i = 0; i < 4000; ++i) {
    const double z = std::max(1.0, 6 - 0.004 * i);
    r = run.step({{0, 0, z}, {1, 0, 0, 0}, i > 100});
  }
  EXPECT_FALSE(r.has_contact);
  EXPECT_EQ(r.proxy_world, r.pose.position_world);
  // After an undo in the hole, the tool is led out, and finally rests on the restored matter.
  EXPECT_TRUE(run.undo().is_changed);
  bool was_led = false;
  for (int i = 0; i < 500; ++i) {
    r = run.step({{0, 0, 1}, {1, 0, 0, 0}, false});
    was_led = was_led || r.is_escaping;
  }
  EXPECT_TRUE(was_led);
  EXPECT_FALSE(r.is_escaping);
  EXPECT_TRUE(r.has_contact);
  EXPECT_GT(r.proxy_world.z, 2 + 1.0 - 0.3);  // a radius above the plate's top
}

TEST(RoundSession, LiveUndoneInContactReplaysToTheBit) {
  const Folder folder;
  const std::string path = folder.file("live.session");
  RoundBench bench;
  auto writer = bench.writer(path, 500);
  haptics::VirtualDevice device(drilling_path(60), {});
  haptics::ServoOptions options;
  options.rate_hz = 500;
  LiveSession live(device, bench.scene, *bench.method, drilling::burr(bench.burr), options, writer.get());
  ASSERT_FALSE(live.start().has_value());
  int done = 0;
  for (int i = 0; i < 20000 && done < 6; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const LiveState s = live.fetch_state();
    if (s.newest.faults & haptics::k_latched_faults) live.reset_faults();
    if (s.can_undo && s.newest.pose.is_pressed() && s.newest.has_contact && s.newest.t > 0.3 * (done + 1)) {
      live.undo();
      if (++done % 3 == 0) live.redo();
    }
  }
  EXPECT_EQ(done, 6);
  live.stop();
  EXPECT_GT(live.derived_report(DerivedKind::offset_fields).count, 0u);
  EXPECT_GT(live.derived_report(DerivedKind::offset_fields).longest_seconds, 0);
  // Two fields, each within its tolerance.
  EXPECT_LT(too_free(bench.scene, live.engine()), 2 * (0.1 + 0.02 * bench.scene.tool->radius()));
  const std::uint64_t hash = live.engine().version()->content_hash();
  EXPECT_FALSE(writer->finish(live.engine()));
  const Verdict v = replay(path);
  EXPECT_EQ(v.tool_radius, 1.0);
  expect_same(v);
  EXPECT_EQ(v.hash, hash);
  EXPECT_GE(v.counts.commands, 8u);  // six undos, two redos, and adopted fields
}

/// A header keeps the radius of the tool, the material of a back side, and effects.
TEST(RoundSession, AHeaderKeepsRadiusBackAndEffects) {
  RoundBench bench;
  bench.scene.items[0].back_material = haptics::Material{.stiffness = 0.3, .viscosity = 0.01, .pop_force = 2};
  SessionHeader h = describe_scene(bench.scene, *bench.method, {}, {HandSpec(drilling::burr(bench.burr))});
  h.hands[0].effects = {"viscous damping=0.004", "plane point=0,0,1 normal=0,0,1 stiffness=0.2"};
  const auto read = decode_header(encode(h));
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  EXPECT_EQ(read.value().hands[0].tool->radius(), 1.0);
  EXPECT_EQ(read.value().hands[0].effects, h.hands[0].effects);
  ASSERT_TRUE(read.value().structures[0].back_material.has_value());
  EXPECT_EQ(read.value().structures[0].back_material->stiffness, 0.3);
  EXPECT_EQ(read.value().structures[0].back_material->viscosity, 0.01);
  EXPECT_EQ(read.value().structures[0].back_material->pop_force, 2);
  EXPECT_EQ(read.value().structures[0].material.stiffness, bench.scene.items[0].material.stiffness);
  EXPECT_EQ(encode(read.value()), encode(h));
  h.hands[0].effects = {"hum"};
  EXPECT_FALSE(decode_header(encode(h)).is_ok());
}

}  // namespace
}  // namespace trephine::sim
