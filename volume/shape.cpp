#include "volume/shape.h"

#include <charconv>
#include <cmath>

namespace trephine::volume {

std::string describe(const Shape& shape, bool is_hounsfield) {
  const auto text_of = [](double value) {
    char text[40];
    return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
  };
  if (shape.is_label()) return "label " + shape.name;
  const std::string unit = is_hounsfield ? " HU" : "";
  if (std::isinf(shape.high)) return text_of(shape.low) + unit + " and above";
  if (std::isinf(shape.low)) return text_of(shape.high) + unit + " and below";
  return text_of(shape.low) + " to " + text_of(shape.high) + unit;
}

}  // namespace trephine::volume
