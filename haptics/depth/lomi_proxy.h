// The proxy by six depth images: any thing that can be drawn can be touched from outside.
#pragma once

#include "haptics/depth/depth_cube.h"
#include "haptics/depth/lomi.h"
#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// The published method: a search along the way at the desired resolution, the nearest free voxel of a local
/// occupancy map that is never stored, and that voxel divided by 27 four times. prepare() makes the images of
/// each item with pixels of the desired resolution, of volumes as they are untouched. What hides behind the
/// outermost layers is not felt, and what is thinner than the resolution may be passed. There is no friction.
/// Cost: some hundred look-ups, whatever the scene's size.
class LomiProxy final : public ProxyMethod {
 public:
  static constexpr double k_resolution = 0.2;  ///< mm, as published
  const char* name() const noexcept override { return "lomi"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  std::vector<depth::DepthCube> cubes_;  ///< one an item
  depth::LomiOptions options_;
};

}  // namespace trephine::haptics
