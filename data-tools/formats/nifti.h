// open_nifti(): reads NIfTI (1 and 2, one file or two) and Analyze, and writes NIfTI-1, with niftilib.
// (ITK 5.2 rejects affines with rounded, almost right angles, which are common.)
#pragma once

#include "data-tools/formats/opened_volume.h"
#include "data-tools/formats/write_volume.h"

namespace trephine::data_tools {

/// Reads a file; see open_volume(). Error if sform and qform differ and the options select neither.
Result<OpenedVolume> open_nifti(const std::string& path, const OpenOptions& options);

/// Writes .nii or .nii.gz (NIfTI-1, sform and qform, int16 or uint8) to `temporary`; `path` is the name in
/// errors.
Status write_nifti(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels);

}  // namespace trephine::data_tools
