// load_dicom_stack(): reads a stack of DICOM slices as a volume.
#pragma once

#include "data-tools/dicom/dicom_series.h"

namespace trephine::data_tools {

/// Error::remedy for a broken file.
inline constexpr const char* k_copy_again =
    "copy it again from its source, or remove it if it does not belong here";

/// Returns the volume of a stack with its geometry, units and notices; `where` is its name in errors.
Result<OpenedVolume> load_dicom_stack(const DicomFolder& folder, const DicomStack& stack,
                                      const OpenOptions& options, const std::string& where);

}  // namespace trephine::data_tools
