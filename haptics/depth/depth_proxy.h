// DepthProxy: contact by depth images with all their layers. Only images are prepared, and the proxy does not
// pass through any surface that they show.
#pragma once

#include "haptics/depth/depth_net.h"
#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// A god-object on the surface that the images of each item show: a net on the points where rays along three
/// axes cross its layers, built only in the cells that the motion meets. The net is closed between pixels,
/// layers and cameras, including hidden interiors, and as exact as the crossings of the rays. Matter that no
/// ray meets, thinner than a pixel in two directions, is missing. Volumes are touched as they are before any
/// cut. Cost: some us per item in contact, whatever the item's size.
class DepthProxy final : public ProxyMethod {
 public:
  static constexpr double k_pixel = 0.2;  ///< mm, of models; volumes have one ray per voxel
  static constexpr MethodInfo k_info{
      .name = "depth",
      .meaning = "depth images along three axes with every layer, a god-object on the net of their crossings",
      .source = "this project; Ju, Losasso, Schaefer and Warren 2002",
      .solid = MethodInfo::Solid::images,
      .is_baseline = false,
      .takes_cuts = false,
      .takes_meshes = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  std::vector<depth::DepthNet> nets_;  ///< one per item
  double gap_ = 1e-5;                  ///< mm that the proxy keeps before facets
};

}  // namespace trephine::haptics
