// open_raw(): reads numbers without a header, in a stated layout.
#pragma once

#include "data-tools/formats/opened_volume.h"

namespace trephine::data_tools {

/// Reads a file with the layout options.raw. Requires the voxel size options.spacing (mm); see open_volume().
Result<OpenedVolume> open_raw(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
