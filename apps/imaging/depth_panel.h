// Panel with views of the objects that the tool touches by depth images, from the six sides of these images.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"

namespace trephine::imaging {

/// Draws the views from L, P, S in the upper row and from R, A, I in the lower row; near is bright. Fits
/// `columns` x `rows` pixels, with 8 to 96 pixels along the edge of a view. Shows all objects of `depths` in
/// the clip volume of the first object. Error: no object near the tool is touched by depth images.
Result<Panel> depth_panel(std::span<const sim::DisplayedDepths> depths, int columns, int rows);

/// Returns the edges of the clip volumes (world, mm).
std::vector<std::array<glm::dvec3, 2>> clip_volumes(std::span<const sim::DisplayedDepths> depths);

}  // namespace trephine::imaging
