// phantom_plan(): plans of the anatomical phantoms: structures, trajectories and landmarks.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "data-tools/cases/case_folder.h"

namespace trephine::data_tools {

/// Returns the plan of phantom "head" or "spine" with a seed; empty for other names.
std::optional<CasePlan> phantom_plan(const std::string& name, std::uint64_t seed = 1);

}  // namespace trephine::data_tools
