// Anatomical phantoms as cases: what is touched, what must not be cut, where to go.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "data-tools/case_folder.h"

namespace trephine::data_tools {

/// Plan of "head" and "spine", made with that seed; empty for others.
std::optional<CasePlan> phantom_plan(const std::string& name, std::uint64_t seed = 1);

}  // namespace trephine::data_tools
