// Parts of the command bench that have a file of their own.
#pragma once

#include "apps/trephine/commands.h"

namespace trephine::app {

struct BenchArguments {
  std::string what, source, case_source, output, only, export_folder, score, hand;
  int size = 512;
  std::int64_t steps = 1'000'000;
  bool is_quick = false;
};

volume::Status bench_feel(const BenchArguments& arguments, Outcome& outcome);
/// Random attacks, maps and energies; on a scan too when one is given.
volume::Status bench_stability(const BenchArguments& arguments, Outcome& outcome);

/// Touch by depth images.
volume::Status bench_depth(const BenchArguments& arguments, Outcome& outcome);

/// Series found and read, on files that it writes.
volume::Status bench_dicom(const BenchArguments& arguments, Outcome& outcome);

/// Parts of a session.
volume::Status bench_open(const BenchArguments& arguments, Outcome& outcome);

}  // namespace trephine::app
