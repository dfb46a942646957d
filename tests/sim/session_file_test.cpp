// Session files: torn, damaged, foreign, older, on a full disk; what they carry and every lie in them.
#include <csignal>
#include <cstring>
#include <fstream>
#include <random>
#include <sys/resource.h>

#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

TEST(Session, SeeksForwardAndBackToTheSameState) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  const std::uint64_t hash = record_lockstep(path, 3000);
  Bench bench;
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  const auto run_of = Replay::open(opened.value(), bench.scene.base).value();
  Replay& run = *run_of;
  ASSERT_FALSE(run.seek(1700).has_value());
  EXPECT_EQ(run.next_tick(), 1700u);
  const std::uint64_t middle = run.engine().current()->content_hash();
  const dvec3 force = run.record().force_world;
  ASSERT_FALSE(run.seek(5000).has_value());
  EXPECT_EQ(run.next_tick(), 3000u);
  EXPECT_EQ(run.engine().current()->content_hash(), hash);
  ASSERT_FALSE(run.seek(1700).has_value());
  EXPECT_EQ(run.engine().current()->content_hash(), middle);
  EXPECT_EQ(run.record().force_world, force);
  EXPECT_NE(middle, hash);
  EXPECT_FALSE(run.mismatch().has_value());
}

enum class Lie { none, force, removed_volume, voxels };

/// A session written block by block, with one lie in it.
void write_session_with(Lie lie, const std::string& path) {
  Bench bench;
  Engine edits(bench.scene, bench.method, drilling::burr(bench.burr), 1e-3);
  haptics::ServoCore core({}, 1e-3);
  ItemEncoder items(drilling_catalogue().all());
  const haptics::PosePath wish = drilling_wish(10);
  for (int i = 0; i < 600; ++i) {
    haptics::ServoInput input;
    input.pose = wish.at(1e-3 * i);
    haptics::ServoRecord record = core.step(*edits.servo_scene(), input);
    const Outcome outcome = edits.apply(record);
    if (lie == Lie::force && i == 400) record.force_world.x += 1e-12;
    items.add(record);
    if (outcome.is_changed) {
      const bool is_lie =
          std::exchange(lie, lie == Lie::removed_volume ? Lie::none : lie) == Lie::removed_volume;
      items.add(VersionItem{edits.serial(), record.tick, edits.current()->ledger().total() + is_lie});
    }
  }
  const Command undo{Undo{}};
  edits.apply(undo);
  items.add(CommandItem{undo});
  items.add(HashItem{edits.serial(), edits.current()->content_hash() ^ (lie == Lie::voxels ? 1u : 0u)});
  std::string bytes(k_session_magic);
  const std::uint32_t layout[2] = {k_session_layout, 0};
  bytes.append(reinterpret_cast<const char*>(layout), sizeof layout);
  std::uint64_t number = 0;
  SessionHeader header = bench.header();
  describe(drilling_catalogue(), header);
  for (const auto& [kind, payload] :
       {std::pair(BlockKind::header, encode(header)), std::pair(BlockKind::log, items.take())}) {
    const BlockHead head{k_block_magic, static_cast<std::uint32_t>(kind), number++, 0, payload.size()};
    const std::uint64_t check = block_checksum(head, payload);
    bytes.append(reinterpret_cast<const char*>(&head), sizeof head);
    bytes += payload;
    bytes.append(reinterpret_cast<const char*>(&check), sizeof check);
  }
  std::ofstream(path, std::ios::binary) << bytes;
}

TEST(Session, EveryLieOfARecordingIsFound) {
  const Folder folder;
  const std::string path = folder.file("lie.session");
  const std::pair<Lie, const char*> lies[] = {{Lie::none, ""},
                                              {Lie::force, "force"},
                                              {Lie::removed_volume, "removed volume"},
                                              {Lie::voxels, "voxels"}};
  for (const auto& [lie, what] : lies) {
    write_session_with(lie, path);
    const Verdict v = replay(path);
    EXPECT_EQ(v.error, "");
    ASSERT_EQ(v.mismatch.has_value(), lie != Lie::none) << what;
    if (v.mismatch) {
      EXPECT_EQ(v.mismatch->what, what);
      EXPECT_FALSE(v.mismatch->recorded.empty());
    }
    if (lie == Lie::force) {
      EXPECT_EQ(v.mismatch->tick, 400u);
    }
  }
}

