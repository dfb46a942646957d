// Models of a report: surfaces before and after an operation as glTF scenes of few triangles.
#pragma once

#include <string>

#include "apps/workbench/report_data.h"

namespace trephine::cli {

/// Maximum number of triangles of a scene.
inline constexpr std::size_t k_report_triangles = 120'000;

struct ReportModels {
  std::string before, after;  ///< glTF binary files
  std::size_t before_triangles = 0, after_triangles = 0;
};
/// Makes the scenes: the touchable shapes of the scan, with cut surfaces as separate nodes. The scene after
/// the operation also has bodies, models and the lines of tracks. Detail near cuts is kept if `limit`
/// (triangles) allows it.
ReportModels models_of(const workbench::ReportData& data, std::size_t limit = k_report_triangles);

}  // namespace trephine::cli
