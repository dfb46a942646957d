// SubvoxelProxy: exact contact with the smooth solid, at the point that a frictionless hand would reach.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// The proxy minimises its distance to the HIP (mm) in the free space of the smooth reconstruction
/// (volume/fields/quadratic_patch.h), downhill from its last position: a straight motion to the first
/// crossing, then Newton steps on the surface with its curvature, with up to three walls active at once
/// (active sets after Ruspini, Kolarov and Khatib 1997), until the estimated error is about 1e-7 of a voxel.
/// Every leg of its path is proven free of matter by bounds on the polynomials that it meets, so that a
/// failed step costs accuracy, never a fall-through. Cost: 0.3 to 1 us in contact, whatever the volume's
/// size.
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
