// open_image_file(): reads MetaImage, and writes MetaImage and NRRD, with ITK's ImageIO.
#pragma once

#include "data-tools/formats/opened_volume.h"
#include "data-tools/formats/write_volume.h"

namespace trephine::data_tools {

/// Reads .mha or .mhd; see open_volume().
Result<OpenedVolume> open_image_file(const std::string& path, const OpenOptions& options);

/// Writes .mha, .nrrd or .seg.nrrd (with the segments' names) to `temporary`; `path` is the name in errors.
Status write_image_file(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels);

}  // namespace trephine::data_tools
