// DICOM in, by vtk-dicom; the geometry and every refusal are ours.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// Reads the one series of a folder, or one file. See open_volume.
volume::Result<OpenedVolume> open_dicom(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
