// Report of `trephine-bench feel` in a folder: tables, charts and a page.
#pragma once

#include <string>

#include "apps/bench/feel.h"
#include "apps/cli/report.h"

namespace trephine::bench {

using namespace cli;

/// Writes feel.csv, feel.json, PNG pictures and index.html. `is_quick` is noted on the page.
Status write_feel_report(const bench::FeelReport& report, const std::string& folder, bool is_quick,
                         const Json& machine);

/// Returns the peers that were played, with their versions.
Json feel_peers(const bench::FeelReport& report);
/// Returns the parts of the time of a step of method `explicit`.
Json feel_split(const bench::FeelReport& report);
/// The rows as JSON, as in feel.json.
Json feel_rows(const bench::FeelReport& report);
/// Adds a table as text: a line per method, with medians over the scenes of the group "smooth" (over all
/// scenes if no scene is in this group), and the numbers of falls and stuck steps in all scenes.
void print_feel_summary(const bench::FeelReport& report, Rows& rows);

}  // namespace trephine::bench
