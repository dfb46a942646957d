// Plays scripts as simulated persons, and scores their recordings: for benchmarks of the score.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/bench/commands/bench_commands.h"
#include "apps/workbench/script.h"
#include "apps/workbench/session_score.h"

namespace trephine::bench {

/// Plays a script, records the operation in a temporary file, and scores the recording. Ignores the
/// expectations of the script. `folder`: of the script.
Result<workbench::SessionScore> play_and_score(const data_tools::Script& script, const std::string& folder,
                                               const workbench::Performance& performance);

/// Runs one script; adds its rows to a table and its lines to a CSV file. `folder`: of the script.
using ScriptBenchmark = std::function<Status(const data_tools::Script& script, const std::string& folder,
                                             Json& rows, std::string& csv)>;
/// Runs a benchmark on each script and writes the CSV file; `csv` is its first line. Returns the rows.
Result<Json> run_on_scripts(const std::vector<std::string>& scripts, const ScriptBenchmark& benchmark,
                            std::string csv, const std::string& output, data_tools::OutputSet& outputs);

}  // namespace trephine::bench
