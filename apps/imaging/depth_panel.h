// Images of the six cameras of a clip volume: the depth images by which a hand touches.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"

namespace trephine::imaging {

/// From L, P, S in the upper row, from R, A, I in the lower one, near is bright; `columns` x `rows` pixels at
/// most. All objects together, in the clip volume of the first. Error: no object near is touched so.
volume::Result<Panel> depth_panel(std::span<const sim::SeenDepths> depths, int columns, int rows);

/// The edges of the clip volumes, world.
std::vector<std::array<glm::dvec3, 2>> clip_volumes(std::span<const sim::SeenDepths> depths);

}  // namespace trephine::imaging
