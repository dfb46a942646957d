// Are these slices one regular stack? Pure geometry, so that every refusal can be tested without a scanner.
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/frame.h"

namespace trephine::data_tools {

/// Position of one slice (DICOM LPS, mm).
struct SlicePlace {
  glm::dvec3 position{0.0};      ///< centre of the first pixel
  glm::dvec3 row_axis{1, 0, 0};  ///< direction of growing column index
  glm::dvec3 column_axis{0, 1, 0};
  double row_spacing = 0;     ///< mm between rows
  double column_spacing = 0;  ///< mm between columns
  double thickness = 0;       ///< for a lone slice; 0 when unknown
  std::string name;           ///< for errors
};

struct SliceStack {
  std::vector<int> order;   ///< the inputs along the stack; slice k of the volume is input order[k], unless
                            ///< slices are made
  std::vector<double> at;   ///< when they are: slice k lies at this place in `order`, between two of them
  volume::Frame frame;      ///< x along rows (columns of the image), y down the columns, z along the stack
  double tilt_degrees = 0;  ///< between stack and normal: the frame is sheared by as much
};

/// Sorts slices along their common normal. A tilted gantry makes a sheared frame, exactly. Error, with what
/// was found, where and how much: directions that differ or are not at right angles, two slices in one place,
/// and uneven or missing slices, unless `makes_even`: then even slices are put between them.
volume::Result<SliceStack> stack_slices(const std::vector<SlicePlace>& slices, bool makes_even = false);

}  // namespace trephine::data_tools
