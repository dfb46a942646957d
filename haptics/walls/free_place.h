// is_free(): test of points at which a proxy may be set.
#pragma once

#include "haptics/scene/touch_state.h"

namespace trephine::haptics {

/// Returns true if a proxy of any method may be set at this point (frame of the base volume): it is free of
/// the solids of all methods, which are cubes, triangles and the smooth solid. Tests only the shapes of the
/// base. Cost: microseconds; not for the servo thread.
bool is_free(const TouchScene& scene, const TouchState& touch_state, const glm::dvec3& position) noexcept;

}  // namespace trephine::haptics
