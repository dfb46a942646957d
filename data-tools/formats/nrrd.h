// open_nrrd(): reads NRRD with teem, the reference implementation.
#pragma once

#include "data-tools/formats/opened_volume.h"

namespace trephine::data_tools {

/// Reads a file in any anatomical space, with any order of axes; see open_volume().
Result<OpenedVolume> open_nrrd(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
