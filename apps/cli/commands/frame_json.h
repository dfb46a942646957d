// Grid of a volume as JSON and as text, for reports.
#pragma once

#include "apps/cli/report.h"

namespace trephine::cli {

inline Json vector_json(const glm::dvec3& v) { return Json::array({v.x, v.y, v.z}); }

inline Json frame_json(const volume::Volume& v) {
  return {{"size", Json::array({v.size.x, v.size.y, v.size.z})},
          {"spacing_mm", vector_json(v.frame.spacing())},
          {"origin_mm", vector_json(v.frame.origin())},
          {"axis_x", vector_json(v.frame.axes()[0])},
          {"axis_y", vector_json(v.frame.axes()[1])},
          {"axis_z", vector_json(v.frame.axes()[2])}};
}

inline std::string size_text(const volume::Volume& v) {
  const glm::dvec3 s = v.frame.spacing();
  return format_text("%d x %d x %d voxels of %.4g x %.4g x %.4g mm", v.size.x, v.size.y, v.size.z, s.x, s.y,
                     s.z);
}

}  // namespace trephine::cli
