// Slices: greys of a scan in a plane, with what lies in that plane drawn in.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"
#include "modules/ct_viewer/slice_image.h"

namespace trephine::imaging {

/// Image of the same plane's values.
Panel slice_panel(const ct_viewer::SliceValues& values, const volume::ImagePlane& plane,
                  const ct_viewer::GreyWindow& window, ct_viewer::Blend blend);

/// The greys one begins with: of bone where numbers are Hounsfield units, else of what is shown.
ct_viewer::GreyWindow first_window(const volume::Volume& scan, std::span<const std::int16_t> shown);

/// Outlines of things and, where `has_labels`, of the scan's labels; the plan within 2 mm of the plane.
volume::Status draw_in(Panel& panel, const Subject& subject, const volume::ImagePlane& plane,
                       bool has_labels);

}  // namespace trephine::imaging
