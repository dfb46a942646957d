// Lines of a header for the procedure and the score of a plan. Included by session_header.cpp only.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "volume/scan/surgical_plan.h"

namespace trephine::sim {

/// Adds the lines of procedure and score; an empty one has no lines. The lines of a step, transition or
/// condition follow that of its name.
void add_procedure_lines(std::string& out, const volume::SurgicalPlan& plan);
/// Reads a line. Returns nullopt if the key is not of a procedure or score; false if the value is invalid or
/// the line does not follow that of its object.
std::optional<bool> read_procedure_line(std::string_view key, std::string_view value,
                                        volume::SurgicalPlan& plan);

}  // namespace trephine::sim
