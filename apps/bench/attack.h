// Random attack: random motion at all speeds over every kind of touchable scene, with each step judged for
// fall-through. Rows of `trephine-bench stability`.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "haptics/proxy/proxy_step.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::bench {

/// Result of one method on one scene: random motion, with cuts and undos at the tool. Each step is judged.
struct AttackRow {
  std::string method, scene;
  long steps = 0, contacts = 0, fall_throughs = 0, buried = 0, not_finite = 0;
  /// For scenes with an analytic shape: `judged_by_shape` is the number of contacts that were compared with
  /// the shape minus the cuts, by code that uses neither samples nor triangles. `too_deep` is the number of
  /// these in which the tool was in matter by more than 1.5 times the longest voxel side.
  long too_deep = 0, judged_by_shape = 0;
  long undos = 0;  ///< number of undos of all cuts under the tool
  double fastest_mm_s = 0;
};
struct AttackOptions {
  long steps = 1'000'000;  ///< in total, without those of whole tools
  std::uint64_t seed = 1;
  std::vector<std::pair<std::string, haptics::TouchScene>> more;  ///< named scenes, such as scans
  std::vector<std::string> methods;                               ///< empty: all that guarantee a solid
  /// Called after each step with the HIP (volume and world frame); may replace the step by that of a faulty
  /// method.
  std::function<void(haptics::ProxyStep& step, const glm::dvec3& hip_volume, const glm::dvec3& hip_world)>
      spoil;
  std::function<bool(double)> progress;  ///< fraction done; returning false stops
};
std::vector<AttackRow> run_attack(const AttackOptions& options);

/// Returns a phantom in 64^3 sheared voxels. If `slice` is not 1, the voxels are smaller, and `slice` times
/// as thick as wide. Shapes with only two values near their surface are smoothed (haptics::soften()).
haptics::TouchScene attack_scene(const std::string& phantom, double psf, bool is_binary = false,
                                 bool is_noisy = false, std::map<std::string, double> parameters = {},
                                 double slice = 1);

}  // namespace trephine::bench
