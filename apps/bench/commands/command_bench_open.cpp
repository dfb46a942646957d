// bench open: durations of seeking random ticks of an open session and of scoring the session, and its
// bytes per tick and hand.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <random>

#include "apps/bench/commands/bench_commands.h"
#include "apps/workbench/session_score.h"
#include "modules/drilling/burr.h"
#include "sim/drivers/lockstep.h"

namespace trephine::bench {

using namespace cli;

namespace {
double quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}
/// Returns strokes over the crown of the built-in head for some minutes. In each stroke the hand moves down
/// at a random position, takes random steps along the bone, and moves up again. On average, the burr is on in
/// two of five strokes.
haptics::PosePath long_hand(double minutes) {
  std::mt19937 random(3);
  const auto between = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  std::vector<haptics::PosePath::Sample> samples;
  double t = 0;
  const auto go = [&](const glm::dvec3& place, bool is_on, double seconds) {
    samples.push_back({t, {place, {1, 0, 0, 0}, is_on ? 1u : 0u}});
    t += seconds;
  };
  go({0, 0, 110}, false, 1);
  while (t < 60 * minutes) {
    glm::dvec3 at(between(-15, 15), between(-20, 10), 100);
    go(at, false, 0.5);
    const double depth = between(56, 68);
    const bool is_on = between(0, 1) < 0.4;
    for (int i = static_cast<int>(between(20, 50)); i > 0; --i) {
      at = {at.x + between(-0.6, 0.6), at.y + between(-0.6, 0.6), depth + between(-1, 1)};
      go(at, is_on, 0.1);
    }
    go({at.x, at.y, 100}, false, 0.4);
  }
  return haptics::PosePath::from_samples(std::move(samples), "bench open").value();
}

/// Records a session with the path long_hand(). Returns the removed volume, mm3.
Result<double> record_long_hand(const std::string& file, double burr_diameter, double minutes) {
  drilling::Burr burr;
  burr.diameter = burr_diameter;
  workbench::OperationChoice choice;
  choice.hands[0] = sim::HandSpec(drilling::burr(burr));
  workbench::SourceChoice head("head");
  head.uses_plan = true;
  auto opened = workbench::open_operation(head, choice, terminal_listener());
  if (!opened) return opened.error();
  const workbench::Operation& operation = opened.value();
  auto recorder = workbench::start_recording({file, false, false, program_name()}, operation);
  if (!recorder) return recorder.error();
  const haptics::ServoOptions servo = operation.servo();
  sim::Lockstep run(operation.engine(), servo.force, servo.rate_hz, recorder.value().get());
  const haptics::PosePath hand = long_hand(minutes);
  ProgressLine progress("recording an operation");
  const std::vector<double> times = haptics::servo_times(hand, servo.rate_hz);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (i % 256 == 0 && !progress(static_cast<double>(i) / static_cast<double>(times.size())))
      return interrupted("recording");
    run.step(hand.at(times[i]));
  }
  if (Status error = recorder.value()->finish(run.engine())) return *error;
  return run.engine().removed_mm3();
}

/// A temporary folder, deleted afterwards.
struct TemporaryFolder {
  std::filesystem::path path;
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "trephine-bench-XXXXXX").string();
    if (mkdtemp(name.data())) path = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path.empty()) std::filesystem::remove_all(path, ignored);
  }
};
}  // namespace

