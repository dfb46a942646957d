// Numbers without a header, of a given layout.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// See open_volume; options.raw says the layout, options.spacing the size of a voxel.
volume::Result<OpenedVolume> open_raw(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
