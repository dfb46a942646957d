// Scores of all sessions of a folder (a course), for a table or a page with learning curves.
#pragma once

#include <string>
#include <vector>

#include "apps/workbench/session_score.h"

namespace trephine::workbench {

/// A session of a folder, without the name of its file, which may identify a patient.
struct CourseSession {
  std::string title;                  ///< title of its procedure; empty: no title
  std::string date;                   ///< day on which its file was last changed, "2026-11-27" (UTC)
  double dt = 0;                      ///< s, period of its ticks
  std::optional<SessionScore> score;  ///< empty: see `error`
  std::string error;                  ///< reason why there is no score
};

/// Scores the sessions of a folder, in the order of the names of their files. `case_source`: scan of sessions
/// that lack it. Error: the folder has no sessions, or work was stopped by the listener.
Result<std::vector<CourseSession>> score_course(const std::string& folder, const SourceChoice& case_source,
                                                const Listener& listener = {});

/// Returns the day on which a file was last changed, "2026-11-27" (UTC); empty if it cannot be read.
std::string date_of_file(const std::string& path);

}  // namespace trephine::workbench
