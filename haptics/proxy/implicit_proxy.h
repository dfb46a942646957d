// ImplicitProxy: contact with voxel cubes as walls and interpolated gradients as normals.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// Iterative collision detection on voxel cubes. The motion to the HIP is traversed exactly. At each crossing
/// the HIP is projected on the plane through the crossing with the interpolated normal, and the motion
/// continues toward the projection. All points reached are candidates, and the candidate nearest to the HIP
/// is the new proxy (iterative ray casting with candidate trimming, after Jiang, dissertation, 3.4.1.1). The
/// proxy never enters a solid voxel, because every leg of its path is traversed. Cost: 0.1 to 0.5 us per step
/// in contact, independent of the volume's size.
class ImplicitProxy final : public ProxyMethod {
 public:
  /// `iterations`: collision queries per step, 1 to k_max_iterations.
  explicit ImplicitProxy(int iterations = 3) noexcept;

  static constexpr MethodInfo k_info{
      .name = "implicit",
      .meaning = "voxel cubes as walls, iterated ray casts",
      .source = "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.1.1",
      .solid = MethodInfo::Solid::cubes,
      .takes_ball = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  int iterations_;
};

}  // namespace trephine::haptics
