// The commands of trephine: each registers its own options, and gives what runs once they are known.
#pragma once

#include <functional>
#include <span>

#include "apps/trephine/options.h"
#include "apps/trephine/report.h"

namespace trephine::app {

using Run = std::function<volume::Result<Outcome>()>;

struct Command {
  const char *name, *help, *examples;
  Run (*build)(Options& options);
};

extern const Command k_phantom, k_info, k_import, k_convert, k_mesh, k_touch, k_drill, k_flap, k_laminectomy,
    k_fluoro, k_section, k_slice, k_measure, k_depth_record, k_render, k_view, k_demo, k_run, k_replay,
    k_resume, k_compare, k_timeline, k_modules, k_doctor, k_soak, k_bench, k_audit;

/// Most commands: arguments in a struct with defaults, and a function of them.
template <class Arguments>
Run run_with(std::shared_ptr<Arguments> arguments,
             volume::Result<Outcome> (*run)(const Arguments& arguments)) {
  return [arguments = std::move(arguments), run] { return run(*arguments); };
}

}  // namespace trephine::app
