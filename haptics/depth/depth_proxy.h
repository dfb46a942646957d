// The proxy by depth images with all their layers: nothing is made beforehand but images, and nothing is
// passed.
#pragma once

#include "haptics/depth/depth_net.h"
#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// A god-object on the surface that the images of each item show: a net on the places where rays along three
/// axes meet its layers, made only in the cells that the motion meets. Closed between pixels, layers and
/// cameras, hidden interiors included, and as near as a place on a ray; what no ray meets, being thinner than
/// a pixel in two directions, is not there. Volumes are touched as they are untouched by tools. Cost: some us
/// in contact, whatever the scene's size.
class DepthProxy final : public ProxyMethod {
 public:
  static constexpr double k_pixel = 0.2;  ///< mm, of models; volumes have a ray a voxel
  const char* name() const noexcept override { return "depth"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  std::vector<depth::DepthNet> nets_;  ///< one an item
  double gap_ = 1e-5;                  ///< mm that the proxy keeps before facets
};

}  // namespace trephine::haptics