Status bench_open(const BenchArguments& arguments, Outcome& outcome) {
  std::string session_file = arguments.source;
  const TemporaryFolder folder;
  if (session_file.empty()) {
    if (folder.path.empty() && arguments.output.empty())
      return Error{.what = "the recording cannot be created",
                   .where = "bench open",
                   .found = "no temporary folder",
                   .expected = "a folder that can be written",
                   .remedy = "set TMPDIR, or pass a session"};
    session_file = arguments.output.empty() ? (folder.path / "long.session").string() : arguments.output;
    constexpr double k_burr = 4;  // mm
    const auto removed = record_long_hand(session_file, k_burr, arguments.minutes);
    if (!removed) return removed.error();
    outcome.json["removed_mm3_total"] = removed.value();
    outcome.print(
        "{minutes} minutes over the built-in head, a burr of {burr} mm, {removed_mm3_total:.0f} mm3 removed",
        {{"burr", k_burr}, {"minutes", arguments.minutes}});
  }
  auto opened = workbench::open_session(session_file, arguments.case_source, terminal_listener());
  if (!opened) return opened.error();
  workbench::OpenedSession& session = *opened.value();
  sim::Replay& replay = *session.replay;
  const sim::SessionReader& reader = *session.reader;
  const std::uint64_t ticks = reader.tick_count();
  if (ticks == 0)
    return Error{.what = "the session is empty",
                 .where = "bench open",
                 .found = "no tick",
                 .expected = "at least one tick",
                 .remedy = "pass a session that was played"};

  std::mt19937_64 random(1);
  std::vector<double> milliseconds;
  std::uint64_t max_played = 0;
  struct {
    double milliseconds = 0;
    std::uint64_t tick = 0, played = 0;
  } slowest;
  constexpr int k_seek_count = 200;
  for (int i = 0; i < k_seek_count; ++i) {
    const std::uint64_t before = replay.counts().ticks, tick = random() % ticks;
    const auto start = Clock::now();
    if (Status error = replay.seek(tick)) return error;
    milliseconds.push_back(1e3 * seconds_since(start));
    const std::uint64_t played = replay.counts().ticks - before;
    max_played = std::max(max_played, played);
    if (milliseconds.back() > slowest.milliseconds) slowest = {milliseconds.back(), tick, played};
  }
  std::sort(milliseconds.begin(), milliseconds.end());

  std::uint64_t all_checkpoint_bytes = 0;
  for (const sim::CheckpointIndex& one : reader.checkpoints()) {
    for (const sim::CheckpointIndex::Link& link : one.links) all_checkpoint_bytes += link.bytes.length;
    all_checkpoint_bytes += one.events.length + one.trails.length + one.history.length + one.rest.length;
  }
  const double hand_ticks = static_cast<double>(ticks) * static_cast<double>(replay.engine().hand_count()),
               checkpoint_bytes_per_tick = static_cast<double>(all_checkpoint_bytes) / hand_ticks,
               log_bytes_per_tick = static_cast<double>(reader.log_bytes()) / hand_ticks;
  outcome.json["ticks"] = ticks;
  outcome.json["checkpoints"] = reader.checkpoints().size();
  outcome.json["opened_by_checkpoint"] = replay.counts().opened_checkpoints;
  outcome.json["most_ticks_played"] = max_played;
  outcome.json["seek_ms"] = {{"count", k_seek_count},
                             {"p50", quantile(milliseconds, 0.5)},
                             {"p99", quantile(milliseconds, 0.99)},
                             {"max", milliseconds.back()}};
  outcome.json["slowest"] = {
      {"ms", slowest.milliseconds}, {"tick", slowest.tick}, {"ticks_played", slowest.played}};
  outcome.json["bytes_per_tick_and_hand"] = {{"log", log_bytes_per_tick},
                                             {"checkpoints", checkpoint_bytes_per_tick}};
  outcome.print(
      "{ticks} ticks, {checkpoints} checkpoints: sought {seek_ms/count} random ticks in p50 "
      "{seek_ms/p50:.1f} ms, p99 {seek_ms/p99:.1f} ms, at most {seek_ms/max:.1f} ms; at most "
      "{most_ticks_played} ticks played");
  outcome.print(
      "bytes per tick and hand: {bytes_per_tick_and_hand/log:.1f} in the log, {bytes_per_tick_and_hand/checkpoints:.1f} in "
      "checkpoints");
  const auto start = Clock::now();
  const auto score = workbench::score_session(session, {}, terminal_listener());
  if (!score) return score.error();
  outcome.json["score_seconds"] = seconds_since(start);
  outcome.print("replayed and scored in {score_seconds:.1f} s");
  return std::nullopt;
}

}  // namespace trephine::bench
