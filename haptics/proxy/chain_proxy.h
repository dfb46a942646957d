// The proxy of a rigid tool of several balls: six degrees of freedom.
#pragma once

#include "haptics/walls/scene_walls.h"

namespace trephine::haptics {

/// The tool lies where it is nearest to the hand without a ball in the solid, nearest by the springs that tie
/// each ball to its place in the hand: a god-object of 6 degrees of freedom (Ortega, Redon and Coquillart
/// 2007) on the walls that balls of TouchScene::tool_radius have, volumes and models together. In each of a
/// few rounds the walls near every ball bound the tool's motion (a small quadratic problem, Gauss-Seidel),
/// and each ball's way is proven free before the tool is moved, so that nothing however thin is passed.
/// A mesh that moves and would pass over a ball takes the tool along first, or pushes it aside; where others
/// leave it no way out, the mesh passes over it, and it is said to be buried. Without friction.
class ChainProxy final : public ProxyMethod {
 public:
  const char* name() const noexcept override { return "chain"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  SceneLayout layout_;
};

}  // namespace trephine::haptics
