// Live sessions: under load, with faults, with two hands, resumed, and killed by a signal.
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <deque>
#include <random>
#include <sys/mman.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "sim/drivers/live_session.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

/// Occupies the processors with threads during its lifetime.
class CpuLoad {
 public:
  explicit CpuLoad(int threads) {
    for (int i = 0; i < threads; ++i)
      threads_.emplace_back([this] {
        volatile double x = 1;
        while (!is_over_) x = x * 1.0000001 + 1e-9;
      });
  }
  ~CpuLoad() {
    is_over_ = true;
    for (std::thread& t : threads_) t.join();
  }

 private:
  std::atomic<bool> is_over_{false};
  std::vector<std::thread> threads_;
};

/// Records a live session under load, with `undos` undos while the burr touches bone. Sets `hash` to that of
/// the last version, and `removed` to the removed volume, mm3.
void record_live(const std::string& path, int undos, double rate, std::uint64_t* hash, double* removed) {
  Bench bench;
  auto writer = bench.writer(path, rate);
  haptics::VirtualDevice device(drilling_path(60), {});
  haptics::ServoOptions options;
  options.rate_hz = rate;
  LiveSession live(device, bench.scene, bench.method, drilling::burr(bench.burr), options, writer.get());
  const CpuLoad load(3);
  ASSERT_FALSE(live.start().has_value());
  int done = 0;
  for (int i = 0; i < 20000 && done < undos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const LiveState s = live.fetch_state();
    if (s.newest.faults & haptics::k_latched_faults) live.reset_faults();
    // Undoes while the burr is in its hole, so that bone grows over the burr.
    if (s.can_undo && s.newest.pose.is_pressed() && s.newest.has_contact && s.newest.t > 0.15 * (done + 1)) {
      live.undo();
      if (++done % 5 == 0) live.redo();
      if (done == 7) live.apply(drilling::Burr{2, k_burr.removal_rate, k_burr.feed_limit});
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  EXPECT_EQ(done, undos);
  live.stop();
  *hash = live.engine().version()->content_hash();
  *removed = live.engine().removed_mm3();
  const Status status = writer->finish(live.engine());
  EXPECT_FALSE(status.has_value()) << status->message();
}

TEST(Session, ALiveRunUnderLoadWithUndosInContactReplaysToTheBit) {
  const Folder folder;
  const std::string path = folder.file("live.session");
  std::uint64_t hash = 0;
  double removed = 0;
  record_live(path, 20, 500, &hash, &removed);
  if (const char* keep = std::getenv("TREPHINE_KEEP_SESSION"))
    fs::copy_file(path, keep, fs::copy_options::overwrite_existing);
  // Two replays run at the same time: they share no data.
  Verdict first, second;
  std::thread other([&] { second = replay(path); });
  first = replay(path);
  other.join();
  expect_same(first);
  expect_same(second);
  EXPECT_EQ(first.hash, hash);
  EXPECT_EQ(second.hash, hash);
  EXPECT_EQ(first.removed, removed);
  EXPECT_GE(first.counts.commands, 20u);
  EXPECT_GT(first.counts.versions, 50u);
  EXPECT_GT(first.counts.hashes, 3u);
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  ASSERT_TRUE(opened.value().end().has_value());
  EXPECT_EQ(opened.value().end()->hash, hash);
  EXPECT_EQ(opened.value().lost_bytes(), 0u);
}

/// A burr whose step takes `milliseconds` (ms) longer in tick 100.
struct SlowBurr {
  double milliseconds = 0;
  drilling::Burr burr = k_burr;
  static const Schema& schema() {
    static constexpr Field fields[] = {field<&SlowBurr::milliseconds>("milliseconds", {.unit = "ms"})};
    static constexpr Schema table{"slow-burr", 1, fields};
    return table;
  }
};
void step_slowly(const SlowBurr& slow, drilling::BurrState& state, const InstrumentInput& input, Work& work) {
  if (input.tick.tick == 100)
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(slow.milliseconds));
  drilling::burr(slow.burr).type->step(&slow.burr, &state, input, work);
}
Status check_slow(const SlowBurr&, const haptics::TouchScene&) { return std::nullopt; }
ToolBall slow_body(const SlowBurr&, const drilling::BurrState& state, const InstrumentInput&) {
  return {state.centre, 0};
}
class SlowDrilling final : public Module {
 public:
  std::string_view name() const noexcept override { return "slow drilling"; }
  std::span<const InstrumentType* const> instruments() const override {
    static const std::array all{&instrument_type<step_slowly, check_slow, slow_body>()};
    return all;
  }
};

// A full ring drops whole ticks and fades the force. Late edits make the scene stale. Both faults are latched
// and recorded, and the session replays without a mismatch.
TEST(Session, AFullRingAndSlowEditsFadeTheForceAndReplay) {
  const Folder folder;
  for (const bool is_full : {true, false}) {
    const std::string path = folder.file(is_full ? "full.session" : "slow.session");
    Bench bench;
    const SlowDrilling module;
    const Catalogue catalogue({&module});
    const Instrument slow(instrument_type<step_slowly, check_slow, slow_body>(),
                          SlowBurr{is_full ? 300.0 : 700.0});
    SessionHeader header = bench.header();
    header.hands = {HandSpec(slow)};
    auto writer = SessionWriter::create(path, header, bench.scene.base, catalogue).value();
    haptics::VirtualDevice device(
        haptics::PosePath::from_samples(
            {{0, {{0, 0, 1.5}, {1, 0, 0, 0}, true}}, {3, {{0, 0, 0.5}, {1, 0, 0, 0}, true}}}, "test")
            .value(),
        {});
    haptics::ServoOptions options;
    if (is_full) options.ring_capacity = 64;
    LiveSession live(device, bench.scene, bench.method, slow, options, writer.get());
    live.keep_trace(100000);
    ASSERT_FALSE(live.start().has_value());
    const auto wait_until = [&](auto&& done) {
      for (int i = 0; i < 2000; ++i) {
        if (done(live.fetch_state())) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      }
      return false;
    };
    const std::uint32_t fault = is_full ? haptics::fault_full_ring : haptics::fault_stale_scene;
    EXPECT_TRUE(
        wait_until([&](const LiveState& s) { return (s.newest.faults & fault) && s.newest.tick > 500; }));
    const std::uint64_t seen_at = live.fetch_state().newest.tick;
    EXPECT_TRUE(wait_until([&](const LiveState& s) { return s.newest.tick > seen_at + 80; }));
    EXPECT_EQ(live.fetch_state().newest.force_world, dvec3(0));
    live.reset_faults();
    EXPECT_TRUE(
        wait_until([&](const LiveState& s) { return (s.newest.faults & haptics::k_latched_faults) == 0; }));
    EXPECT_TRUE(wait_until([&](const LiveState& s) { return s.newest.tick > 1500; }));
    live.stop();
    const haptics::ServoReport report = live.servo_report();
    EXPECT_FALSE(writer->finish(live.engine()));
    const Verdict v = replay(path, nullptr, catalogue);
    expect_same(v);
    EXPECT_EQ(v.hash, live.engine().version()->content_hash());
    EXPECT_EQ(v.counts.dropped, report.dropped);
    EXPECT_EQ(report.dropped > 0, is_full);
    // Seeking back and forth plays ticks twice. The replay must count them once, without a mismatch.
    auto again = SessionReader::open(path, catalogue);
    ASSERT_TRUE(again.is_ok());
    const auto sought = Replay::open(again.value(), small_bone().base);
    ASSERT_TRUE(sought.is_ok());
    for (const std::uint64_t tick :
         {again.value().tick_count(), std::uint64_t{1}, again.value().tick_count()})
      EXPECT_FALSE(sought.value()->seek(tick));
    EXPECT_FALSE(sought.value()->mismatch()) << sought.value()->mismatch()->what;
    // The fault and its end are events of the session.
    auto opened = SessionReader::open(path, drilling_catalogue());
    ASSERT_TRUE(opened.is_ok());
    std::vector<std::string> events;
    for (LogItem item; opened.value().next(item).value();)
      if (const auto* event = std::get_if<EventItem>(&item))
        if (const auto* fault = event->event.value.as<FaultEvent>())
          events.push_back(fault->is_cleared ? "cleared" : fault->names);
    ASSERT_GE(events.size(), 2u);
    // The stale scene is the first fault, also if the ring is small.
    EXPECT_NE(events.front().find("stale scene"), std::string::npos) << events.front();
    const auto is_full_ring = [](const std::string& e) { return e.find("full ring") != std::string::npos; };
    EXPECT_EQ(std::any_of(events.begin(), events.end(), is_full_ring), is_full);
    EXPECT_EQ(events.back(), "cleared");
    // After the fault the force falls to zero within the fade's 50 ms.
    std::uint64_t faulty = 0;
    for (const haptics::ServoRecord& r : live.trace()) {
      if (faulty == 0 && (r.faults & fault)) faulty = r.tick;
      if (faulty != 0 && (r.faults & fault) && r.tick > faulty + 51) {
        EXPECT_EQ(r.force_world, dvec3(0)) << r.tick;
      }
    }
    EXPECT_GT(faulty, 0u);
  }
}

TEST(Session, TwoHandsShareAServoAndAHistory) {
  const Folder folder;
  const std::string path = folder.file("two.session");
  Bench bench;
  SessionHeader header = bench.header();
  header.hands.push_back(header.hands[0]);
  auto writer = SessionWriter::create(path, header, bench.scene.base, drilling_catalogue()).value();
  const auto request = [](double x) {
    return haptics::PosePath::from_samples({{0, {{x, 0, 6}, {1, 0, 0, 0}, false}},
                                            {0.1, {{x, 0, 3}, {1, 0, 0, 0}, true}},
                                            {0.5, {{x, 0, 0.5}, {1, 0, 0, 0}, true}},
                                            {0.6, {{x, 0, 6}, {1, 0, 0, 0}, false}}},
                                           "test")
        .value();
  };
  haptics::VirtualDevice left(request(-4), {}), right(request(4), {});
  right.lose_at(0.8);
  haptics::Device* devices[] = {&left, &right};
  const HandStart hand{haptics::ServoHand(haptics::borrowed(bench.scene), haptics::borrowed(bench.method),
                                          haptics::TouchState(nullptr)),
                       drilling::burr(k_burr)};
  LiveSession live(devices, Engine({hand, hand}, 1e-3), {}, writer.get());
  live.keep_trace(100000);
  ASSERT_FALSE(live.start().has_value());
  for (int i = 0; i < 3000 && live.fetch_state().newest.t < 1.0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  live.stop();
  EXPECT_FALSE(writer->finish(live.engine()));
  // Both hands drilled, in one stroke. In each tick both hands read the same version.
  EXPECT_EQ(live.engine().stroke_count(), 1u);
  EXPECT_GT(live.engine().removed_mm3(), 5);
  const auto& trace = live.trace();
  bool left_contact = false, right_contact = false;
  for (std::size_t i = 0; i + 1 < trace.size(); i += 2) {
    ASSERT_EQ(trace[i].tick, trace[i + 1].tick);
    ASSERT_EQ(trace[i].version, trace[i + 1].version);
    ASSERT_EQ(trace[i].hand, 0);
    ASSERT_EQ(trace[i + 1].hand, 1);
    left_contact = left_contact || trace[i].has_contact;
    right_contact = right_contact || trace[i + 1].has_contact;
  }
  EXPECT_TRUE(left_contact && right_contact);
  // The loss of a device is a fault of its own hand only.
  EXPECT_TRUE(trace.back().faults & haptics::fault_lost_device);
  EXPECT_EQ(trace[trace.size() - 2].faults & haptics::k_latched_faults, 0u);
  const Verdict v = replay(path);
  expect_same(v);
  EXPECT_EQ(v.hash, live.engine().version()->content_hash());
}

TEST(Session, ContinuesWhereItStopped) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  record_lockstep(path, 700);
  // Removes the end and a part of the last block, as if the process was killed.
  fs::resize_file(path, fs::file_size(path) - 100);
  Bench bench;
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok());
  SessionReader& session = opened.value();
  EXPECT_FALSE(session.end().has_value());
  const auto before_of = Replay::open(session, bench.scene.base).value();
  Replay& before = *before_of;
  ASSERT_FALSE(before.seek(session.tick_count()).has_value());
  const std::uint64_t first_tick = before.next_tick();
  auto writer =
      SessionWriter::append(SessionLock::acquire(path).value(), before.tail(), drilling_catalogue()).value();
  Engine edits = std::move(before.engine());
  const Command command{Resume{}};
  const Outcome outcome = edits.apply(command);
  writer->add(command, edits, outcome);
  haptics::VirtualDevice device(drilling_path(10), {});
  haptics::Device* devices[] = {&device};
  LiveSession live(devices, std::move(edits), {}, writer.get(), first_tick);
  ASSERT_FALSE(live.start().has_value());
  for (int i = 0; i < 3000 && live.fetch_state().newest.tick < first_tick + 400; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  live.undo();
  live.stop();
  EXPECT_FALSE(writer->finish(live.engine()));
  const Verdict v = replay(path);
  expect_same(v);
  EXPECT_EQ(v.hash, live.engine().version()->content_hash());
  EXPECT_GE(v.counts.ticks, first_tick + 400);
}

// A power cut loses no finished stroke and no command: the file is synced at once after both.
TEST(Session, EndsOfStrokesAndCommandsAreSyncedAtOnce) {
  const Folder folder;
  Bench bench;
  WriterOptions options;
  options.sync_seconds = 1000;  // no periodic sync during the test
  auto writer = bench.writer(folder.file("a.session"), 1000, options);
  Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
  const auto wait_for = [&](int syncs) {
    for (int i = 0; i < 2000 && writer->sync_count() < syncs; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return writer->sync_count() >= syncs;
  };
  for (int i = 0; i < 30; ++i) run.step({{0, 0, 3.0 - 0.1 * i}, {1, 0, 0, 0}, true});
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(writer->sync_count(), 0) << "not in the middle of a stroke";
  run.step({{0, 0, 3}, {1, 0, 0, 0}, false});
  EXPECT_TRUE(wait_for(1));
  run.undo();
  EXPECT_TRUE(wait_for(2));
  EXPECT_FALSE(writer->finish(run.engine()));
}

// A session that is killed at any moment, with the processors busy, keeps all bytes that were written. The
// largest loss is printed.
TEST(Session, KilledAtAnyMomentKeepsAllThatWasWritten) {
  const Folder folder;
  Bench bench;
  const char* request_count = std::getenv("TREPHINE_KILLS");
  const int kills = request_count ? std::atoi(request_count) : 25;
  auto* newest = static_cast<std::atomic<std::uint64_t>*>(
      mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(newest, MAP_FAILED);
  std::atomic<std::uint64_t>* const written = newest + 1;
  std::mt19937 random(11);
  std::uint64_t worst = 0, most = 0;
  int replayed = 0, kills_with_bytes = 0;
  for (int k = 0; k < kills; ++k) {
    const std::string path = folder.file(("kill" + std::to_string(k)).c_str());
    newest->store(0), written->store(0);
    const pid_t child = fork();
    if (child == 0) {
      auto writer = bench.writer(path);
      haptics::VirtualDevice device(drilling_path(10), {});
      LiveSession live(device, bench.scene, bench.method, drilling::burr(bench.burr), {}, writer.get());
      const CpuLoad load(3);
      if (live.start()) _exit(1);
      for (;;) {
        written->store(writer->bytes_written());
        newest->store(live.servo_report().ticks);
        std::this_thread::sleep_for(std::chrono::microseconds(500));
      }
    }
    ASSERT_GT(child, 0);
    for (int i = 0; i < 50'000 && newest->load() == 0; ++i)
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    EXPECT_GT(newest->load(), 0u);
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 250'000));
    const std::uint64_t then = newest->load(), bytes_then = written->load();  // before the signal is sent
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    auto opened = SessionReader::open(path, drilling_catalogue());
    ASSERT_TRUE(opened.is_ok()) << opened.error().message();
    const std::uint64_t kept = opened.value().tick_count();
    const std::uint64_t lost = then > kept ? then - kept : 0;
    worst = std::max(worst, lost);
    most = std::max(most, kept);
    EXPECT_GE(opened.value().complete_bytes(), bytes_then);
    kills_with_bytes += bytes_then > 0;
    if (k % 8 == 0) {
      expect_same(replay(path));
      ++replayed;
    }
    fs::remove(path);
  }
  munmap(newest, 4096);
  EXPECT_GT(most, 50u);
  EXPECT_GT(replayed, 0);
  EXPECT_GT(kills_with_bytes, 0);
  RecordProperty("worst_loss_ticks", static_cast<int>(worst));
  std::printf("%d kills: at most %llu ms lost\n", kills, static_cast<unsigned long long>(worst));
}

}  // namespace
}  // namespace trephine::sim
