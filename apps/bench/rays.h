// First hits of rays, compared with NanoVDB in one run: rows of `trephine-bench rays`.
#pragma once

#include <string>
#include <vector>

namespace trephine::bench {

struct RayRow {
  std::string volume;  ///< "sphere", "gyroid", ...
  std::string rays;    ///< "random", or "image": neighbours are alike
  int size = 0;
  long count = 0, hits = 0;
  double ns_per_ray = 0;  ///< per ray
  double peer_ns = 0;     ///< NanoVDB; 0: not built in
  long peer_differs = 0;  ///< rays for which the peer finds another first voxel
  long judged = 0;        ///< rays repeated in exact arithmetic
  long mismatches = 0;    ///< judged rays for which our code finds another first voxel
};
/// Least of five runs over size^3 voxels.
std::vector<RayRow> run_ray_benchmark(int size);

}  // namespace trephine::bench
