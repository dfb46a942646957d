// Proxies for scenes of several volumes and polygonal models.
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

/// The pipeline of the thesis of the volume haptics toolkit (4.2.2): a god-object on the meshes follows the
/// hand, then every volume for itself follows that god-object, and the one with the shortest penetration
/// counts. Kept honest: what the volumes push the proxy into, no mesh hears of (figure 23). A scene that is
/// changed after prepare() is seen as it was.
class SequentialProxy final : public ProxyMethod {
 public:
  const char* name() const noexcept override { return "scene-sequential"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  SceneLayout layout_;
  std::vector<TouchScene> volumes_;  ///< one a volume, the base first
  std::vector<int> first_shape_;     ///< of each
  std::vector<std::shared_ptr<const TouchState>> untouched_;
  std::unique_ptr<ProxyMethod> method_;
};

}  // namespace trephine::haptics
