// Plays scripts as simulated persons, and scores their recordings: for benchmarks of the score.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/bench/commands/bench_commands.h"
#include "apps/workbench/script.h"
#include "apps/workbench/session_score.h"

namespace trephine::bench {

/// Plays, records into a temporary file, and scores the recording. Expectations of the script are ignored.
Result<workbench::SessionScore> play_and_score(const data_tools::Script& script, const std::string& folder,
                                               const workbench::Performance& performance);

/// Adds rows of a table, and lines of a CSV file, about a script in a folder.
using ScriptBenchmark = std::function<Status(const data_tools::Script& script, const std::string& folder,
                                             Json& rows, std::string& csv)>;
/// Runs a benchmark on each script and writes the CSV file; `csv` is its first line. Returns the rows.
Result<Json> run_on_scripts(const std::vector<std::string>& scripts, const ScriptBenchmark& benchmark,
                            std::string csv, const std::string& output, data_tools::OutputSet& outputs);

}  // namespace trephine::bench
