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

/// One method on one scene under random motion, drilled and undone under the tool; each step is judged.
struct AttackRow {
  std::string method, scene;
  long steps = 0, contacts = 0, fall_throughs = 0, buried = 0, not_finite = 0;
  /// For scenes with an analytic shape: contacts deeper than 1.5 times the longest voxel side in this shape
  /// minus the cuts, by code that uses neither samples nor triangles; and the number of contacts judged so.
  long too_deep = 0, judged_by_shape = 0;
  long undos = 0;  ///< number of undos of all cuts under the tool
  double fastest_mm_s = 0;
};
struct AttackOptions {
  long steps = 1'000'000;  ///< in total, without those of whole tools
  std::uint64_t seed = 1;
  std::vector<std::pair<std::string, haptics::TouchScene>> more;  ///< scans
  std::vector<std::string> methods;                               ///< empty: all that guarantee a solid
  /// Called after each step with the HIP (volume and world frame); may replace the step by that of a faulty
  /// method.
  std::function<void(haptics::ProxyStep& step, const glm::dvec3& hip_volume, const glm::dvec3& hip_world)>
      spoil;
  std::function<bool(double)> progress;
};
std::vector<AttackRow> run_attack(const AttackOptions& options);

/// A phantom in 64^3 sheared voxels, or, if `slice` is not 1, in smaller voxels with slices `slice` times as
/// thick; softened if it is binary.
haptics::TouchScene attack_scene(const std::string& phantom, double psf, bool is_binary = false,
                                 bool is_noisy = false, std::map<std::string, double> parameters = {},
                                 double slice = 1);

}  // namespace trephine::bench
