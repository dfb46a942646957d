// Scores as JSON, text and CSV: findings of a session, and sessions of a folder.
#pragma once

#include <string>

#include "apps/cli/rows.h"
#include "apps/workbench/session_score.h"

namespace trephine::cli {

/// Returns the rows of `trephine.score/1`. `dt`: period of the session's ticks, s.
Json json_of_score(const workbench::SessionScore& score, double dt);
/// Prints these rows: a table of findings, the sum of points, critical findings, defects of the recording,
/// and the reasons of findings.
void print_score(const Json& score, Rows& rows);

/// Returns a cell of a CSV file (RFC 4180). An apostrophe precedes texts that a spreadsheet would interpret
/// as formulas.
std::string csv_cell(const Json& value);
/// Returns a CSV table of the findings of json_of_score(), a line per finding.
std::string csv_of_findings(const Json& findings);
/// Returns a CSV table with a line per session: its number, time, points, state of the recording and error,
/// and the values of all findings. Cells of findings that a session lacks are empty.
std::string csv_of_sessions(const Json& sessions);

}  // namespace trephine::cli
