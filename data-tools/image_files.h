// MetaImage in, MetaImage and NRRD out, by ITK's ImageIO.
#pragma once

#include "data-tools/open_volume.h"
#include "data-tools/writing.h"

namespace trephine::data_tools {

/// See open_volume.
volume::Result<OpenedVolume> open_image_file(const std::string& path, const OpenOptions& options);

/// Writes .mha, .nrrd or .seg.nrrd, with the segments' names; errors name `path`.
volume::Status write_image_file(const std::string& temporary, const std::string& path,
                                const VoxelsToWrite& voxels);

}  // namespace trephine::data_tools
