// Shape: a solid defined by a window of intensities or by a label.
#pragma once

#include <limits>
#include <string>

#include "volume/scan/volume.h"

namespace trephine::volume {

/// Solid of a scan, {g >= 0}. A window of intensities I has g = min(I - low, high - I); a label has g = 0.5
/// in its voxels and -0.5 in others.
struct Shape {
  std::string name = "bone";
  double low = 300;                                       ///< lowest solid intensity
  double high = std::numeric_limits<double>::infinity();  ///< highest solid intensity
  int label = -1;                                         ///< if >= 0, this label defines the shape

  bool is_label() const noexcept { return label >= 0; }
  bool is_solid(std::int16_t intensity) const noexcept { return intensity >= low && intensity <= high; }
};

/// Returns a readable description: "300 HU and above", "label dura".
std::string describe(const Shape& shape, bool is_hounsfield);

}  // namespace trephine::volume
