// Commands of trephine-bench, and the functions of benchmarks that have a source file each.
#pragma once

#include "apps/bench/measure.h"
#include "apps/cli/commands.h"

namespace trephine::bench {

using namespace cli;

struct BenchArguments {
  std::string source, case_source, output, only, export_folder, results, hand;
  std::vector<std::string> methods;
  int size = 512;
  std::int64_t steps = 1'000'000;
  double minutes = 10;  ///< of a recorded operation
  bool is_quick = false;
};

inline Json to_json(const StepTimes& t) {
  return {{"count", t.count}, {"p50", t.p50}, {"p99", t.p99}, {"p999", t.p999}, {"max", t.max}};
}

extern const cli::Command k_surface, k_flood, k_separation, k_step, k_rays, k_xray, k_reslice, k_render,
    k_drill, k_load, k_dicom, k_open, k_depth, k_feel, k_stability, k_skills, k_faults, k_soak, k_pedicle,
    k_whole_tool;

Status bench_feel(const BenchArguments& arguments, Outcome& outcome);
/// Random attacks, stiffness maps and energies; on a scan too if one is given.
Status bench_stability(const BenchArguments& arguments, Outcome& outcome);

/// Touch by depth images.
Status bench_depth(const BenchArguments& arguments, Outcome& outcome);

/// Finding and reading DICOM series, on files written by the benchmark.
Status bench_dicom(const BenchArguments& arguments, Outcome& outcome);

/// Opening a session at random ticks, and its size.
Status bench_open(const BenchArguments& arguments, Outcome& outcome);

}  // namespace trephine::bench
