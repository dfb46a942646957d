// Slice panels: grey values of a scan in a plane, with the outlines of objects in that plane.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"
#include "modules/ct_viewer/slice_image.h"

namespace trephine::imaging {

/// Returns the image of `values`, which were sampled in `plane`.
Panel slice_panel(const ct_viewer::SliceValues& values, const volume::ImagePlane& plane,
                  const ct_viewer::GreyWindow& window, ct_viewer::Blend blend);

/// Returns the initial grey window: that of bone for Hounsfield units, otherwise one that fits the `shown`
/// values.
ct_viewer::GreyWindow first_window(const volume::Volume& scan, std::span<const std::int16_t> shown);

/// Draws the areas and outlines of objects and, if `has_labels`, the outlines of the scan's labels. Also
/// draws planned trajectories, and edges of planned outlines, with both ends within 2 mm of `plane`. Error:
/// the surface of an object cannot be cut.
Status draw_in(Panel& panel, const Subject& subject, const volume::ImagePlane& plane, bool has_labels);

}  // namespace trephine::imaging
