// A stack of DICOM slices becomes a volume.
#pragma once

#include "data-tools/dicom_series.h"

namespace trephine::data_tools {

inline constexpr const char* k_copy_again =
    "copy it again from its source, or take it away if it does not belong here";

/// Its voxels, places, units and notices; `where` names it in errors.
volume::Result<OpenedVolume> load_dicom_stack(const DicomFolder& folder, const DicomStack& stack,
                                              const OpenOptions& options, const std::string& where);

}  // namespace trephine::data_tools
