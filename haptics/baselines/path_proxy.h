// PathProxy: contact with voxel cubes as walls, and a path search around their corners.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics::baselines {

/// Traverses the motion to the HIP exactly. If a wall stops the motion, A* starts there, over the free voxels
/// within `k_depth` voxels of the wall's plane, and finds the voxel nearest to the HIP's projection on that
/// plane. The proxy moves to the point of this voxel's boundary in the direction of the HIP, if that point is
/// nearer to the HIP than the point at which the wall stopped the motion (Jiang, dissertation "A
/// Surface-based Volume Haptics Approach", 3.4.1.2). The path leads around stair-steps of voxels, at which
/// ray casts stop. The search is bounded, and so is the step.
class PathProxy final : public ProxyMethod {
 public:
  static constexpr double k_depth = 2;  ///< t_depth, voxels
  static constexpr MethodInfo k_info{
      .name = "path",
      .meaning = "voxel cubes as walls, A* around their corners",
      .source = "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.1.2",
      .solid = MethodInfo::Solid::cubes,
      .takes_ball = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;
};

}  // namespace trephine::haptics::baselines
