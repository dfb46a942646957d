// Floods and components compared with ITK and SciPy, starting from voxels.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace trephine::bench {

struct FloodRow {
  std::string volume;  ///< "shell", "gyroid", "noise"
  bool has_corners = false;
  int threads = 1;
  double components_ms = 0, flood_ms = 0;  ///< ours: each with the threshold
  long long count = 0, flooded = 0;        ///< components; voxels of the flood
  /// Empty: not installed.
  std::optional<double> itk_flood_ms, itk_components_ms, scipy_ms;
  bool is_same = true;  ///< numbers of components and voxels equal theirs
};
/// Cubes of `size` voxels along an edge.
std::vector<FloodRow> run_flood_benchmark(int size);

}  // namespace trephine::bench
