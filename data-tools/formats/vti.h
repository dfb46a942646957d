// open_vti(), write_vti(): VTK image data (.vti), with VTK. The format has no patient axes: files are written
// in LPS, and the files of other programs are assumed to be in LPS, with a notice.
#pragma once

#include "data-tools/formats/opened_volume.h"
#include "data-tools/formats/write_volume.h"

namespace trephine::data_tools {

/// Reads the active scalars of the points or, without these, the first array of the points. Error for more
/// than one number per point. See open_volume().
Result<OpenedVolume> open_vti(const std::string& path, const OpenOptions& options);

/// Writes int16 or uint8 voxels to `temporary`; `path` is the name in errors.
Status write_vti(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels);

}  // namespace trephine::data_tools
