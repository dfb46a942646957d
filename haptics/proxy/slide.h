// slide(): motion along smooth walls to the point nearest to the HIP, which is the work of one servo step.
// Works with any class of walls that has queries for motions, points and derivatives.
#pragma once

#include "haptics/walls/scene_walls.h"

namespace trephine::haptics {

/// Moves from the last proxy toward the HIP: straight until walls stop the proxy, then along the walls, with
/// friction. Writes to `result`; `walls` must use the counters of `result`. `base`: the frame of the state
/// and of the reported path; `walls` may use another frame. `Walls`: SmoothWalls or SceneWalls. Servo thread:
/// no allocation, every loop bounded.
template <class Walls>
void slide(const TouchScene& scene, Walls& walls, const volume::Frame& base, ProxyState& state,
           const glm::dvec3& hip_world, ProxyStep& result) noexcept;

extern template void slide(const TouchScene&, SmoothWalls&, const volume::Frame&, ProxyState&,
                           const glm::dvec3&, ProxyStep&) noexcept;
extern template void slide(const TouchScene&, SceneWalls&, const volume::Frame&, ProxyState&,
                           const glm::dvec3&, ProxyStep&) noexcept;

}  // namespace trephine::haptics
