// Slices of a volume, compared with those of VTK in one run: rows of `trephine-bench reslice`.
#pragma once

#include <string>
#include <vector>

namespace trephine::bench {

struct ResliceRow {
  std::string plane;
  int threads = 1;
  double our_ms = 0, peer_ms = 0;  ///< least of several runs
  int worst_difference = 0;  ///< largest difference of intensity, over pixels that both place in the volume
};
/// Measures slices of 1024^2 pixels, interpolated linearly, of a volume of size^3 voxels: axis-aligned and
/// oblique planes through its middle.
std::vector<ResliceRow> run_reslice_benchmark(int size);

}  // namespace trephine::bench
