// Coulomb friction on a path: the proxy stays, or trails its frictionless place by a share of the depth
// (seeds of the method: stick threshold and step back on the sliding distance; cone of Salisbury and Tarr
// 1997).
#pragma once

#include "haptics/proxy_method.h"

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

}  // namespace trephine::haptics
