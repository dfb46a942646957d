// The sub-voxel proxy: exact contact with the smooth solid, and the point of it that a frictionless hand
// would reach.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// The proxy minimises its distance to the HIP (mm) in the free space of the smooth reconstruction
/// (volume/quadratic_patch.h), downhill from where it was: a straight way to the first crossing, then Newton
/// steps on the surface with its curvature, with up to three walls held at once (active sets after Ruspini,
/// Kolarov and Khatib 1997), until the step is below a millionth of a voxel. Every leg of its path is proven
/// free of matter by bounds on the polynomials that it meets, so a step that fails costs accuracy, never a
/// fall through. Cost: 0.3 - 1 us in contact, whatever the volume's size.
class SubvoxelProxy final : public ProxyMethod {
 public:
  const char* name() const noexcept override { return "subvoxel"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;
};

}  // namespace trephine::haptics
