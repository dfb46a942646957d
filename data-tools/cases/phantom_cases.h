// phantom_plan(): plans of the anatomical phantoms: structures, trajectories and landmarks.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "data-tools/cases/case_folder.h"

namespace trephine::data_tools {

/// Returns the plan of phantom "head" or "spine" with a seed; empty for other names. `approach`: surgical
/// approach to a head, as in PhantomOptions; an unknown approach counts as "vault".
std::optional<CasePlan> phantom_plan(const std::string& name, std::uint64_t seed = 1,
                                     const std::string& approach = "");

/// Plan of a case, and the surfaces of its models.
struct PhantomCase {
  CasePlan plan;
  std::vector<CaseSurface> surfaces;
};
/// Returns the case of a phantom. In the spine case, discs, dural sac and nerve roots are models. Their
/// labels remain in the scan but are not structures of the plan, so that no structure is counted twice.
std::optional<PhantomCase> phantom_case(const std::string& name, std::uint64_t seed = 1,
                                        const std::string& approach = "");

}  // namespace trephine::data_tools
