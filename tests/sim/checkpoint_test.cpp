// Checkpoints: a session opens at any tick with the same bits as one played from its start.
#include <deque>
#include <thread>

#include "haptics/force/effects.h"
#include "sim/drivers/live_session.h"
#include "sim/session/compression.h"
#include "tests/sim/crowd.h"
#include "tests/sim/opens_anywhere.h"
#include "tests/sim/round_bench.h"
#include "tests/sim/saw_bench.h"
#include "tests/sim/toy_bench.h"
#include "volume/base/bytes.h"

namespace trephine::sim {
namespace {

TEST(Checkpoint, ARandomLogOpensAtAnyTick) {
  const Folder folder;
  for (unsigned seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE(seed);
    const std::string path = folder.file((std::to_string(seed) + ".session").c_str());
    ToyBench bench;
    auto writer = bench.toy_writer(path, with_checkpoint_work(2000));
    Lockstep run(bench.engine(), {}, 1000, writer.get());
    std::mt19937 random(seed);
    const haptics::PosePath request = drilling_path(20);
    for (int i = 0; i < 3000; ++i) {
      run.step(request.at(1e-3 * i));
      if (i % 10 != 0) continue;
      for (int n = static_cast<int>(random() % 3); n > 0; --n)
        run.apply(with_hash(random_command(random, run.engine().jobs()), run.engine()));
    }
    EXPECT_FALSE(writer->finish(run.engine()));
    EXPECT_LT(expect_opens_anywhere(path, toys(), bench.scene.base), 2500u);
  }
}

// The servo runs up to forty ticks ahead of the edits, and therefore reads scenes without their changes.
TEST(Checkpoint, OpensWithAServoAheadOfTheEdits) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  ToyBench bench;
  auto writer = bench.toy_writer(path, with_checkpoint_work(1000));
  Engine engine = bench.engine();
  writer->begin(engine, {}, 1000, 0, true);
  haptics::ServoCore core({}, 1e-3);
  std::deque<haptics::ServoRecord> ring;
  auto published = engine.servo_scene();
  const haptics::PosePath request = drilling_path(20);
  std::mt19937 random(4);
  for (int tick = 0; tick < 3000 || !ring.empty();) {
    const bool wants_tick = random() % 2 == 0;
    if (tick < 3000 && (ring.empty() || (wants_tick && ring.size() < 40))) {
      const haptics::DenormalsFlushed flushed;
      haptics::ServoInput input;
      input.pose = haptics::rounded_to_grid(request.at(1e-3 * tick++));
      if (random() % 211 == 0) core.skip(haptics::fault_full_ring, random() % 5), input.is_reset = true;
      ring.push_back(core.step(*published, input));
      continue;
    }
    const haptics::ServoRecord record = ring.front();
    ring.pop_front();
    const Outcome outcome = engine.apply(record);
    writer->add(record, engine, outcome);
    if (outcome.is_changed) published = engine.servo_scene();
    if (random() % 40 != 0) continue;
    const Command command = with_hash(random_command(random, engine.jobs()), engine);
    const Outcome done = engine.apply(command);
    writer->add(command, engine, done);
    if (done.is_changed) published = engine.servo_scene();
  }
  EXPECT_FALSE(writer->finish(engine));
  expect_opens_anywhere(path, toys(), bench.scene.base);
}

TEST(Checkpoint, ASessionWithAllFeaturesOpensAtAnyTick) {
  const Folder folder;
  const std::string path = folder.file("crowd.session");
  std::uint64_t state = 0;
  record_crowd(path, &state, 3000);
  expect_opens_anywhere(path, drilling_catalogue(), {});
}

/// Records `ticks` ticks of drilling with a round burr. Calls on_tick(run, tick) after each.
template <class OnTick>
void record_drilling(RoundBench& bench, const std::string& path, int ticks, OnTick&& on_tick) {
  auto writer = bench.writer(path, 1000, with_checkpoint_work(4000));
  Lockstep run(bench.scene, *bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
  const haptics::PosePath request = drilling_path(10);
  for (int i = 0; i < ticks; ++i) {
    run.step(request.at(1e-3 * i));
    on_tick(run, i);
  }
  EXPECT_FALSE(writer->finish(run.engine()));
}

TEST(Checkpoint, FieldsOfARoundToolAreContained) {
  const Folder folder;
  const std::string path = folder.file("round.session");
  RoundBench bench;
  record_drilling(bench, path, 2500, [](Lockstep& run, int i) {
    if (i % 500 == 250) run.undo();
    if (i % 500 == 300) run.redo();
  });
  expect_opens_anywhere(path, drilling_catalogue(), bench.scene.base, 2);
}

TEST(Checkpoint, ALiveSessionOpensAtAnyTick) {
  const Folder folder;
  const std::string path = folder.file("live.session");
  RoundBench bench;
  {
    auto writer = bench.writer(path, 1000, with_checkpoint_work(3000));
    haptics::VirtualDevice device(drilling_path(20), {});
    LiveSession live(device, bench.scene, *bench.method, drilling::burr(bench.burr), {}, writer.get());
    ASSERT_FALSE(live.start().has_value());
    for (int i = 0; i < 6; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      if (i % 2 == 1) live.undo();
    }
    live.stop();
    EXPECT_FALSE(writer->finish(live.engine()));
  }
  expect_opens_anywhere(path, drilling_catalogue(), bench.scene.base, 2);
}

// A session that is killed, opened at its newest checkpoint, continued and killed again opens at any tick.
TEST(Checkpoint, ContinuesWithoutPlayingTheWholeSession) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  Bench bench;
  {
    auto writer = bench.writer(path, 1000, with_checkpoint_work(1500));
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    const haptics::PosePath request = drilling_path(10);
    for (int i = 0; i < 4000; ++i) {
      run.step(request.at(1e-3 * i));
      if (i % 500 == 250) run.undo();
    }
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  for (int part = 0; part < 2; ++part) {
    fs::resize_file(path, fs::file_size(path) - 100);
    auto opened = SessionReader::open(path, drilling_catalogue());
    ASSERT_TRUE(opened.is_ok());
    const auto replay_of = Replay::open(opened.value(), bench.scene.base).value();
    Replay& replay = *replay_of;
    ASSERT_FALSE(replay.seek(opened.value().tick_count()));
    EXPECT_FALSE(replay.mismatch());
    EXPECT_LT(replay.counts().ticks, 1600u);
    const std::uint64_t first_tick = replay.next_tick();
    auto writer = SessionWriter::append(SessionLock::acquire(path).value(), replay.tail(),
                                        drilling_catalogue(), with_checkpoint_work(1500))
                      .value();
    Engine engine = std::move(replay.engine());
    const Command command{Resume{}};
    const Outcome outcome = engine.apply(command);
    writer->add(command, engine, outcome);
    Lockstep run(std::move(engine), {}, 1000, writer.get(), first_tick);
    // Undo restores states of strokes that this replay did not play, and the run continues from there.
    for (int i = 0; i < 4; ++i) EXPECT_FALSE(run.undo().refused);
    const haptics::PosePath request = drilling_path(10);
    for (int i = 0; i < 2500; ++i) {
      run.step(request.at(2e-3 * i));
      if (i % 700 == 600) run.undo();
    }
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  expect_opens_anywhere(path, drilling_catalogue(), bench.scene.base);
}

// Undos occur at random ticks, with escape paths of varying length. The session opens at any tick.
TEST(Checkpoint, OpensAfterManyUndos) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  Bench bench;
  auto writer = bench.writer(path, 1000, with_checkpoint_work(1500));
  Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
  const haptics::PosePath request = drilling_path(10);
  std::mt19937 random(3);
  long led = 0;
  for (int i = 0; i < 6000; ++i) {
    led += run.step(request.at(1e-3 * i)).is_escaping;
    if (random() % 300 == 0) run.undo();  // in contact and in the air
  }
  EXPECT_GT(led, 20);
  EXPECT_FALSE(writer->finish(run.engine()));
  expect_opens_anywhere(path, drilling_catalogue(), bench.scene.base);
}

// An engine that is restored from a snapshot has the same settings, although some commands are valid only in
// a certain order. One of eight effects, the maximum, must end before another can begin. The burr must become
// larger before the contact ball can.
TEST(Checkpoint, CommandsAreRepeatedInAValidOrder) {
  RoundBench bench;
  auto laws = std::make_shared<haptics::LawSet>();
  for (std::uint32_t id = 1; id <= haptics::LawSet::k_max; ++id)
    ASSERT_FALSE(laws->add(haptics::law_of(haptics::parse_effect("viscous").value(), id).value()));
  Engine engine(
      {HandStart{haptics::ServoHand(haptics::borrowed(bench.scene), haptics::borrowed(*bench.method),
                                    haptics::TouchState(nullptr), laws),
                 drilling::burr(bench.burr)}},
      1e-3);
  engine.freeze();
  const Engine start = engine;
  EXPECT_FALSE(engine.apply(SetEffect{{8}, ""}).refused);
  EXPECT_FALSE(engine.apply(SetEffect{{0}, "gravity mass=0.1"}).refused);
  drilling::Burr larger = bench.burr;
  larger.diameter = 5;
  EXPECT_FALSE(engine.apply(larger).refused);
  const Outcome begun = engine.apply(ToolGeometry{2});
  ASSERT_FALSE(begun.refused);
  EXPECT_TRUE(engine.apply(engine.run_job(begun.job)).is_changed);
  const EngineSnapshot snapshot = engine.full_snapshot();
  Engine again = start;
  const Status error = again.restore(snapshot);
  ASSERT_FALSE(error) << error->message();
  EXPECT_EQ(again.state().hash(), engine.state().hash());
  const auto &restored = again.servo_scene()->hands[0], &wanted = engine.servo_scene()->hands[0];
  EXPECT_EQ(restored.scene, wanted.scene);
  ASSERT_EQ(restored.laws->laws().size(), wanted.laws->laws().size());
  for (std::size_t l = 0; l < restored.laws->laws().size(); ++l)
    EXPECT_EQ(restored.laws->laws()[l].id, wanted.laws->laws()[l].id);
}

/// A block of a session file.
struct Block {
  BlockHead head;
  std::string payload;
};
std::vector<Block> blocks_of(const std::string& path, std::string& preamble) {
  std::ifstream in(path, std::ios::binary);
  const std::string all((std::istreambuf_iterator<char>(in)), {});
  std::string_view rest(all);
  preamble = rest.substr(0, 16);
  rest.remove_prefix(16);
  std::vector<Block> blocks;
  while (!rest.empty()) {
    Block block;
    EXPECT_TRUE(get(rest, block.head));
    block.payload = rest.substr(0, block.head.length);
    rest.remove_prefix(block.head.length + 8);
    blocks.push_back(std::move(block));
  }
  return blocks;
}
void write_blocks(const std::string& path, const std::string& preamble, std::vector<Block> blocks) {
  std::ofstream out(path, std::ios::binary);
  out << preamble;
  for (Block& block : blocks) {
    block.head.length = block.payload.size();
    const std::uint64_t check = block_checksum(block.head, block.payload);
    out.write(reinterpret_cast<const char*>(&block.head), sizeof block.head);
    out << block.payload;
    out.write(reinterpret_cast<const char*>(&check), sizeof check);
  }
}

struct RecordedSession {
  std::string path;
  std::string preamble;
  std::vector<Block> blocks;
  std::size_t checkpoint_block = 0;  ///< index of the block with the examined checkpoint
  CheckpointIndex index;
};
RecordedSession recorded(const Folder& folder) {
  RecordedSession all;
  all.path = folder.file("a.session");
  Bench bench;
  auto writer = bench.writer(all.path, 1000, with_checkpoint_work(1500));
  Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
  const haptics::PosePath request = drilling_path(10);
  for (int i = 0; i < 3000; ++i) run.step(request.at(1e-3 * i));
  EXPECT_FALSE(writer->finish(run.engine()));
  all.blocks = blocks_of(all.path, all.preamble);
  std::size_t seen = 0;
  for (std::size_t b = 0; b < all.blocks.size(); ++b)
    if (static_cast<BlockKind>(all.blocks[b].head.kind) == BlockKind::checkpoint && ++seen == 4)
      all.checkpoint_block = b;
  EXPECT_GT(all.checkpoint_block, 0u);
  EXPECT_TRUE(read_index(all.blocks[all.checkpoint_block].payload, all.index));
  return all;
}

/// Returns the payload of the checkpoint with other bytes in one part. Its lengths are valid.
std::string with_part(const RecordedSession& good, const CheckpointIndex::Part& part,
                      const std::string& bytes) {
  const std::string& payload = good.blocks[good.checkpoint_block].payload;
  const auto bytes_at = [&](const CheckpointIndex::Part& one) {
    return one.at == part.at ? compress(bytes) : payload.substr(one.at, one.length);
  };
  std::string result;
  put(result, good.index.block);
  put(result, good.index.next_tick);
  put_number(result, static_cast<std::int64_t>(good.index.links.size()));
  for (const CheckpointIndex::Link& link : good.index.links) {
    put_number(result, static_cast<std::int64_t>(link.chain));
    put_number(result, static_cast<std::int64_t>(link.number));
    put(result, static_cast<std::uint8_t>(link.is_first));
    put_text(result, bytes_at(link.bytes));
  }
  for (const CheckpointIndex::Part* one :
       {&good.index.events, &good.index.trails, &good.index.history, &good.index.rest})
    put_text(result, bytes_at(*one));
  return result;
}

// Planted faults: every changed fact of a checkpoint is detected.
TEST(Checkpoint, EveryChangedFactIsDetected) {
  const Folder folder;
  const RecordedSession good = recorded(folder);
  const auto part_of = [&](const CheckpointIndex::Part& part) {
    return decompress(good.blocks[good.checkpoint_block].payload.substr(part.at, part.length)).value();
  };
  const std::string rest = part_of(good.index.rest);
  std::mt19937 random(3);
  int seen = 0;
  constexpr int k_faults = 60;
  for (int i = 0; i < k_faults; ++i) {
    // The fault is a flipped bit of the rest (cores, ticks, settings), of a trail, or of the last link.
    std::vector<Block> blocks = good.blocks;
    const CheckpointIndex::Part part = i % 3 == 0   ? good.index.rest
                                       : i % 3 == 1 ? good.index.trails
                                                    : good.index.links[good.index.links.size() - 1].bytes;
    std::string bytes = part_of(part);
    if (bytes.size() < 4) continue;
    const std::size_t at = i % 3 == 1 ? bytes.size() - 8 * 3 + 6  // of the newest position
                                      : random() % bytes.size();
    bytes[at] = static_cast<char>(bytes[at] ^ (i % 3 == 1 ? 1 : 1 << random() % 8));
    blocks[good.checkpoint_block].payload = with_part(good, part, bytes);
    write_blocks(good.path, good.preamble, blocks);
    auto opened = SessionReader::open(good.path, drilling_catalogue());
    ASSERT_TRUE(opened.is_ok());
    const auto replay_of = Replay::open(opened.value(), small_bone().base).value();
    Replay& replay = *replay_of;
    replay.verify_checkpoints();
    for (;;) {
      const auto stepped = replay.step();
      ASSERT_TRUE(stepped.is_ok());
      if (!stepped.value()) break;
    }
    if (replay.mismatch()) {
      EXPECT_EQ(replay.mismatch()->what, "checkpoint");
      ++seen;
    } else {
      ADD_FAILURE() << "planted fault " << i << " at byte " << at << " of " << bytes.size();
    }
    // Seeking with the changed checkpoint is no error. In the worst case the replay skips the checkpoint.
    ASSERT_FALSE(replay.seek(good.index.next_tick + 5));
    ASSERT_FALSE(replay.seek(opened.value().tick_count()));
  }
  EXPECT_EQ(seen, k_faults);
}

/// Puts random bytes into the last checkpoint, with valid checksums. Expects that the session opens, in the
/// worst case at an older checkpoint, that it continues without crashing, also after undo, and that no force
/// exceeds its limit.
void expect_nothing_breaks(const std::string& path, const SceneData& data, unsigned seed) {
  RecordedSession good;
  good.path = path;
  good.blocks = blocks_of(good.path, good.preamble);
  for (std::size_t b = 0; b < good.blocks.size(); ++b)
    if (static_cast<BlockKind>(good.blocks[b].head.kind) == BlockKind::checkpoint) good.checkpoint_block = b;
  ASSERT_TRUE(read_index(good.blocks[good.checkpoint_block].payload, good.index));
  std::vector<CheckpointIndex::Part> parts{good.index.rest,   good.index.rest,    good.index.rest,
                                           good.index.trails, good.index.history, good.index.events};
  for (const CheckpointIndex::Link& link : good.index.links) parts.push_back(link.bytes);
  std::mt19937 random(seed);
  std::uint64_t unopened = 0, opened_by_it = 0;
  for (int i = 0; i < 40; ++i) {
    SCOPED_TRACE(i);
    const CheckpointIndex::Part& part = parts[random() % parts.size()];
    std::string bytes =
        decompress(good.blocks[good.checkpoint_block].payload.substr(part.at, part.length)).value();
    for (std::uint32_t n = 1 + random() % 8; n > 0 && !bytes.empty(); --n)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    if (i % 7 == 0) bytes.resize(bytes.size() / 2);
    std::vector<Block> blocks = good.blocks;
    blocks[good.checkpoint_block].payload = with_part(good, part, bytes);
    write_blocks(good.path, good.preamble, blocks);
    auto opened = SessionReader::open(good.path, drilling_catalogue());
    ASSERT_TRUE(opened.is_ok());
    const auto replay_of = Replay::open(opened.value(), data).value();
    Replay& replay = *replay_of;
    // A broken checkpoint is tried once: each attempt would begin the seek again at its start.
    for (std::uint64_t parts = 0; !replay.seek_for(good.index.next_tick + 3, 0).value(); ++parts)
      ASSERT_LT(parts, 3 * good.index.next_tick + 100);
    unopened += replay.counts().failed_checkpoints;
    opened_by_it += replay.counts().failed_checkpoints == 0;
    for (int n = 0; n < 200; ++n) {
      const auto stepped = replay.step();
      if (!stepped || !stepped.value()) break;
      ASSERT_LE(glm::length(replay.record().force_world), 8.001);
    }
    for (int n = 0; n < 3; ++n) replay.engine().apply(Undo{});
  }
  EXPECT_GT(unopened, 5u);
  EXPECT_GT(opened_by_it, 5u);
}

TEST(Checkpoint, RandomBytesBreakNothing) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  RoundBench bench;
  record_drilling(bench, path, 1200, [](Lockstep& run, int i) {
    if (i % 400 == 250) run.undo();
  });
  expect_nothing_breaks(path, bench.scene.base, 17);
}

// An operation continues after the reader of its session was closed. An undo that has to read the session is
// then refused.
TEST(Checkpoint, AnEngineMayOutliveItsReader) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  Bench bench;
  auto writer = bench.writer(path, 1000, with_checkpoint_work(1500));
  Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
  const haptics::PosePath request = drilling_path(10);
  for (int i = 0; i < 4000; ++i) run.step(request.at(1e-3 * i));
  ASSERT_FALSE(writer->finish(run.engine()));
  std::optional<Engine> continued;
  {
    auto opened = SessionReader::open(path, drilling_catalogue());
    const auto replay = Replay::open(opened.value(), bench.scene.base).value();
    ASSERT_FALSE(replay->seek(opened.value().tick_count()));
    ASSERT_GT(replay->counts().opened_checkpoints, 0u);
    continued.emplace(std::move(replay->engine()));
  }
  ASSERT_TRUE(continued->can_undo());
  for (int n = 0; n < 3 && continued->can_undo(); ++n)
    if (const Outcome outcome = continued->apply(Undo{}); outcome.refused) {
      EXPECT_NE(outcome.refused->message().find("no longer be read"), std::string::npos);
      return;
    }
  ADD_FAILURE() << "nothing had to be read";
}

