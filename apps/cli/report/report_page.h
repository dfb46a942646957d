// Page of a report: one HTML file that needs no other file and sends no request.
#pragma once

#include <string>

#include "apps/cli/report/report_models.h"
#include "apps/cli/report/report_pictures.h"

namespace trephine::cli {

/// Largest page, bytes.
inline constexpr std::size_t k_max_report_bytes = 15'000'000;

struct ReportPage {
  std::string title;    ///< procedure or kind of the case; never the name of a file or a patient
  std::string date;     ///< of the session, "2026-11-27"
  std::string program;  ///< name and version of this program
  const workbench::ReportData* trainee = nullptr;
  const workbench::ReportData* expert = nullptr;  ///< null: no comparison
  ReportPictures pictures;
  ReportModels models;
};
/// Returns the page. If the page would exceed `max_bytes`, a sentence replaces the models.
std::string html_of(const ReportPage& page, std::size_t max_bytes = k_max_report_bytes);

/// Bundle of the 3-D viewer; empty if the program was built without it.
std::string_view report_viewer();

}  // namespace trephine::cli
