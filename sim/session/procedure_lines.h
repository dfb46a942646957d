// Lines of a header for the procedure and the score of a plan. Included by session_header.cpp only.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "volume/scan/surgical_plan.h"

namespace trephine::sim {

/// Adds the lines of procedure and score. An empty procedure or score adds no lines. The first line of a
/// step, transition or condition names the step, the next step or the measurement; its other lines follow.
void add_procedure_lines(std::string& out, const volume::SurgicalPlan& plan);
/// Reads a line. Returns nullopt if the key does not belong to a procedure or score; false if the value is
/// invalid, or if the line is not preceded by the first line of its object.
std::optional<bool> read_procedure_line(std::string_view key, std::string_view value,
                                        volume::SurgicalPlan& plan);

}  // namespace trephine::sim