TEST(Checkpoint, RandomBytesInBodiesBreakNothing) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  SawBench bench;
  auto writer = bench.writer(path, with_checkpoint_work(3000));
  Lockstep run(bench.engine(), {}, 1000, writer.get());
  saw(run);
  run.apply({RemoveInstrument{}, 1});
  detach_pieces(run);
  const haptics::PosePath first = resting(), second = sawing();
  for (int i = static_cast<int>(1000 * k_sawn); i < static_cast<int>(1000 * k_end); ++i) {
    const haptics::Pose poses[2] = {first.at(1e-3 * i), second.at(1e-3 * i)};
    run.step(poses);
    if (i == static_cast<int>(1000 * k_lift)) {
      ASSERT_FALSE(run.apply({HoldBody{{1}}, 1}).refused);
    }
  }
  ASSERT_FALSE(writer->finish(run.engine()));
  expect_nothing_breaks(path, bench.scene.base, 18);
}

/// Every fact of the end block is compared, and nothing may follow it.
TEST(Checkpoints, EveryFactOfTheEndIsCompared) {
  const Folder folder;
  RecordedSession all = recorded(folder);
  const auto verdict = [&] {
    const Verdict v = replay(all.path);
    return v.mismatch ? v.mismatch->what : v.error;
  };
  EXPECT_EQ(verdict(), "");
  const auto end_block = std::find_if(all.blocks.begin(), all.blocks.end(), [](const Block& block) {
    return block.head.kind == static_cast<std::uint32_t>(BlockKind::end);
  });
  ASSERT_NE(end_block, all.blocks.end());
  const SessionEnd truth = decode_end(end_block->payload).value();
  const std::pair<const char*, std::function<void(SessionEnd&)>> changes[] = {
      {"ticks", [](SessionEnd& e) { ++e.ticks; }},
      {"dropped ticks", [](SessionEnd& e) { ++e.dropped; }},
      {"version", [](SessionEnd& e) { ++e.serial; }},
      {"removed volume", [](SessionEnd& e) { e.removed_mm3 += 1; }},
      {"state", [](SessionEnd& e) { ++e.state; }},
      {"voxels", [](SessionEnd& e) { ++e.hash; }}};
  for (const auto& [what, change] : changes) {
    SessionEnd changed = truth;
    change(changed);
    end_block->payload = encode(changed);
    write_blocks(all.path, all.preamble, all.blocks);
    EXPECT_EQ(verdict(), what);
  }
  end_block->payload = encode(truth);
  write_blocks(all.path, all.preamble, all.blocks);
  EXPECT_EQ(verdict(), "");
  std::ofstream(all.path, std::ios::binary | std::ios::app) << "more";
  EXPECT_EQ(verdict(), "end");
}

}  // namespace
}  // namespace trephine::sim
