// SessionScore: score of a recorded session, and the motion of its hands, from a replay.
#pragma once

#include <functional>
#include <optional>

#include "apps/workbench/motion_stats.h"
#include "apps/workbench/sessions.h"
#include "sim/api/finding.h"

namespace trephine::workbench {

struct SessionScore {
  sim::Score score;                ///< findings in a constant order, with verdicts and points
  std::vector<HandMotion> motion;  ///< one per hand
  HandMotion total_motion;         ///< of all hands together
  double seconds = 0;              ///< time of the judged state in the session
  bool is_complete = true;         ///< false: the recording was interrupted, or the file is damaged
  bool is_same = true;  ///< false: the replay differs from the recording; the score is of the replay
};

/// Receives the replay after each tick of each hand. If the whole session is replayed (`until` is empty), it
/// is called once more at the end, with `is_tick` false, after the commands that follow the last tick.
using ReplayObserver = std::function<void(sim::Replay& replay, bool is_tick)>;

/// Replays a session from its start to `until` (s; empty: end of the session) and judges the state there. The
/// replay stays at this time. Error if the session does not contain the time, or the listener stops the work.
Result<SessionScore> score_session(OpenedSession& session, std::optional<double> until = {},
                                   const Listener& listener = {}, const ReplayObserver& observe = {});

/// Judges the end of a session from its last checkpoint, without the motion of the hands and without
/// verifying the recording. The replay stays at the end.
Result<sim::Score> score_final_state(OpenedSession& session);

/// Returns the name of a verdict: "good", "fair", "bad", "not judged", or "reported" for a finding without
/// limits.
std::string_view verdict_name(const sim::Finding& finding) noexcept;

}  // namespace trephine::workbench
