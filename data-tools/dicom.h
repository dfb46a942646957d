// DICOM in, by vtk-dicom; the geometry and every refusal are ours.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// Does the file say that it is DICOM?
bool has_dicom_magic(const std::string& path);
/// Reads the one series of a folder, or one file. See open_volume.
volume::Result<OpenedVolume> open_dicom(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
