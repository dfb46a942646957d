// Files of the page that CMake embeds: apps/cli/report/page.css and the bundle of viewer.js.
#pragma once

#include <string_view>

namespace trephine::cli {

extern const std::string_view k_report_css;
extern const std::string_view k_report_viewer;  ///< empty if the program was built without it

}  // namespace trephine::cli
