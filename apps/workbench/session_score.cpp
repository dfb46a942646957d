#include "apps/workbench/session_score.h"

#include <algorithm>

#include "apps/workbench/findings.h"
#include "apps/workbench/text.h"

namespace trephine::workbench {

namespace {

constexpr std::uint64_t k_between_reports = 1000;  // ticks
constexpr double k_replay = 0.8;                   // share of the work; the rest is judging

Error interrupted() { return {.what = "the score was interrupted", .kind = ErrorKind::interrupted}; }

/// Returns the distance of a hand's tool from the nearest forbidden structure, mm. It is measured where the
/// motion counts as near; a larger distance may be a lower bound.
double watched_clearance(const sim::Engine& engine, std::size_t hand) noexcept {
  static_assert(MotionLimits{}.near <= sim::Forbidden::k_always_measured);
  double nearest = sim::Forbidden::k_reach;
  for (std::size_t i = 0; i < engine.forbidden().size(); ++i)
    nearest = std::min(nearest, engine.watch(hand, i).clearance);
  return nearest;
}

}  // namespace

Result<SessionScore> score_session(OpenedSession& session, std::optional<double> until,
                                   const Listener& listener, const ReplayObserver& observe) {
  sim::Replay& replay = *session.replay;
  const auto end = tick_at(*session.reader, until);
  if (!end) return end.error();
  MotionStats motion(replay.engine().hand_count(), 1 / session.reader->header().rate_hz);
  const auto progress = listener.progress("judging the session");
  if (Status error = replay.seek(0)) return *error;
  // If `until` is set, only the first hand counts in the last tick.
  while (!until || replay.next_tick() < end.value()) {
    const auto stepped = replay.step();
    if (!stepped) return stepped.error();
    if (observe) observe(replay, stepped.value());
    if (!stepped.value()) break;
    const haptics::ServoRecord& record = replay.record();
    motion.add(record, watched_clearance(replay.engine(), record.hand));
    const double share = static_cast<double>(record.tick) / static_cast<double>(end.value());
    if (record.tick % k_between_reports == 0 && !progress(k_replay * share)) return interrupted();
  }
  if (Status error = replay.seek(end.value())) return *error;
  if (const auto& mismatch = replay.mismatch())
    listener.notice(
        format_text("note: the replay differs from the recording at %.3f s; the score is of the replay",
                    static_cast<double>(mismatch->tick) / session.reader->header().rate_hz));
  sim::Engine& engine = replay.engine();
  SessionScore result;
  bool goes_on = true;
  result.score = score_of(
      engine, &motion, [&](double share) { return goes_on = progress(k_replay + (1 - k_replay) * share); });
  if (!goes_on) return interrupted();
  for (std::size_t i = 0; i < motion.hand_count(); ++i) result.motion.push_back(motion.hand(i));
  result.total_motion = motion.total();
  result.seconds = engine.seconds();
  result.is_complete = session.reader->end().has_value() && !session.reader->is_damaged();
  result.is_same = !replay.mismatch();
  return result;
}

Result<sim::Score> score_final_state(OpenedSession& session) {
  const auto end = tick_at(*session.reader, {});
  if (!end) return end.error();
  if (Status error = session.replay->seek(end.value())) return *error;
  return score_of(session.replay->engine(), nullptr);
}

std::string_view verdict_name(const sim::Finding& finding) noexcept {
  switch (finding.verdict) {
    case sim::Finding::Verdict::good:
      return "good";
    case sim::Finding::Verdict::fair:
      return "fair";
    case sim::Finding::Verdict::bad:
      return "bad";
    case sim::Finding::Verdict::not_judged:
      break;
  }
  return finding.value && finding.full_at == finding.zero_at ? "reported" : "not judged";
}

}  // namespace trephine::workbench
