// Stacks of pictures. open_picture_stack() reads slices from pictures (PNG, TIFF and other formats of
// OpenImageIO), one per file in the order of the names, or from the pages of one TIFF. write_picture_stack()
// writes a folder of PNG or TIFF files.
#pragma once

#include "data-tools/formats/opened_volume.h"

namespace trephine::data_tools {

/// Returns true for a TIFF file, and for a folder with several pictures, or with one picture and stack.json.
/// The folder may also contain .json, .txt and hidden files.
bool is_picture_stack(const std::string& path);

/// Reads a stack; see open_volume(). Its grid comes from stack.json of write_picture_stack(), or the options.
Result<OpenedVolume> open_picture_stack(const std::string& path, const OpenOptions& options);

/// Writes slice-0001.png, ... (`is_png`) or slice-0001.tif, ..., and stack.json, into a new folder.
Status write_picture_stack(const std::string& path, bool is_png, const volume::Volume& volume,
                           const Progress& progress);

}  // namespace trephine::data_tools
