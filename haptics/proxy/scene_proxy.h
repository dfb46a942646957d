// SceneProxy: contact with several volumes and polygonal models.
#pragma once

#include "haptics/proxy/proxy_method.h"
#include "haptics/walls/scene_walls.h"

namespace trephine::haptics {

/// All volumes and meshes in one solve: the slide of method `subvoxel` along smooth walls and facets
/// together, so that the proxy rests in the corner of both where a model pierces a volume. A moving mesh
/// carries the proxy along: the motion relative to the mesh is checked first. If other walls leave no free
/// position, the mesh passes over the proxy, which is then reported as buried. Only items near the tool are
/// tested.
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
