// DICOM segmentations (SEG): which voxels belong to which segment, on a grid of their own.
#pragma once

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

bool is_dicom_segmentation(const std::string& path);

/// Returns a map of segment numbers, with the segments' names. Where segments overlap, each is a layer of its
/// own: the map is of the first, `only_segment` (its number) reads another.
volume::Result<OpenedVolume> open_dicom_segmentation(const std::string& path, int only_segment = 0);

}  // namespace trephine::data_tools
