// Report of the quality of a scan, as JSON, text and chart.
#pragma once

#include "apps/cli/report.h"
#include "data-tools/quality/scan_quality.h"

namespace trephine::cli {

Json quality_json(const data_tools::ScanQuality& quality);
/// Returns the report as lines of text. `low`: threshold of the solid, in the scan's unit.
std::string quality_text(const data_tools::ScanQuality& quality, bool is_hounsfield, double low);
/// Writes the measured edge profile as a picture.
Status write_quality_chart(const data_tools::ScanQuality& quality, const std::string& path);

}  // namespace trephine::cli
