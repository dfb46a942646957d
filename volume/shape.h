// Solid shapes: a window of intensities, or a label.
#pragma once

#include <limits>
#include <string>

#include "volume/volume.h"

namespace trephine::volume {

/// A haptic transfer function. Window: g = min(I - low, high - I); label: g = +-0.5. g >= 0 is solid.
struct Shape {
  std::string name = "bone";
  double low = 300;                                       ///< intensity, solid from here ...
  double high = std::numeric_limits<double>::infinity();  ///< ... to here, both included
  int label = -1;                                         ///< when >= 0 the shape is this label, no window

  bool is_label() const noexcept { return label >= 0; }
  bool is_solid(std::int16_t intensity) const noexcept { return intensity >= low && intensity <= high; }
};

/// In words, for people: "300 HU and above", "label dura".
std::string describe(const Shape& shape, bool is_hounsfield);

}  // namespace trephine::volume
