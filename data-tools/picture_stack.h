// Slices as pictures (PNG, TIFF, and what else OpenImageIO knows), one a file, in the order of their names;
// or the pages of one TIFF.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// Is it a folder of pictures and nothing else, or a TIFF?
bool is_picture_stack(const std::string& path);

/// See open_volume. Pictures have no positions: stack.json next to them has them (ours), or options.
volume::Result<OpenedVolume> open_picture_stack(const std::string& path, const OpenOptions& options);

/// Writes slice-0001.png, ... and stack.json into a new folder.
volume::Status write_picture_stack(const std::string& path, bool is_png, const volume::Volume& volume,
                                   const Progress& progress);

}  // namespace trephine::data_tools
