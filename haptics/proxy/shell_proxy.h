// ShellProxy: contact of the whole surface of a rigid tool, with six degrees of freedom and friction.
#pragma once

#include "haptics/proxy/proxy_method.h"
#include "haptics/walls/scene_walls.h"

namespace trephine::haptics {

/// Moves a PointShell to the pose nearest to the hand at which none of its points is in a solid: a god-object
/// of six degrees of freedom (Ortega, Redon and Coquillart 2007) on the smooth solids and models of a scene.
///
/// A step visits the tree of the shell and keeps the points that could meet matter while the tool moves by at
/// most a margin. In each of a few rounds the nearest walls bound the motion (find_pushes()), with Coulomb
/// friction (Gauss-Seidel), and the motion of every kept point is proven free before the tool moves.
/// The work is bounded by counts, never by time. If there are too many points, the margin is halved, so that
/// the tool may lag behind the hand for some ticks. If that does not suffice, every second point is tested,
/// then every fourth, and so on.
///
/// Points touch shapes from the front only. Points that are inside a solid at the beginning of a step, for
/// example because matter was restored or the tool started there, do not touch this solid until they have
/// left it.
class ShellProxy final : public ProxyMethod {
 public:
  static constexpr MethodInfo k_info{
      .name = "shell",
      .meaning = "the whole surface of a rigid tool, six degrees of freedom, on the walls of method scene",
      .source = "this project; Ortega, Redon and Coquillart 2007",
      .solid = MethodInfo::Solid::smooth,
      .is_baseline = false,
      .freedom = Freedom::six,
      .takes_points = false,
      .takes_shells = true,
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
