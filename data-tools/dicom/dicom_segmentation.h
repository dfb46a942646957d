// open_dicom_segmentation(): reads DICOM segmentations (SEG), label maps on their own grid.
#pragma once

#include "data-tools/formats/opened_volume.h"

namespace trephine::data_tools {

/// Returns true if the file is a DICOM segmentation.
bool is_dicom_segmentation(const std::string& path);

/// Returns a label map, whose values are segment numbers, and the segments' names. If segments overlap, each
/// is a separate layer: the map contains the first one, and `only_segment` (a number) selects another.
Result<OpenedVolume> open_dicom_segmentation(const std::string& path, int only_segment = 0);

}  // namespace trephine::data_tools
