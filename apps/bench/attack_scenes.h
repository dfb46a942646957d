// Scenes that the random attack uses in addition to attack_scene().
#pragma once

#include "apps/bench/attack.h"

namespace trephine::bench {

/// Bone, and the softer rim of its blurred edge as a second shape.
haptics::TouchScene two_shapes_scene();
/// A ball of three labels.
haptics::TouchScene three_labels_scene();
/// A gyroid that holds the tool from within.
haptics::TouchScene held_from_within_scene();
/// The surface of a torus as a polygonal model, through a gyroid of bone.
haptics::TouchScene pierced_scene();

}  // namespace trephine::bench
