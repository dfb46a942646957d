// Random motion at all speeds over everything that can be touched, every step judged: nothing falls through.
// Rows behind `trephine bench stability`.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "haptics/proxy/proxy_method.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::bench {

/// One method on one scene under random motion, drilled and undone under the tool; every step judged.
struct AttackRow {
  std::string method, scene;
  long steps = 0, contacts = 0, fall_throughs = 0, buried = 0, not_finite = 0;
  /// In contact deep in the analytic shape less what was cut, by code that knows neither samples nor
  /// triangles: by more than 1.5 of the longest sides of a voxel. Where the scene has such a shape.
  long sunk = 0, judged_by_shape = 0;
  long undos = 0;  ///< times that all that was cut came back under the tool
  double fastest_mm_s = 0;
};
struct AttackOptions {
  long steps = 1'000'000;  ///< in all
  std::uint64_t seed = 1;
  std::vector<std::pair<std::string, haptics::TouchScene>> more;  ///< scans
  std::vector<std::string> methods;                               ///< empty: all that promise a solid
  /// Called after each step, with the HIP (volume frame): what a faulty method would have answered.
  std::function<void(haptics::ProxyStep& step, const glm::dvec3& hip_volume, const glm::dvec3& hip_world)>
      spoil;
  std::function<bool(double)> progress;
};
std::vector<AttackRow> run_attack(const AttackOptions& options);

/// A phantom of 64^3 sheared voxels, or of slices so many times as thick; softened where it is binary.
haptics::TouchScene attack_scene(const std::string& phantom, double psf, bool is_binary = false,
                                 bool is_noisy = false, std::map<std::string, double> parameters = {},
                                 double slice = 1);

}  // namespace trephine::bench
