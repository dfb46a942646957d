// The proxy on scenes of several volumes and polygonal models.
#pragma once

#include "haptics/walls/scene_walls.h"

namespace trephine::haptics {

/// All volumes and meshes in one solve: the slide of method `subvoxel` along smooth walls and facets
/// together, so that where a model pierces a volume the proxy rests in the corner of both. A mesh that moves
/// takes the proxy along: its way relative to the mesh is checked first; a proxy that it would press into
/// another wall is let go, and said to be buried. Only what is near the tool is looked at.
class SceneProxy final : public ProxyMethod {
 public:
  const char* name() const noexcept override { return "scene"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  SceneLayout layout_;
};

}  // namespace trephine::haptics
