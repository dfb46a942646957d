// NIfTI (1 and 2, one file or two) and Analyze in, by niftilib. (ITK 5.2 refuses affines that are off right
// angles by a rounding, which are common.)
#pragma once

#include "data-tools/open_volume.h"
#include "data-tools/writing.h"

namespace trephine::data_tools {

/// See open_volume. Where sform and qform disagree the caller must choose.
volume::Result<OpenedVolume> open_nifti(const std::string& path, const OpenOptions& options);

/// Writes .nii or .nii.gz, NIfTI-1 with sform and qform, of voxels of int16 or uint8; errors name `path`.
volume::Status write_nifti(const std::string& temporary, const std::string& path,
                           const VoxelsToWrite& voxels);

}  // namespace trephine::data_tools
