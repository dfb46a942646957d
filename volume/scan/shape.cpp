#include "volume/scan/shape.h"

#include <cmath>

#include "volume/base/text.h"

namespace trephine::volume {

std::string describe(const Shape& shape, bool is_hounsfield) {
  if (shape.is_label()) return "label " + shape.name;
  const std::string unit = is_hounsfield ? " HU" : "";
  if (std::isinf(shape.high)) return text_of(shape.low) + unit + " and above";
  if (std::isinf(shape.low)) return text_of(shape.high) + unit + " and below";
  return text_of(shape.low) + " to " + text_of(shape.high) + unit;
}

}  // namespace trephine::volume
