// Places where a proxy may be set down.
#pragma once

#include "haptics/scene/touch_state.h"

namespace trephine::haptics {

/// May a proxy be set down at this place (volume frame), whichever solid its method touches: cubes, triangles
/// or what is smooth? Of the shapes of the scene's first volume. Microseconds; not for the servo.
bool is_free(const TouchScene& scene, const TouchState& seen, const glm::dvec3& place) noexcept;

}  // namespace trephine::haptics
