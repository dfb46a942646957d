// Plays a script as a simulated person, and scores its recording.
#pragma once

#include <map>
#include <string>

#include "apps/workbench/script.h"
#include "apps/workbench/session_score.h"

namespace trephine::bench {

/// Plays, records into a temporary file, and scores the recording. Expectations of the script are ignored.
Result<workbench::SessionScore> play_and_score(const data_tools::Script& script, const std::string& folder,
                                               const workbench::Performance& performance);

/// Returns the points of all findings with limits, by their names.
std::map<std::string, double> points_of(const sim::Score& score);

}  // namespace trephine::bench
