// write_dicom_series(): writes a volume as a series of derived, anonymous images, with GDCM.
#pragma once

#include "data-tools/formats/opened_volume.h"

namespace trephine::data_tools {

/// Writes slice-0001.dcm, ... into a new folder: CT images (HU), or MR images if the volume is not in HU. A
/// tilted stack is kept; rows and columns that are not at right angles are resampled first. Equal volumes get
/// equal unique identifiers, which are unrelated to those of the input.
Status write_dicom_series(const std::string& path, const volume::Volume& volume, const Progress& progress);

}  // namespace trephine::data_tools
