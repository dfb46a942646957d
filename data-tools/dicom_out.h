// A volume as a DICOM series, by GDCM: derived, anonymous images.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// Writes slice-0001.dcm, ... into a new folder: CT images (HU), or MR images of anything else. A stack that
/// leans stays as it is; rows and columns that are not at right angles are resampled first. The same volume
/// gets the same unique identifiers, which say nothing of those that it was read from.
volume::Status write_dicom_series(const std::string& path, const volume::Volume& volume,
                                  const Progress& progress);

}  // namespace trephine::data_tools
