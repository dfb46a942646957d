// Pictures of a report: states before and after the operation, slices and X-rays of decisive moments.
#pragma once

#include <string>
#include <vector>

#include "apps/workbench/report_data.h"

namespace trephine::cli {

struct ReportPicture {
  std::string png;
  std::string title, text;  ///< not escaped
  bool is_danger = false;
};

struct ReportPictures {
  /// Two pictures (PNG): both states side by side, and sections with the removed matter. Empty if the first
  /// touchable object is not a shape of the scan.
  std::string states, sections;
  std::vector<ReportPicture> moments;
  std::string problem;  ///< first error of a picture; empty: no error
};
ReportPictures pictures_of(const workbench::ReportData& data);

}  // namespace trephine::cli
