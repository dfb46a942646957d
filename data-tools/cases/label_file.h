// read_labels(): reads labels of a scan from segmentations and label maps, also on other grids.
#pragma once

#include <string>
#include <vector>

#include "data-tools/formats/opened_volume.h"

namespace trephine::data_tools {

/// Labels of a scan.
struct ReadLabels {
  Buffer<std::uint8_t> labels;       ///< one per voxel of the scan
  std::vector<std::string> names;    ///< by value; 0 is the background
  std::vector<glm::u8vec3> colours;  ///< by value, if the file has colours; else empty
  /// Notices about labels that were resampled or renumbered, overlap, or are outside the scan.
  std::vector<std::string> notices;
};

/// Reads labels for `scan`. Labels on another grid are resampled (nearest neighbour). All labels are
/// renumbered from 1 if a value exceeds 255 or there are several layers. Names come from the file (.seg.nrrd,
/// DICOM SEG, TotalSegmentator's NIfTI) or are "label-N". `path` may be a folder with one mask per structure;
/// the name of a file is then the name of its structure. Voxels that belong to several segments get a
/// separate label. Error if no label is within the scan, or the result would have more than 255 labels.
Result<ReadLabels> read_labels(const std::string& path, const volume::Volume& scan,
                               const OpenOptions& options = {});

}  // namespace trephine::data_tools
