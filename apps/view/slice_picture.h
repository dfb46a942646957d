// Picture of several panels side by side, with their lines, letters and legend.
#pragma once

#include "apps/imaging/panel.h"
#include "volume/base/error.h"

namespace trephine::view {

/// Draws panels in rows of at most three, as PNG. `edge`: pixels along the edge of a panel. Error if
/// OpenGL is not available.
Result<std::string> slices_png(const std::vector<imaging::Panel>& panels, int edge = 520);
/// Writes slices_png() to a file, atomically.
Status write_slices(const std::vector<imaging::Panel>& panels, const std::string& path, int edge = 520);

}  // namespace trephine::view
