// SceneProxy: contact with several volumes and polygonal models.
#pragma once

#include "haptics/proxy/proxy_method.h"
#include "haptics/walls/scene_walls.h"

namespace trephine::haptics {

/// Touches all volumes and meshes in one solve: the slide of method `subvoxel` runs along smooth walls and
/// facets together, so that the proxy rests in the corner between a volume and a model that pierces it. A
/// touched moving mesh with friction carries the proxy along, and any moving mesh pushes the proxy instead of
/// passing over it. If other walls leave no free position, the mesh passes over the proxy, and the step
/// reports the proxy as buried. Only items near the tool are tested.
class SceneProxy final : public ProxyMethod {
 public:
  static constexpr MethodInfo k_info{.name = "scene",
                                     .meaning = "volumes and polygonal models in one solve",
                                     .source = "this project",
                                     .solid = MethodInfo::Solid::smooth,
                                     .is_baseline = false,
                                     .takes_ball = true,
                                     .takes_meshes = true,
                                     .takes_moving_meshes = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  SceneLayout layout_;
};

}  // namespace trephine::haptics
