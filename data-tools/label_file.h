// Labels of a scan from any file that holds them: segmentations with names, label maps on grids of their own.
#pragma once

#include <string>
#include <vector>

#include "data-tools/open_volume.h"

namespace trephine::data_tools {

struct ReadLabels {
  volume::Buffer<std::uint8_t> labels;  ///< on the scan's grid
  std::vector<std::string> names;       ///< of each value; 0 is the background
  std::vector<glm::u8vec3> colours;     ///< of each value, where the file says them; else empty
  std::vector<std::string> notices;     ///< what was resampled, renumbered or lost
};

/// Reads them for `scan`: resampled (nearest) from a grid of their own; renumbered when values are beyond
/// 255. Names are the file's (.seg.nrrd, DICOM SEG, TotalSegmentator's NIfTI) or "label-N". `path` may be a
/// folder of masks, one a structure, which gives the structure its name. Where segments overlap, the voxels
/// that belong to several get a label of their own. Error when no label lies in the scan, or when there are
/// more than 255.
volume::Result<ReadLabels> read_labels(const std::string& path, const volume::Volume& scan,
                                       const OpenOptions& options = {});

}  // namespace trephine::data_tools