TEST(Session, CommandsAfterTheLastTickAreReplayedToo) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  Bench bench;
  {
    auto writer = bench.writer(path);
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    const haptics::PosePath wish = drilling_wish(10);
    for (int i = 0; i < 550; ++i) run.step(wish.at(1e-3 * i));
    ASSERT_GT(run.engine().removed_mm3(), 0);
    run.undo();
    ASSERT_EQ(run.engine().removed_mm3(), 0);
    EXPECT_FALSE(writer->finish(run.engine(), 0).has_value());
  }
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  const auto run_of = Replay::open(opened.value(), bench.scene.base).value();
  Replay& run = *run_of;
  ASSERT_FALSE(run.seek(opened.value().tick_count()).has_value());
  EXPECT_EQ(run.engine().removed_mm3(), 0);
  EXPECT_EQ(run.engine().current()->content_hash(), opened.value().end()->hash);
}

TEST(Session, OneWriterAtATimeAndAnEmptyAutosaveGoesAway) {
  const Folder folder;
  Bench bench;
  WriterOptions options;
  options.is_removed_when_empty = true;
  const std::string path = folder.file("a.session");
  {
    auto writer = bench.writer(path, 1000, options);
    EXPECT_TRUE(SessionWriter::is_being_written(path));
    auto second =
        SessionWriter::append(path, fs::file_size(path), 1, drilling_catalogue().all(), drilling_catalogue());
    ASSERT_FALSE(second.is_ok());
    EXPECT_NE(second.error().what.find("right now"), std::string::npos);
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    for (int i = 0; i < 20; ++i) run.step({{0, 0, 8}, {1, 0, 0, 0}, false});
    EXPECT_FALSE(writer->finish(run.engine(), 0).has_value());
  }
  EXPECT_FALSE(fs::exists(path));
  {
    auto writer = bench.writer(path, 1000, options);
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    const haptics::PosePath wish = drilling_wish(2);
    for (int i = 0; i < 550; ++i) run.step(wish.at(1e-3 * i));
    run.undo();  // work all the same: it can be done again
    EXPECT_FALSE(writer->finish(run.engine(), 0).has_value());
  }
  EXPECT_TRUE(fs::exists(path));
  EXPECT_FALSE(SessionWriter::is_being_written(path));
}

TEST(Session, DamageInALargeScanIsNoTornEnd) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(224);  // 22 MB: farther than one look
  const haptics::TouchScene scene = scenes::phantom_scene("plate", o);
  haptics::ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  WriterOptions options;
  options.is_embedding = true;
  {
    auto writer = SessionWriter::create(path, describe_scene(scene, method, {}, burr_spec()), scene.base,
                                        drilling_catalogue(), options)
                      .value();
    const drilling::Burr burr = k_burr;
    Lockstep run(scene, method, drilling::burr(burr), {}, 1000, writer.get());
    for (int i = 0; i < 20; ++i) run.step({{0, 0, 50}, {1, 0, 0, 0}, false});
    EXPECT_FALSE(writer->finish(run.engine(), 0).has_value());
  }
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(100'000);
  file.put('\x55');
  file.close();
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  EXPECT_TRUE(opened.value().is_damaged());
}

TEST(Session, TornAtAnyByteTheWholeBlocksStay) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  record_lockstep(path, 1200);
  const auto size = fs::file_size(path);
  std::ifstream in(path, std::ios::binary);
  std::string bytes(size, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  std::mt19937 random(5);
  std::uint64_t last_ticks = 0;
  // To the whole file: how long its last block is depends on the hour.
  std::vector<std::size_t> cuts;
  for (std::size_t cut = 0; cut < size; cut += 1 + random() % 97) cuts.push_back(cut);
  cuts.push_back(size);
  for (const std::size_t cut : cuts) {
    const std::string torn = folder.file("torn.session");
    std::ofstream(torn, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(cut));
    auto opened = SessionReader::open(torn);
    if (!opened) {
      EXPECT_LT(cut, 4000u);  // only without a whole header
      EXPECT_FALSE(opened.error().what.empty());
      continue;
    }
    EXPECT_EQ(opened.value().whole_bytes() + opened.value().lost_bytes(), cut);
    EXPECT_FALSE(opened.value().is_damaged());
    EXPECT_GE(opened.value().tick_count(), last_ticks);
    last_ticks = opened.value().tick_count();
    LogItem item;
    for (;;) {
      const auto next = opened.value().next(item);
      ASSERT_TRUE(next.is_ok());
      if (!next.value()) break;
    }
  }
  EXPECT_EQ(last_ticks, 1200u);
  // A flipped bit is never taken for a recording.
  for (int i = 0; i < 300; ++i) {
    std::string damaged = bytes;
    const std::size_t at = random() % size;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << random() % 8));
    const std::string file = folder.file("damaged.session");
    std::ofstream(file, std::ios::binary).write(damaged.data(), static_cast<std::streamsize>(size));
    auto opened = SessionReader::open(file);
    if (opened && at >= 16) {
      EXPECT_GT(opened.value().lost_bytes(), 0u) << at;
    }
  }
}

