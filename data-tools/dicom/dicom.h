// open_dicom(): reads DICOM volumes. Headers, geometry and checks are our own; GDCM decompresses pixels.
#pragma once

#include "data-tools/formats/opened_volume.h"

namespace trephine::data_tools {

/// Error::what for a folder, file or archive without any DICOM image.
inline constexpr const char* k_no_dicom = "there are no DICOM images here";

/// Returns true if the file is DICOM, with or without preamble, even if broken.
bool is_dicom_file(const std::string& path);
/// Reads one series of a folder, or one file; see open_volume().
Result<OpenedVolume> open_dicom(const std::string& path, const OpenOptions& options);

}  // namespace trephine::data_tools
