// OpenedCase: a scan with its structures, materials and plan, in a folder of files in open formats.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "data-tools/cases/case_plan.h"
#include "data-tools/formats/open_volume.h"
#include "volume/surface/surface_nets.h"

namespace trephine::data_tools {

/// A case with its scan.
struct OpenedCase {
  CasePlan plan;
  OpenedVolume scan;
};

/// Two volumes have the same position if no two corresponding corners are farther apart than this.
inline constexpr double k_same_position_mm = 0.01;

/// Surface of a model that write_case() writes to a file.
struct CaseSurface {
  std::string file;   ///< name of the model's file in the folder
  volume::Mesh mesh;  ///< in the volume frame of `frame`
  volume::Frame frame;
};

/// Returns true if the folder contains case.toml.
bool is_case_folder(const std::string& path);
/// Reads the plan, its procedure, the scan, its labels and shape.mha; checks that the files of models and of
/// further volumes exist. Errors about unknown keys, wrong types and impossible values state the line.
Result<OpenedCase> open_case(const std::string& path, const OpenOptions& options = {});
/// Writes volume.mha, labels.mha (if there are labels), shape.mha (if the shape differs from the scan),
/// case.toml and the file of the procedure (unless it is a shipped one) into a new folder, atomically. Writes
/// the models in `surfaces`, and copies the files of other models and of further volumes. Error if the folder
/// exists. `progress` may cancel.
Status write_case(const std::string& path, const CasePlan& plan, const volume::Volume& scan,
                  const Progress& progress = {}, std::span<const CaseSurface> surfaces = {});

}  // namespace trephine::data_tools