TEST(Session, ForeignNewerAndOlderFilesAreSaidSo) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  const auto write = [&](const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; };
  EXPECT_FALSE(SessionReader::open(folder.file("none.session")).is_ok());
  EXPECT_FALSE(SessionReader::open(folder.path.string()).is_ok());
  write("");
  EXPECT_FALSE(SessionReader::open(path, drilling_catalogue()).is_ok());
  write(std::string(500, 'x'));
  auto foreign = SessionReader::open(path, drilling_catalogue());
  ASSERT_FALSE(foreign.is_ok());
  EXPECT_NE(foreign.error().what.find("no session"), std::string::npos);
  write(std::string("TREPHSES\x09\0\0\0\0\0\0\0", 16) + std::string(100, 'x'));
  auto newer = SessionReader::open(path, drilling_catalogue());
  ASSERT_FALSE(newer.is_ok());
  EXPECT_NE(newer.error().what.find("newer"), std::string::npos);

  // Older arithmetic: to be viewed, not verified.
  Bench bench;
  SessionHeader header = bench.header();
  header.revision = 0;
  header.program = "trephine 0.0.9";
  const std::string old = folder.file("old.session");
  {
    auto writer = SessionWriter::create(old, header, bench.scene.base, drilling_catalogue()).value();
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    for (int i = 0; i < 50; ++i) run.step({{0, 0, 5}, {1, 0, 0, 0}, false});
    EXPECT_FALSE(writer->finish(run.engine(), 0).has_value());
  }
  auto opened = SessionReader::open(old, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  const auto run_of = Replay::open(opened.value(), bench.scene.base).value();
  Replay& run = *run_of;
  const volume::Status why = run.why_not_verifiable();
  ASSERT_TRUE(why.has_value());
  EXPECT_NE(why->found.find("0.0.9"), std::string::npos);
  int ticks = 0;
  while (run.step().value()) ++ticks;
  EXPECT_EQ(ticks, 50);

  // Another scan is refused before anything is played.
  auto other = std::make_shared<volume::Volume>(
      volume::make_volume(bench.scene.base->size, bench.scene.base->frame).value());
  std::fill(other->voxels.span().begin(), other->voxels.span().end(), std::int16_t{0});
  auto wrong = Replay::open(opened.value(), std::shared_ptr<const volume::Volume>(other));
  ASSERT_FALSE(wrong.is_ok());
  EXPECT_NE(wrong.error().what.find("not the one"), std::string::npos);
}

TEST(Session, HeadersSurviveTheirText) {
  Bench bench;
  SessionHeader h = bench.header(2000);
  h.case_name = "a name\nwith a break";
  h.structures[0].shape.high = 1234.5;
  h.hands.emplace_back();
  describe(drilling_catalogue(), h);
  const auto back = decode_header(encode(h));
  ASSERT_TRUE(back.is_ok());
  EXPECT_EQ(back.value().case_name, "a name with a break");
  EXPECT_EQ(back.value().structures[0].shape.low, h.structures[0].shape.low);
  EXPECT_EQ(back.value().structures[0].shape.high, 1234.5);
  EXPECT_EQ(back.value().hands.size(), 2u);
  EXPECT_EQ(back.value().hands[0].instrument, "burr");
  EXPECT_EQ(back.value().hands[0].parameters, h.hands[0].parameters);
  ASSERT_EQ(back.value().types.size(), h.types.size());
  for (std::size_t i = 0; i < h.types.size(); ++i) {
    EXPECT_EQ(back.value().types[i].name, h.types[i].name);
    EXPECT_EQ(back.value().types[i].version, h.types[i].version);
    EXPECT_EQ(back.value().types[i].fields, h.types[i].fields);
  }
  ASSERT_EQ(back.value().modules.size(), 1u);
  EXPECT_EQ(back.value().modules[0].name, "drilling");
  EXPECT_EQ(back.value().rate_hz, 2000);
  EXPECT_FALSE(decode_header("surprise=1\n" + encode(h)).is_ok());
  EXPECT_FALSE(decode_header("rate=nan\n" + encode(h)).is_ok());
  EXPECT_FALSE(decode_header("").is_ok());
}

