// bench open: how long until a recorded session stands at any of its ticks, and what a tick takes in its
// file.
#include <algorithm>
#include <filesystem>
#include <random>

#include "apps/trephine/bench_parts.h"
#include "apps/trephine/recording.h"
#include "apps/trephine/text.h"

namespace trephine::app {

namespace {
double part_of(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}
}  // namespace

volume::Status bench_open(const BenchArguments& arguments, Outcome& outcome) {
  if (arguments.source.empty())
    return volume::Error{"there is no session to open", "bench open", "", "a session", ""};
  auto opened = open_session(arguments.source, arguments.case_source);
  if (!opened) return opened.error();
  OpenedSession& session = *opened.value();
  sim::Replay& replay = *session.replay;
  const sim::SessionReader& reader = *session.reader;
  const std::uint64_t ticks = reader.tick_count();
  if (ticks == 0) return volume::Error{"the session is empty", "bench open", "no tick", "some", ""};

  std::mt19937_64 random(1);
  std::vector<double> milliseconds;
  std::uint64_t most_played = 0;
  constexpr int k_places = 200;
  for (int i = 0; i < k_places; ++i) {
    const std::uint64_t before = replay.counts().ticks;
    const auto start = Clock::now();
    if (volume::Status error = replay.seek(random() % ticks)) return error;
    milliseconds.push_back(1e3 * seconds_since(start));
    most_played = std::max(most_played, replay.counts().ticks - before);
  }
  std::sort(milliseconds.begin(), milliseconds.end());

  std::uint64_t of_checkpoints = 0;
  for (const sim::CheckpointIndex& one : reader.checkpoints()) {
    for (const sim::CheckpointIndex::Link& link : one.links) of_checkpoints += link.bytes.length;
    of_checkpoints += one.events.length + one.trails.length + one.history.length + one.rest.length;
  }
  const double per_tick = static_cast<double>(ticks) * static_cast<double>(replay.engine().hand_count()),
               checkpoint_bytes = static_cast<double>(of_checkpoints) / per_tick,
               log_bytes = static_cast<double>(reader.log_bytes()) / per_tick;
  outcome.json["ticks"] = ticks;
  outcome.json["checkpoints"] = reader.checkpoints().size();
  outcome.json["opened_by_checkpoint"] = replay.counts().opened;
  outcome.json["most_ticks_played"] = most_played;
  outcome.json["open_ms"] = {{"count", k_places},
                             {"p50", part_of(milliseconds, 0.5)},
                             {"p99", part_of(milliseconds, 0.99)},
                             {"max", milliseconds.back()}};
  outcome.json["bytes_a_tick"] = {{"log", log_bytes}, {"checkpoints", checkpoint_bytes}};
  outcome.text = format_text(
      "%llu ticks, %zu checkpoints: open at %d ticks by chance in p50 %.1f ms, p99 %.1f ms, at most %.1f ms; "
      "at "
      "most %llu ticks played\n"
      "%.1f bytes a tick and hand, and %.1f of checkpoints\n",
      static_cast<unsigned long long>(ticks), reader.checkpoints().size(), k_places,
      part_of(milliseconds, 0.5), part_of(milliseconds, 0.99), milliseconds.back(),
      static_cast<unsigned long long>(most_played), log_bytes, checkpoint_bytes);
  return std::nullopt;
}

}  // namespace trephine::app
