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
  /// Both states side by side, and sections with the removed matter; empty without a touchable shape.
  std::string states, sections;
  std::vector<ReportPicture> moments;
  std::string problem;  ///< reason for missing pictures; empty: all were made
};
ReportPictures pictures_of(const workbench::ReportData& data);

}  // namespace trephine::cli
