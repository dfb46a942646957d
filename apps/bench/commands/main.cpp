// Entry point of trephine-bench.
#include "apps/bench/commands/bench_commands.h"
#include "apps/cli/command_line.h"
#include "haptics/baselines/baselines.h"

int main(int argc, char** argv) {
  namespace bench = trephine::bench;
  static constexpr const trephine::cli::Command* k_commands[] = {
      &bench::k_feel,       &bench::k_stability,  &bench::k_depth,   &bench::k_drill,   &bench::k_step,
      &bench::k_pedicle,    &bench::k_whole_tool, &bench::k_rays,    &bench::k_surface, &bench::k_flood,
      &bench::k_separation, &bench::k_xray,       &bench::k_reslice, &bench::k_render,  &bench::k_load,
      &bench::k_dicom,      &bench::k_open,       &bench::k_skills,  &bench::k_faults,  &bench::k_soak};
  trephine::haptics::baselines::add_methods();
  return trephine::cli::run_program(
      {"trephine-bench",
       "trephine-bench: benchmarks of trephine, together with other libraries in the same run",
       "Examples:\n  trephine-bench feel -o out/ --quick\n  trephine-bench COMMAND --help", k_commands},
      argc, argv);
}
