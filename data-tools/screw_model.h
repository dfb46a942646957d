// A pedicle screw as a closed surface: for what is planned, and for what went wrong.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string_view>
#include <vector>

#include "volume/error.h"

namespace trephine::data_tools {

/// Entry of a screw's shaft into bone, and its tip, mm (LPS).
struct ScrewPlace {
  glm::dvec3 entry_world{0.0}, tip_world{0.0};
  double diameter = 6;  ///< mm, of the shaft
};
/// "EX,EY,EZ:TX,TY,TZ:D". Error when it is invalid, shorter than its diameter, or not of 1 to 15 mm.
volume::Result<ScrewPlace> parse_screw(std::string_view text);

struct ScrewModel {
  std::vector<glm::dvec3> vertices_world;
  std::vector<std::uint32_t> triangles;  ///< seen from outside counter-clockwise
};
/// The length of a screw's tip, in diameters.
inline constexpr double k_screw_tip = 1;
/// A shaft with a pointed tip, and a head half as wide again that stands 6 mm before the entry.
ScrewModel screw_model(const ScrewPlace& place);

}  // namespace trephine::data_tools
