// DICOM in: heads, geometry and every refusal are ours; GDCM unpacks compressed pixels.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// Message of the error for a folder, file or archive without any DICOM image.
inline constexpr const char* k_no_dicom = "there are no DICOM images here";

/// Can the file be read as DICOM, with or without preamble?
bool is_dicom_file(const std::string& path);
/// Reads the one series of a folder, or one file. See open_volume.
volume::Result<OpenedVolume> open_dicom(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
