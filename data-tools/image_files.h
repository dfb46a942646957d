// MetaImage in, MetaImage and NRRD out, by ITK's ImageIO.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// See open_volume.
volume::Result<OpenedVolume> open_image_file(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
