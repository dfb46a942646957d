// ChainProxy: contact of a rigid tool of several balls, with six degrees of freedom.
#pragma once

#include "haptics/proxy/proxy_method.h"
#include "haptics/walls/scene_walls.h"

namespace trephine::haptics {

/// Moves the tool to the pose nearest to the hand at which no ball is in a solid: a god-object of 6 degrees
/// of freedom (Ortega, Redon and Coquillart 2007). The distance is the energy of springs that connect each
/// ball to its position in the hand. The walls are those of volumes and models together. In each of a few
/// rounds the walls near every ball bound the tool's motion (a small quadratic problem, solved
/// exactly). The motion of each ball is proven free before the tool moves, so that no solid, however
/// thin, is passed. A moving mesh that would pass over a ball carries the tool along, or pushes it to the
/// side. If other walls leave no free position, the mesh passes over the tool, and the step reports the tool
/// as buried. There is no friction.
class ChainProxy final : public ProxyMethod {
 public:
  static constexpr MethodInfo k_info{
      .name = "chain",
      .meaning = "a rigid tool of balls, six degrees of freedom, on the walls of method scene",
      .source = "this project; Ortega, Redon and Coquillart 2007",
      .solid = MethodInfo::Solid::smooth,
      .is_baseline = false,
      .freedom = Freedom::six,
      .takes_points = false,
      .takes_sets_of_balls = true,
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
