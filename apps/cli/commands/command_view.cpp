// view: opens a window to touch and cut with the mouse.
#include "apps/cli/commands.h"
#include "apps/cli/commands/operation_window.h"
#include "data-tools/cases/procedure_file.h"

namespace trephine::cli {

namespace {

Result<Outcome> run_view(const WindowArguments& arguments) { return run_operation_window(arguments, "view"); }

Run build_view(Options& options) {
  auto a = std::make_shared<WindowArguments>();
  add_source(options, a->source);
  add_shape(options, a->shape);
  add_burr(options, a->burr).shows_default();
  options
      .add("--smallest-burr", a->smallest_burr,
           "Smallest burr that can be chosen in the window, mm: the smaller, the finer cuts are sampled "
           "(default: 2, or the burr if that is smaller)")
      .type("MM");
  add_models(options, a->models);
  add_effects(options, a->effects);
  options
      .add("--background", a->models.backgrounds,
           "A model, closed or open, that is touched by its depth on the screen; may be repeated")
      .type("MODEL");
  options
      .add("--procedure", a->procedure,
           "Steps of the operation, instead of those of a case: " + data_tools::shipped_names() +
               ", or a file NAME.toml")
      .type("NAME");
  add_side(options, a->side);
  options
      .add("--opacity", a->opacities,
           "Show a structure with this opacity, 0 hidden to 100 opaque; bone is named bone; may be repeated")
      .type("NAME=PERCENT");
  add_display(options, a->display);
  options.add("--screenshot", a->screenshot, "Write a picture; without --seconds no window is opened")
      .type("OUT.png");
  options.add("--seconds", a->seconds, "Close the window after this time").type("S");
  add_devices(options, a->device);
  add_record(options, a->record);
  options.add("--no-autosave", a->has_no_autosave, "Do not keep the session in ~/.local/state/trephine");
  options.add_modules();
  return run_with(a, run_view);
}

}  // namespace

const Command k_view{"view", "Open a window to touch and drill with the mouse",
                     "  trephine view SCANS/HEAD\n  trephine view head --screenshot head.png", build_view};

}  // namespace trephine::cli
