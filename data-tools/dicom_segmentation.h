// DICOM segmentations (SEG): which voxels belong to which segment, on a grid of their own.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

bool is_dicom_segmentation(const std::string& path);

/// As a map of segment numbers, with the segments' names. Error when segments overlap: one voxel, one label.
volume::Result<OpenedVolume> open_dicom_segmentation(const std::string& path);

}  // namespace trephine::data_tools
