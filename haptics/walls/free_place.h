// is_free(): test of points at which a proxy may be set.
#pragma once

#include "haptics/scene/touch_state.h"

namespace trephine::haptics {

/// Returns true if a proxy may be set at this point (volume frame), for any solid that methods touch: cubes,
/// triangles or the smooth one. Tests the shapes of the base only. Cost: microseconds; not for the servo.
bool is_free(const TouchScene& scene, const TouchState& touch_state, const glm::dvec3& position) noexcept;

}  // namespace trephine::haptics
