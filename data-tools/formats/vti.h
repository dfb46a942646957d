// open_vti(): reads and writes VTK image data (.vti), with VTK. Files have no patient axes: ours are LPS,
// which is assumed for others, with a notice.
#pragma once

#include "data-tools/formats/opened_volume.h"
#include "data-tools/formats/write_volume.h"

namespace trephine::data_tools {

/// Reads the active scalars, or else the first array of the points, one number each; see open_volume().
Result<OpenedVolume> open_vti(const std::string& path, const OpenOptions& options);

/// Writes int16 or uint8 voxels to `temporary`; `path` is the name in errors.
Status write_vti(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels);

}  // namespace trephine::data_tools
