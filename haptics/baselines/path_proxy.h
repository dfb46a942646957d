// PathProxy: contact with voxel cubes as walls, and a path search around their corners.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics::baselines {

/// The motion to the HIP is traversed exactly; from where a wall stops it, A* over the free voxels finds the
/// voxel nearest to the HIP's projection on the wall's plane, within `k_depth` voxels of that plane; the
/// proxy moves to the point of that voxel's boundary toward the HIP, if that is nearer than where it was
/// stopped (Jiang, dissertation "A Surface-based Volume Haptics Approach", 3.4.1.2). This leads around
/// stair-steps at which ray casts stop. The search is bounded, and so is the step.
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
