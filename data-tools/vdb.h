// OpenVDB's sparse grids in and out. They say nothing of a patient's axes: ours are LPS in mm, and others are
// taken for it, with a notice.
#pragma once

#include "data-tools/open_volume.h"
#include "data-tools/writing.h"

namespace trephine::data_tools {

/// See open_volume. The active voxels' box of a grid of numbers; --volume chooses the grid.
volume::Result<OpenedVolume> open_vdb(const std::string& path, const OpenOptions& options);

/// Scans as float, labels as int32, exactly; errors name `path`.
volume::Status write_vdb(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels);

}  // namespace trephine::data_tools