TEST(Session, CarriesItsScanWhenAsked) {
  const Folder folder;
  Bench bench;
  WriterOptions options;
  options.is_embedding = true;
  const std::string path = folder.file("embedded.session");
  {
    auto writer = bench.writer(path, 1000, options);
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    for (int i = 0; i < 20; ++i) run.step({{0, 0, 5}, {1, 0, 0, 0}, false});
    EXPECT_FALSE(writer->finish(run.engine(), 0).has_value());
  }
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  ASSERT_TRUE(opened.value().has_scan());
  auto scan = opened.value().scan();
  ASSERT_TRUE(scan.is_ok());
  EXPECT_EQ(volume::content_hash(scan.value()), volume::content_hash(*bench.scene.base));
  ASSERT_TRUE(opened.value().scan_hash().has_value());
  EXPECT_EQ(*opened.value().scan_hash(), volume::content_hash(*bench.scene.base));
}

TEST(Session, AFullDiskEndsTheRecordingAndKeepsWhatWasWritten) {
  const Folder folder;
  const std::string path = folder.file("full.session");
  Bench bench;
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{20000, before.rlim_max};
  auto writer = bench.writer(path);
  setrlimit(RLIMIT_FSIZE, &small);
  Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
  const haptics::PosePath wish = drilling_wish(10);
  for (int i = 0; i < 3000; ++i) {
    run.step(wish.at(1e-3 * i));
    if (i % 50 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }
  EXPECT_TRUE(writer->status().has_value());  // said while it goes on
  const volume::Status status = writer->finish(run.engine(), 0);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  ASSERT_TRUE(status.has_value());
  EXPECT_NE(status->what.find("ended early"), std::string::npos);
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  EXPECT_EQ(opened.value().lost_bytes(), 0u);
  EXPECT_GT(opened.value().tick_count(), 50u);
  expect_same(replay(path));

  // Nowhere to write at all, and never over something that is there.
  EXPECT_FALSE(SessionWriter::create(folder.file("no/such/folder"), bench.header(), bench.scene.base,
                                     drilling_catalogue())
                   .is_ok());
  auto taken = SessionWriter::create(path, bench.header(), bench.scene.base, drilling_catalogue());
  ASSERT_FALSE(taken.is_ok());
  EXPECT_NE(taken.error().what.find("already"), std::string::npos);
}

/// In every frame, unit and mask, with points and balls: what is drilled, undone and done again is the same
/// bits, and so is its replay.
TEST(Session, DrillsUndoesAndReplaysInEveryFrameUnitAndMask) {
  const Folder folder;
  int n = 0;
  for (const scenes::Scan& scan : scenes::k_scans) {
    SCOPED_TRACE(scan.name());
    const bool is_round = n++ % 2 == 0 && scan.unit <= 1;
    haptics::TouchScene scene = scenes::scan_scene(scan, false);
    drilling::Burr options;
    options.diameter = 9 * scan.unit, options.feed_limit = 40 * scan.unit, options.is_round = is_round;
    options.removal_rate = 2000 * std::pow(scan.unit, 3);
    ASSERT_FALSE(haptics::set_smallest_burr(scene, options.diameter).has_value());
    const double radius = drilling::touch_radius(options, *scene.base);
    if (is_round) {
      ASSERT_FALSE(haptics::set_tool_radius(scene, radius).has_value());
    }
    const auto method = haptics::make_method(haptics::k_default_method).value();
    ASSERT_FALSE(method->prepare(scene).has_value());
    const std::string path = folder.file((std::to_string(n) + ".session").c_str());
    std::uint64_t hash = 0;
    double removed = 0;
    {
      SessionHeader header = describe_scene(scene, *method, {}, {HandSpec(drilling::burr(options))});
      header.program = "test";
      auto made = SessionWriter::create(path, header, scene.base, drilling_catalogue());
      ASSERT_EQ(made.is_ok(), scan.unit <= 1);  // sessions hold burrs to 1 m
      if (!made) continue;
      const auto writer = std::move(made).value();
      Lockstep run(scene, *method, drilling::burr(options), {}, 1000, writer.get());
      const haptics::PosePath slide =
          scenes::sphere_slide(45 + (is_round ? radius / scan.unit : 0), 3, 60, 1);
      int contacts = 0;
      const auto go = [&](int from, int to, bool is_pressed) {
        for (int i = from; i < to; ++i) {
          haptics::Pose pose = slide.at(1e-3 * i);
          pose.position_world *= scan.unit;
          pose.press(is_pressed);
          const haptics::ServoRecord r = run.step(pose);
          contacts += r.has_contact;
          EXPECT_TRUE(glm::length(r.force_world) <= 10.0001) << i;
        }
      };
      const std::uint64_t whole = run.engine().current()->content_hash();
      go(0, 300, true);
      go(300, 350, false);
      const std::uint64_t drilled = run.engine().current()->content_hash();
      EXPECT_NE(drilled, whole);
      EXPECT_GT(run.engine().removed_mm3(), 100 * std::pow(scan.unit, 3));
      run.undo();
      EXPECT_EQ(run.engine().current()->content_hash(), whole);
      go(350, 400, false);
      run.redo();
      EXPECT_EQ(run.engine().current()->content_hash(), drilled);
      go(400, 500, true);
      EXPECT_GT(contacts, 200);
      hash = run.engine().current()->content_hash(), removed = run.engine().removed_mm3();
      EXPECT_FALSE(writer->finish(run.engine(), 0).has_value());
    }
    const Verdict v = replay(path, scene.base);
    expect_same(v);
    EXPECT_EQ(v.hash, hash);
    EXPECT_EQ(v.removed, removed);
  }
}

// Inputs come back to the bit, whatever they are; forces as facts, to half a mN.
TEST(Session, KeepsInputsExactlyAndForcesToHalfAMillinewton) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> along(-100, 100);
  const double odd[] = {0.0,    -0.0,    1e-300,   -1e9, 0x1p52, std::numeric_limits<double>::infinity(),
                        1e300,  0x1p-20, -0x1p-21, 1e6,  0.1,    std::numeric_limits<double>::quiet_NaN(),
                        5e-324, 0x1p32,  -0x1p60,  3.5};
  std::vector<haptics::ServoRecord> told;
  ItemEncoder encoder({});
  haptics::Pose pose;
  for (int i = 0; i < 3000; ++i) {
    haptics::ServoRecord r;
    r.tick = static_cast<std::uint64_t>(i) + (i > 1500 ? 1'000'000'000'000u : 0);
    const bool is_odd = random() % 7 == 0;
    for (int a = 0; a < 3; ++a) {
      pose.position_world[a] = is_odd ? odd[random() % std::size(odd)] : pose.position_world[a] + 0.01;
      r.force_world[a] = random() % 3 == 0 ? along(random) / 20 : 0;
    }
    if (random() % 5 == 0)
      pose.orientation.x = random() % 2 == 0 ? along(random) : odd[random() % std::size(odd)];
    r.pose = random() % 2 == 0 ? haptics::on_grid(pose) : pose;
    r.version = random() % 9 == 0 ? random() : told.empty() ? 0 : told.back().version;
    r.has_contact = random() % 2 == 0;
    encoder.add(r);
    told.push_back(r);
  }
  const std::string bytes = encoder.take();
  ItemDecoder decoder(bytes, {});
  for (const haptics::ServoRecord& r : told) {
    const auto item = decoder.next();
    ASSERT_TRUE(item.is_ok());
    const haptics::ServoRecord& back = std::get<TickItem>(item.value()).record;
    ASSERT_EQ(back.tick, r.tick);
    ASSERT_EQ(back.version, r.version);
    ASSERT_EQ(back.has_contact, r.has_contact);
    ASSERT_EQ(std::memcmp(&back.pose.position_world, &r.pose.position_world, sizeof(dvec3)), 0) << r.tick;
    ASSERT_EQ(std::memcmp(&back.pose.orientation, &r.pose.orientation, sizeof(glm::dquat)), 0) << r.tick;
    ASSERT_LE(glm::length(back.force_world - r.force_world), 0x1p-10);
  }
  EXPECT_TRUE(decoder.is_at_end());
}

