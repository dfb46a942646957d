// Trajectories and landmarks that were planned elsewhere: 3D Slicer's .mrk.json, tables (.csv, .fcsv).
#pragma once

#include <string>
#include <vector>

#include "data-tools/case_folder.h"

namespace trephine::data_tools {

struct PlanFile {
  std::vector<CaseTrajectory> trajectories;
  std::vector<CaseLandmark> landmarks;
  std::vector<std::string> notices;
};

/// Points come in the file's own frame, LPS or RAS. A markup's line is a trajectory from its first point to
/// its second; what is not placed is passed over with a notice. Error when the frame is not given, and in a
/// table of unknown columns.
volume::Result<PlanFile> read_plan(const std::string& path);

}  // namespace trephine::data_tools
