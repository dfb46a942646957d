// Flood fills and connected components of thresholded voxels, compared with ITK and SciPy. Rows of
// `trephine-bench flood`.
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
  double components_ms = 0, flood_ms = 0;  ///< ours; each includes the thresholding
  long long count = 0, flooded = 0;        ///< number of components; voxels of the flood
  /// Empty: not installed.
  std::optional<double> itk_flood_ms, itk_components_ms, scipy_ms;
  bool is_same = true;  ///< the other libraries find the same numbers
};
/// Cubes of `size` voxels along an edge.
std::vector<FloodRow> run_flood_benchmark(int size);

}  // namespace trephine::bench
