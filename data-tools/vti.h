// VTK's image data (.vti) in and out, by VTK's XML reader and writer. It says nothing of a patient's axes:
// ours are LPS, and others are taken for it, with a notice.
#pragma once

#include "data-tools/open_volume.h"
#include "data-tools/writing.h"

namespace trephine::data_tools {

/// See open_volume. The first array of points with one number each is the volume.
volume::Result<OpenedVolume> open_vti(const std::string& path, const OpenOptions& options);

/// Writes int16 or uint8 voxels; errors name `path`.
volume::Status write_vti(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels);

}  // namespace trephine::data_tools
