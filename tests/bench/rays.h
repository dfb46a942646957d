// First hits of rays, beside NanoVDB in one run: the rows behind `trephine bench rays`.
#pragma once

#include <string>
#include <vector>

namespace trephine::bench {

struct RayRow {
  std::string volume;  ///< "sphere", "gyroid", ...
  std::string rays;    ///< "random", or "image": neighbours are alike
  int size = 0;
  long count = 0, hits = 0;
  double one_ns = 0;      ///< a ray
  double peer_ns = 0;     ///< NanoVDB; 0: was not there
  long peer_differs = 0;  ///< rays on which it names another voxel
  long judged = 0;        ///< rays that were walked again in exact arithmetic
  long mismatches = 0;    ///< of these, on which ours named another voxel
};
/// Least of five runs over size^3 voxels.
std::vector<RayRow> run_ray_benchmark(int size);

}  // namespace trephine::bench
