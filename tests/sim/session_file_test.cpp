// Session files: torn, damaged, foreign, older, on a full disk, with their scan, and for every kind of scan.
#include <csignal>
#include <cstring>
#include <fstream>
#include <random>
#include <sys/resource.h>

#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {
TEST(Session, OneWriterAtATimeAndAnEmptyAutosaveIsDeleted) {
  const Folder folder;
  Bench bench;
  WriterOptions options;
  options.is_removed_when_empty = true;
  const std::string path = folder.file("a.session");
  {
    auto writer = bench.writer(path, 1000, options);
    EXPECT_TRUE(SessionWriter::is_being_written(path));
    const auto second = SessionLock::acquire(path);
    ASSERT_FALSE(second.is_ok());
    EXPECT_NE(second.error().what.find("being recorded"), std::string::npos);
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    for (int i = 0; i < 20; ++i) run.step({{0, 0, 8}, {1, 0, 0, 0}, false});
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  EXPECT_FALSE(fs::exists(path));
  {
    auto writer = bench.writer(path, 1000, options);
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    const haptics::PosePath request = drilling_path(2);
    for (int i = 0; i < 550; ++i) run.step(request.at(1e-3 * i));
    run.undo();  // the stroke still counts as work, since it can be redone
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  EXPECT_TRUE(fs::exists(path));
  EXPECT_FALSE(SessionWriter::is_being_written(path));
}

TEST(Session, DamageInALargeScanIsNotATornEnd) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(224);  // 22 MB: longer than one read
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
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(100'000);
  file.put('\x55');
  file.close();
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  EXPECT_TRUE(opened.value().is_damaged());
}

TEST(Session, TornAtAnyByteTheWholeBlocksAreKept) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  record_lockstep(path, 1200);
  const auto size = fs::file_size(path);
  std::ifstream in(path, std::ios::binary);
  std::string bytes(size, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  std::mt19937 random(5);
  std::uint64_t last_ticks = 0;
  // The whole file is the last cut: the random cuts may end before its last block, whose length varies.
  std::vector<std::size_t> cuts;
  for (std::size_t cut = 0; cut < size; cut += 1 + random() % 97) cuts.push_back(cut);
  cuts.push_back(size);
  for (const std::size_t cut : cuts) {
    const std::string torn = folder.file("torn.session");
    std::ofstream(torn, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(cut));
    auto opened = SessionReader::open(torn);
    if (!opened) {
      EXPECT_LT(cut, 4000u);  // an error only if the header is incomplete
      EXPECT_FALSE(opened.error().what.empty());
      continue;
    }
    EXPECT_EQ(opened.value().complete_bytes() + opened.value().lost_bytes(), cut);
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
  // A block with a flipped bit is never read.
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

TEST(Session, ForeignNewerAndOlderFilesAreReported) {
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
  EXPECT_NE(foreign.error().what.find("not a session"), std::string::npos);
  write(std::string("TREPHSES\x7f\0\0\0\0\0\0\0", 16) + std::string(100, 'x'));
  auto newer = SessionReader::open(path, drilling_catalogue());
  ASSERT_FALSE(newer.is_ok());
  EXPECT_NE(newer.error().what.find("newer"), std::string::npos);

  // A session with older arithmetic can be viewed, but not verified.
  Bench bench;
  SessionHeader header = bench.header();
  header.revision = 0;
  header.program = "trephine 0.0.9";
  const std::string old = folder.file("old.session");
  {
    auto writer = SessionWriter::create(old, header, bench.scene.base, drilling_catalogue()).value();
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    for (int i = 0; i < 50; ++i) run.step({{0, 0, 5}, {1, 0, 0, 0}, false});
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  auto opened = SessionReader::open(old, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  const auto run_of = Replay::open(opened.value(), bench.scene.base).value();
  Replay& run = *run_of;
  const Status why = run.reason_not_verifiable();
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

TEST(Session, ContainsItsScanWhenRequested) {
  const Folder folder;
  Bench bench;
  WriterOptions options;
  options.is_embedding = true;
  const std::string path = folder.file("embedded.session");
  {
    auto writer = bench.writer(path, 1000, options);
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    for (int i = 0; i < 20; ++i) run.step({{0, 0, 5}, {1, 0, 0, 0}, false});
    EXPECT_FALSE(writer->finish(run.engine()));
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

TEST(Session, AFullDiskEndsTheRecordingAndKeepsWrittenBlocks) {
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
  const haptics::PosePath request = drilling_path(10);
  for (int i = 0; i < 3000; ++i) {
    run.step(request.at(1e-3 * i));
    if (i % 50 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }
  EXPECT_TRUE(writer->status().has_value());  // reported before finish()
  const Status status = writer->finish(run.engine());
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  ASSERT_TRUE(status.has_value());
  EXPECT_NE(status->what.find("ended early"), std::string::npos);
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  EXPECT_EQ(opened.value().lost_bytes(), 0u);
  EXPECT_GT(opened.value().tick_count(), 50u);
  expect_same(replay(path));

  // A missing directory is an error, and an existing file is never overwritten.
  EXPECT_FALSE(SessionWriter::create(folder.file("no/such/folder"), bench.header(), bench.scene.base,
                                     drilling_catalogue())
                   .is_ok());
  auto taken = SessionWriter::create(path, bench.header(), bench.scene.base, drilling_catalogue());
  ASSERT_FALSE(taken.is_ok());
  EXPECT_NE(taken.error().what.find("already"), std::string::npos);
}

/// For every frame, unit and mask, with points and balls: undo and redo restore the bits of the states, and
/// the replay gives the same bits.
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
      auto result = SessionWriter::create(path, header, scene.base, drilling_catalogue());
      ASSERT_EQ(result.is_ok(), scan.unit <= 1);  // sessions limit burrs to 1 m
      if (!result) continue;
      const auto writer = std::move(result).value();
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
      const std::uint64_t whole = run.engine().version()->content_hash();
      go(0, 300, true);
      go(300, 350, false);
      const std::uint64_t drilled = run.engine().version()->content_hash();
      EXPECT_NE(drilled, whole);
      EXPECT_GT(run.engine().removed_mm3(), 100 * std::pow(scan.unit, 3));
      run.undo();
      EXPECT_EQ(run.engine().version()->content_hash(), whole);
      go(350, 400, false);
      run.redo();
      EXPECT_EQ(run.engine().version()->content_hash(), drilled);
      go(400, 500, true);
      EXPECT_GT(contacts, 200);
      hash = run.engine().version()->content_hash(), removed = run.engine().removed_mm3();
      EXPECT_FALSE(writer->finish(run.engine()));
    }
    const Verdict v = replay(path, scene.base);
    expect_same(v);
    EXPECT_EQ(v.hash, hash);
    EXPECT_EQ(v.removed, removed);
  }
}

}  // namespace
}  // namespace trephine::sim
