// What the six cameras of a clip volume see: depth images of what a hand feels by them.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"

namespace trephine::imaging {

/// From L, P, S in the upper row, from R, A, I in the lower one, near is bright; `columns` x `rows` pixels at
/// most. Of all things together, in the clip volume of the first. Error: nothing near is felt so.
volume::Result<Panel> depth_panel(std::span<const sim::SeenDepths> depths, int columns, int rows);

/// The edges of the clip volumes, world.
std::vector<std::array<glm::dvec3, 2>> clip_volumes(std::span<const sim::SeenDepths> depths);

}  // namespace trephine::imaging
