// Report of `trephine bench feel` in its folder: tables, charts and a page.
#pragma once

#include <string>

#include "apps/trephine/report.h"
#include "tests/bench/feel.h"

namespace trephine::app {

/// feel.csv, feel.json, PNG pictures and index.html. `is_quick` is said on the page.
volume::Status write_feel_report(const bench::FeelReport& report, const std::string& folder, bool is_quick,
                                 const Json& machine);

/// Peers that were played, with their versions; and where the time of an explicit step goes.
Json feel_peers(const bench::FeelReport& report);
Json feel_split(const bench::FeelReport& report);
/// The rows as JSON, as in feel.json.
Json feel_rows(const bench::FeelReport& report);
/// A few lines for the terminal: a method a line, over the smooth scenes.
std::string feel_summary(const bench::FeelReport& report);

}  // namespace trephine::app
