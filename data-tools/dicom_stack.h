// Are these slices one regular stack? Pure geometry, so that every refusal can be tested without a scanner.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "volume/frame.h"

namespace trephine::data_tools {

/// Where one slice lies (DICOM LPS, mm).
struct SlicePlace {
  glm::dvec3 position{0.0};      ///< centre of the first pixel
  glm::dvec3 row_axis{1, 0, 0};  ///< direction of growing column index
  glm::dvec3 column_axis{0, 1, 0};
  double row_spacing = 0;     ///< mm between rows
  double column_spacing = 0;  ///< mm between columns
  double thickness = 0;       ///< for a lone slice; 0 when unknown
};

struct SliceStack {
  std::vector<int> order;  ///< slice k of the volume is input order[k]
  volume::Frame frame;     ///< x along rows (columns of the image), y down the columns, z along the stack
};

/// Sorts slices along their common normal. Error, with what was found and how much: directions that differ or
/// are not at right angles, two slices in one place, uneven or missing slices, a tilted gantry.
volume::Result<SliceStack> stack_slices(const std::vector<SlicePlace>& slices);

}  // namespace trephine::data_tools