// Drilling and sliding, with the noise of an encoder and a stylus that turns.
TEST(Session, ATickOfContactTakesAtMost25Bytes) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  Bench bench;
  auto writer = bench.writer(path);
  // First it drills, then it slides.
  std::vector<haptics::PosePath::Sample> samples = drilling_wish(10).samples();
  for (double t = 10; t < 21; t += 0.05)
    samples.push_back({t, {{5 * std::sin(4 * t), 4 * std::cos(3 * t), 1.2}, {1, 0, 0, 0}, false}});
  haptics::VirtualDevice device(haptics::PosePath::from_samples(samples, "test").value(), {});
  ASSERT_FALSE(device.open());
  Lockstep run(bench.scene, bench.method, drilling::burr(k_burr), {}, 1000, writer.get());
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 2e-4);
  double contacts = 0, cut = 0;
  constexpr int k_ticks = 20'000;
  for (int i = 0; i < k_ticks; ++i) {
    haptics::Pose pose;
    ASSERT_TRUE(device.read(1e-3 * i, pose));
    const double turn = 0.3 * std::sin(2e-3 * i), w = std::cos(turn), x = std::sin(turn) + noise(random);
    const double y = noise(random), z = noise(random);
    pose.orientation = glm::normalize(glm::dquat(w, x, y, z));
    const haptics::ServoRecord r = run.step(pose);
    device.write(r.force_world);
    contacts += r.has_contact;
    cut += run.last_outcome().is_changed;
  }
  EXPECT_FALSE(writer->finish(run.engine(), 0).has_value());
  const double bytes = static_cast<double>(fs::file_size(path)) / k_ticks;
  EXPECT_GT(contacts, 0.4 * k_ticks);
  EXPECT_GT(cut, 0.08 * k_ticks);
  EXPECT_LE(bytes, 25);
  RecordProperty("bytes", std::to_string(bytes));
  std::printf("%.1f bytes a tick\n", bytes);
  expect_same(replay(path));
}

