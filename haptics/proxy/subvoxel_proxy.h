// SubvoxelProxy: exact contact with the smooth solid, with friction.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// The proxy minimises its distance to the HIP (mm) in the free space of the smooth reconstruction
/// (volume/fields/quadratic_patch.h), downhill from its last position: a straight motion to the first
/// crossing, then Newton steps on the surface with its curvature, with up to three walls active at once
/// (active sets after Ruspini, Kolarov and Khatib 1997), until the estimated error is about 1e-7 of a voxel.
/// With friction the path ends earlier. Every leg of the path is proven free of matter by bounds on the
/// polynomials that the leg meets: if a Newton step fails, the result is less accurate, but the proxy never
/// falls through the surface. Cost: 0.3 to 1 us per step in contact, independent of the volume's size.
class SubvoxelProxy final : public ProxyMethod {
 public:
  static constexpr MethodInfo k_info{
      .name = "subvoxel",
      .meaning = "exact contact with the smooth reconstruction, all walls at once",
      .source = "this project",
      .solid = MethodInfo::Solid::smooth,
      .is_baseline = false,
      .takes_ball = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;
};

}  // namespace trephine::haptics
