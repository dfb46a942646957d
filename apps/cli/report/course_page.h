// Page of a course: learning curves and findings of the sessions of a folder, as one HTML file.
#pragma once

#include <span>
#include <string>

#include "apps/workbench/course.h"

namespace trephine::cli {

/// Returns the page. Sessions have numbers, never the names of their files. `program`: name and version of
/// this program.
std::string course_html(std::span<const workbench::CourseSession> sessions, const std::string& program);

}  // namespace trephine::cli