TEST(Session, KeepsButtonsAndAxesOfEveryHand) {
  std::mt19937 random(8);
  std::vector<haptics::ServoRecord> told;
  ItemEncoder encoder({});
  std::array<haptics::Pose, 2> poses;
  for (int i = 0; i < 400; ++i)
    for (std::uint8_t hand = 0; hand < 2; ++hand) {
      haptics::Pose& pose = poses[hand];
      if (random() % 5 == 0)
        pose.buttons = static_cast<std::uint32_t>(random() % 3 == 0 ? random() : random() % 2);
      if (random() % 7 == 0) pose.axes[random() % 4] = 0.25f * static_cast<float>(random() % 5);
      haptics::ServoRecord record;
      record.tick = static_cast<std::uint64_t>(i);
      record.hand = hand;
      record.pose = pose;
      encoder.add(record);
      told.push_back(record);
    }
  const std::string bytes = encoder.take();
  ItemDecoder decoder(bytes, {});
  for (const haptics::ServoRecord& record : told) {
    const auto item = decoder.next();
    ASSERT_TRUE(item.is_ok());
    const haptics::ServoRecord& read = std::get<TickItem>(item.value()).record;
    ASSERT_EQ(read.hand, record.hand);
    ASSERT_EQ(read.pose.buttons, record.pose.buttons);
    ASSERT_EQ(read.pose.axes, record.pose.axes);
  }
  EXPECT_TRUE(decoder.is_at_end());
  // Bytes that say of the first button both that it is pressed and that it is not.
  haptics::ServoRecord second_button;
  second_button.pose.buttons = 2;
  encoder.add(second_button);
  std::string torn = encoder.take();
  EXPECT_TRUE(ItemDecoder(torn, {}).next().is_ok());
  torn[0] = static_cast<char>(torn[0] ^ 8);
  EXPECT_FALSE(ItemDecoder(torn, {}).next().is_ok());
}

}  // namespace
}  // namespace trephine::sim
