// Window of an operation: opens a scan, records the operation, and shows the window until it is
// closed.
#pragma once

#include "apps/cli/commands.h"
#include "apps/cli/options/burr_options.h"
#include "apps/cli/options/display_options.h"
#include "apps/cli/options/model_options.h"

namespace trephine::cli {

struct WindowArguments {
  workbench::SourceChoice source = "head";
  std::string screenshot, side, procedure;
  workbench::ShapeChoice shape;
  drilling::Burr burr;
  ModelArguments models;
  std::optional<double> smallest_burr;  ///< mm
  std::optional<double> seconds;
  workbench::DeviceChoice device;
  workbench::RecordChoice record;
  std::vector<std::string> effects;    ///< name and parameters of each
  std::vector<std::string> opacities;  ///< NAME=PERCENT of structures
  DisplayArguments display;
  bool has_no_autosave = false;
};

/// Runs the window and returns its report. `name`: command, for the schema of the report.
Result<Outcome> run_operation_window(const WindowArguments& arguments, const char* name);

}  // namespace trephine::cli
