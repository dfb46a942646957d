// Coulomb friction on a path: the proxy stays, or trails its frictionless place by a share of the depth
// (seeds of the method: stick threshold and step back on the sliding distance; cone of Salisbury and Tarr
// 1997).
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// Shortens step.path_volume (its end is the frictionless proxy) so that the tangential spring force stays
/// within the cone of `material`. Returns the new proxy: a waypoint, or a point inside the last leg left,
/// which the caller checks again, since rounding may have moved it across a voxel's face. The legs up to
/// waypoint `landing` led down to the surface and stay. Call while contact lasts, not on its first step.
glm::dvec3 apply_friction(const volume::Frame& frame, const Material& material, const glm::dvec3& hip_world,
                          int landing, ProxyStep& step, bool& is_sticking) noexcept;

/// The landing for methods whose first leg leads down to the surface where that fell away from under the
/// proxy: 1 when it is longer than a tenth of a voxel, twice what a step may lift the proxy; else 0.
int landing_of_first_leg(const ProxyStep& step) noexcept;

/// Ends a step at its path's last waypoint: friction along the way to it, a last look at the leg that
/// friction shortened, and the state for the next step. `is_blocked(a, b)`: does a wall stop the way from a
/// to b (volume frame)?
template <class IsBlocked>
void end_with_friction(const volume::Frame& frame, const TouchScene& scene, const glm::dvec3& hip_world,
                       int landing, IsBlocked&& is_blocked, ProxyState& state, ProxyStep& step) noexcept {
  glm::dvec3 proxy = step.path_volume[static_cast<std::size_t>(step.waypoint_count - 1)];
  if (step.has_contact && state.had_contact) {
    const Material& material = material_of(scene, step.shape, step.side);
    proxy = apply_friction(frame, material, hip_world, landing, step, state.is_sticking);
    // A leg that friction shortened ends where rounding put it: look again.
    if (const int last = step.waypoint_count - 1; last > 0) {
      const glm::dvec3 begin = step.path_volume[static_cast<std::size_t>(last - 1)];
      if (is_blocked(begin, proxy)) {
        proxy = begin;
        --step.waypoint_count;
      }
    }
  } else if (step.has_contact) {
    state.is_sticking = true;
  }
  state.had_contact = step.has_contact;
  state.proxy_volume = proxy;
  step.proxy_world = frame.world_from_volume(proxy);
}

}  // namespace trephine::haptics
