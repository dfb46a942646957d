// Report of a scan's quality.
#pragma once

#include "apps/trephine/report.h"
#include "data-tools/scan_quality.h"

namespace trephine::app {

Json quality_json(const data_tools::ScanQuality& quality);
/// Lines for people.
std::string quality_text(const data_tools::ScanQuality& quality, bool is_hounsfield, double low);
/// Its edge as a picture.
volume::Status write_quality_chart(const data_tools::ScanQuality& quality, const std::string& path);

}  // namespace trephine::app
