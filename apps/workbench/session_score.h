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
  HandMotion total_motion;         ///< of all hands
  double seconds = 0;              ///< time of the judged state in the session
  bool is_complete = true;         ///< false: the recording was interrupted, or the file is damaged
  bool is_same = true;  ///< false: the replay differs from the recording; the score is of the replay
};

/// Receives the replay after each tick, and after the commands that follow the last one (`is_tick` false).
using ReplayObserver = std::function<void(sim::Replay& replay, bool is_tick)>;

/// Replays a session from its start to `until` (s; empty: its end) and judges the final state. The session
/// stays there. Error if the session does not contain this time, or work was stopped by the listener.
Result<SessionScore> score_session(OpenedSession& session, std::optional<double> until = {},
                                   const Listener& listener = {}, const ReplayObserver& observe = {});

/// Returns the name of a verdict: "good", "fair", "bad", "not judged", or "reported" for a finding without
/// limits.
std::string_view verdict_name(const sim::Finding& finding) noexcept;

}  // namespace trephine::workbench
