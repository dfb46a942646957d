// Findings as text, for pages and windows.
#pragma once

#include <string>

#include "sim/api/finding.h"

namespace trephine::workbench {

/// Returns the value with its unit, "4.14 mm"; a dash if the finding has no value.
std::string value_text(const sim::Finding& finding);
/// Returns "full at 2, none at 10"; empty without limits.
std::string limits_text(const sim::Finding& finding);
/// Returns the points of a finding, "1.7 of 2", or a dash instead of the points if it has no value. Empty if
/// the weight of the finding is 0.
std::string points_text(const sim::Finding& finding);
/// Returns the points of a score, "12.0 of 14.0 points", or "no points: nothing was judged".
std::string points_of(const sim::Score& score);
/// Returns "critical: dura: torn 2 (at most 0 for full points); L4: canal gained 0 % (at least 80 for full
/// points)"; empty without critical findings.
std::string critical_text(const sim::Score& score);
/// True for a finding with a value but without limits, which has no verdict.
bool is_only_reported(const sim::Finding& finding) noexcept;

}  // namespace trephine::workbench
