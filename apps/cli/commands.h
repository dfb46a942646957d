// Command: a command of trephine; registers its options and returns the function that runs it.
#pragma once

#include <functional>
#include <span>

#include "apps/cli/options/options.h"
#include "apps/cli/report.h"

namespace trephine::cli {

using Run = std::function<Result<Outcome>()>;

struct Command {
  const char *name, *help, *examples;
  Run (*build)(Options& options);
};

extern const Command k_phantom, k_info, k_import, k_convert, k_mesh, k_touch, k_drill, k_flap, k_laminectomy,
    k_screw, k_score, k_report, k_fluoro, k_section, k_slice, k_measure, k_depth_record, k_render, k_view,
    k_simulator, k_demo, k_run, k_replay, k_resume, k_compare, k_compare_forces, k_timeline, k_explain,
    k_export, k_modules, k_procedure, k_doctor, k_audit, k_virtual_device;

/// Returns the run function of a command whose arguments are a struct with defaults.
template <class Arguments>
Run run_with(std::shared_ptr<Arguments> arguments, Result<Outcome> (*run)(const Arguments& arguments)) {
  return [arguments = std::move(arguments), run] { return run(*arguments); };
}

}  // namespace trephine::cli
