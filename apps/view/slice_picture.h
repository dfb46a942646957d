// Cuts through a scan as one picture, side by side, with what is drawn in them.
#pragma once

#include "apps/imaging/panel.h"
#include "volume/error.h"

namespace trephine::view {

/// In rows of at most two, as PNG; `edge`: pixels along a panel's in the picture. Error when it cannot be
/// drawn.
volume::Result<std::string> slices_png(const std::vector<imaging::Panel>& panels, int edge = 520);
volume::Status write_slices(const std::vector<imaging::Panel>& panels, const std::string& path,
                            int edge = 520);

}  // namespace trephine::view
