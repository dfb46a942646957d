// Slices of a volume, compared with VTK's in one run: rows of `trephine-bench reslice`.
#pragma once

#include <string>
#include <vector>

namespace trephine::bench {

struct ResliceRow {
  std::string plane;
  int threads = 1;
  double our_ms = 0, peer_ms = 0;  ///< least of several runs
  int worst_difference = 0;        ///< grey levels, where both are inside
};
/// 1024^2 pixels, linear, of size^3 voxels: straight and oblique planes through the middle.
std::vector<ResliceRow> run_reslice_benchmark(int size);

}  // namespace trephine::bench
