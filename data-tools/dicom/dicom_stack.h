// stack_slices(): checks and sorts slices as one regular stack. Pure geometry, testable without DICOM files.
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/scan/frame.h"

namespace trephine::data_tools {

/// Position of one slice (DICOM LPS, mm).
struct SlicePosition {
  glm::dvec3 position{0.0};      ///< centre of the first pixel
  glm::dvec3 row_axis{1, 0, 0};  ///< direction of increasing column index
  glm::dvec3 column_axis{0, 1, 0};
  double row_spacing = 0;     ///< mm between rows
  double column_spacing = 0;  ///< mm between columns
  double thickness = 0;       ///< mm, used for a single slice; 0: unknown
  std::string name;           ///< for errors
};

struct SliceStack {
  std::vector<int> order;   ///< input indices along the stack; slice k of the volume is input order[k]
  std::vector<double> at;   ///< fractional indices in `order` of interpolated slices; else empty
  volume::Frame frame;      ///< x along rows (columns of the image), y down the columns, z along the stack
  double tilt_degrees = 0;  ///< angle between stack and normal, by which the frame is sheared
};

/// Sorts slices along their common normal. A tilted gantry gives an exactly sheared frame. Error for
/// directions that differ or are not orthogonal, and slices at the same position; also for uneven or missing
/// slices, unless `makes_even`: then evenly spaced slices are interpolated.
Result<SliceStack> stack_slices(const std::vector<SlicePosition>& slices, bool makes_even = false);

}  // namespace trephine::data_tools
