// Scenes that the random attack uses in addition to attack_scene().
#pragma once

#include "apps/bench/attack.h"

namespace trephine::bench {

/// Bone, and the band of lower intensities at its blurred edge (-400 to 300 HU) as a second shape.
haptics::TouchScene two_shapes_scene();
/// A ball of three labels.
haptics::TouchScene three_labels_scene();
/// A gyroid touched from inside its solid (Side::back).
haptics::TouchScene touched_from_inside_scene();
/// The surface of a torus as a polygonal model, through a gyroid of bone.
haptics::TouchScene pierced_scene();

}  // namespace trephine::bench
