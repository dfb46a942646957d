// Report of the quality of a scan: rows and a chart.
#pragma once

#include "apps/cli/report.h"
#include "data-tools/quality/scan_quality.h"

namespace trephine::cli {

/// Adds the row `quality` and its lines. `low`: threshold of the solid, in the scan's unit.
void report_quality(const data_tools::ScanQuality& quality, bool is_hounsfield, double low, Rows& rows);
/// Writes the measured edge profile as a picture.
Status write_quality_chart(const data_tools::ScanQuality& quality, const std::string& path);

}  // namespace trephine::cli
