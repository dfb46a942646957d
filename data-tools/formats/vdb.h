// open_vdb(), write_vdb(): OpenVDB's sparse grids. The format has no patient axes: files are written in LPS
// and mm, and the files of other programs are assumed to be so, with a notice.
#pragma once

#include "data-tools/formats/opened_volume.h"
#include "data-tools/formats/write_volume.h"

namespace trephine::data_tools {

/// Reads the box of active voxels of a grid of numbers, selected by options.volume; see open_volume().
Result<OpenedVolume> open_vdb(const std::string& path, const OpenOptions& options);

/// Writes scans as float and labels as int32, exactly, to `temporary`; `path` is the name in errors.
Status write_vdb(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels);

}  // namespace trephine::data_tools
