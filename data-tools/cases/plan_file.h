// PlanFile: trajectories and landmarks from 3D Slicer's .mrk.json and from tables (.csv, .fcsv).
#pragma once

#include <string>
#include <vector>

#include "data-tools/cases/case_folder.h"

namespace trephine::data_tools {

/// Contents of a plan file, world frame (LPS, mm).
struct PlanFile {
  std::vector<volume::PlannedTrajectory> trajectories;
  std::vector<volume::PlannedLandmark> landmarks;
  std::vector<std::string> notices;
};

/// Reads a plan; points are converted from the file's frame, LPS or RAS, to LPS. A line markup is a
/// trajectory from its first to its second point. Points without a position are skipped with a notice. Error
/// if markups or a .fcsv file state no frame, a frame is unknown, or a table lacks the columns of positions.
Result<PlanFile> read_plan(const std::string& path);

}  // namespace trephine::data_tools
