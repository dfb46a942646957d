// The implicit surface proxy: voxel cubes as walls, interpolated gradients as normals.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// Iterative collision detection on voxel cubes: the way to the HIP is traversed exactly; at each crossing
/// the HIP is projected on the plane through the crossing with the interpolated normal, and the way goes on
/// there. All points reached are candidates, and the one nearest to the HIP is the new proxy (iterative ray
/// casting with candidate trimming, after the thesis "A Surface-based Volume Haptics Approach", 3.4.1.1). The
/// proxy never enters a solid voxel: every leg of its path has been traversed. Cost: 0.1 - 0.5 us in contact,
/// whatever the volume's size.
class ImplicitProxy final : public ProxyMethod {
 public:
  /// `iterations`: collision queries a step, 1 to k_max_iterations.
  explicit ImplicitProxy(int iterations = 3) noexcept;

  const char* name() const noexcept override { return "implicit"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  int iterations_;
};

}  // namespace trephine::haptics
