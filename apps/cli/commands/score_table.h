// Tables of scores as CSV: findings of a session, and sessions of a folder.
#pragma once

#include <string>

#include "apps/cli/rows.h"

namespace trephine::cli {

/// Returns a cell of a CSV file (RFC 4180). Texts that a spreadsheet would take for a formula begin with an
/// apostrophe.
std::string csv_cell(const Json& value);
/// Returns a line per finding of `trephine.score/1`.
std::string csv_of_findings(const Json& findings);
/// Returns a line per session: its number, time and points, and the values of all findings. Findings that a
/// session lacks are empty.
std::string csv_of_sessions(const Json& sessions);

}  // namespace trephine::cli
