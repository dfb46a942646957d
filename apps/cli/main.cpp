// The trephine command.
#include "apps/cli/command_line.h"
#include "haptics/baselines/baselines.h"

int main(int argc, char** argv) {
  using namespace trephine::cli;
  static constexpr const Command* k_commands[] = {
      &k_phantom,        &k_info,    &k_import,       &k_convert, &k_mesh,    &k_touch,
      &k_drill,          &k_flap,    &k_laminectomy,  &k_screw,   &k_fluoro,  &k_section,
      &k_slice,          &k_measure, &k_depth_record, &k_render,  &k_view,    &k_simulator,
      &k_demo,           &k_run,     &k_procedure,    &k_replay,  &k_resume,  &k_timeline,
      &k_explain,        &k_score,   &k_report,       &k_export,  &k_compare, &k_compare_forces,
      &k_virtual_device, &k_modules, &k_doctor,       &k_audit};
  trephine::haptics::baselines::add_methods();  // for --method, and for sessions recorded with them
  return run_program(
      {"trephine", "trephine: surgical simulation on real CT and MR scans, with haptic contact",
       "Examples:\n  trephine demo\n  trephine simulator\n  trephine info SCANS/HEAD\n  trephine view SCANS/HEAD\n"
       "  trephine COMMAND --help",
       k_commands},
      argc, argv);
}
