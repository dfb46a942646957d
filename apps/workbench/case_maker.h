// Makes a case of an open scan, with the name, plan and forbidden structures that a user entered in the
// window.
#pragma once

#include <string>
#include <vector>

#include "data-tools/cases/case_plan.h"
#include "data-tools/files/progress.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::workbench {

struct CaseRequest {
  std::string name;                    ///< name of the case; it must not be that of a patient
  volume::SurgicalPlan plan;           ///< trajectories, landmarks, outlines, targets, procedure, limits
  std::vector<std::string> forbidden;  ///< names of labels that a tool must not enter
  std::vector<data_tools::CaseModel> models;  ///< of an open case, with the paths of their files
};

/// Returns the plan of the case: the touched shapes of the scene's scan as structures, the forbidden labels,
/// and the request with its models. Error if the name is empty, a label is unknown, a position is outside the
/// scan, two marks have the same name, a structure is both forbidden and a target, or an object or a limit of
/// the plan is invalid.
Result<data_tools::CasePlan> case_plan_of(const CaseRequest& request, const haptics::TouchScene& scene);

/// Writes the case with its scan into a new folder, completely or not at all. Errors are those of
/// case_plan_of(), and a folder that exists already. `progress` can cancel.
Status write_case_of(const CaseRequest& request, const haptics::TouchScene& scene, const std::string& folder,
                     const data_tools::Progress& progress = {});

}  // namespace trephine::workbench
