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
  std::vector<int> order;   ///< input indices along the stack; if `at` is empty, slice k is input order[k]
  std::vector<double> at;   ///< for each interpolated slice, its fractional index in `order`; else empty
  volume::Frame frame;      ///< x along a row of the image, y down a column, z along the stack
  double tilt_degrees = 0;  ///< angle between stack and normal, by which the frame is sheared
};

/// Sorts slices along their common normal. The frame of a tilted gantry is sheared, without resampling. Error
/// if a number is not finite, pixel spacings differ or are invalid, directions differ or are not orthogonal,
/// two slices have the same position, or a slice is off the line of the stack. Uneven or missing slices are
/// an error too, unless `makes_even`: then evenly spaced slices are interpolated.
Result<SliceStack> stack_slices(const std::vector<SlicePosition>& slices, bool makes_even = false);

}  // namespace trephine::data_tools
