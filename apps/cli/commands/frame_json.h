// Grid of a volume, for reports.
#pragma once

#include "apps/cli/report.h"

namespace trephine::cli {

inline Json frame_json(const volume::Volume& v) {
  return {{"size", Json::array({v.size.x, v.size.y, v.size.z})},
          {"spacing_mm", json_of(v.frame.spacing())},
          {"origin_mm", json_of(v.frame.origin())},
          {"axis_x", json_of(v.frame.axes()[0])},
          {"axis_y", json_of(v.frame.axes()[1])},
          {"axis_z", json_of(v.frame.axes()[2])}};
}

/// Line of text that prints the rows `size` and `spacing_mm` of frame_json().
inline constexpr const char* k_size_line =
    "{size/0} x {size/1} x {size/2} voxels of {spacing_mm/0:.4g} x {spacing_mm/1:.4g} x "
    "{spacing_mm/2:.4g} mm";

}  // namespace trephine::cli
