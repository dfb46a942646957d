#include "apps/workbench/course.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>

namespace trephine::workbench {

namespace {

/// Returns the sessions of a folder, in the order of their names.
Result<std::vector<std::string>> sessions_in(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (is_session_file(entry->path().string())) paths.push_back(entry->path().string());
  if (error || paths.empty())
    return Error{.what = error ? "the folder cannot be read" : "the folder has no sessions",
                 .where = "session",
                 .expected = "a recorded session, or a folder of sessions",
                 .remedy = "pass a session or another folder"};
  std::sort(paths.begin(), paths.end());
  return paths;
}

Result<SessionScore> score_file(const std::string& path, const SourceChoice& case_source,
                                const Listener& listener, CourseSession& session) {
  auto opened = open_session(path, case_source, listener);
  if (!opened) return opened.error();
  const sim::SessionHeader& header = opened.value()->reader->header();
  session.title = header.plan.procedure.title;
  session.dt = 1 / header.rate_hz;
  return score_session(*opened.value(), {}, listener);
}

}  // namespace

Result<std::vector<CourseSession>> score_course(const std::string& folder, const SourceChoice& case_source,
                                                const Listener& listener) {
  const auto paths = sessions_in(folder);
  if (!paths) return paths.error();
  std::vector<CourseSession> sessions;
  for (const std::string& path : paths.value()) {
    CourseSession& session = sessions.emplace_back();
    session.date = date_of_file(path);
    auto score = score_file(path, case_source, listener, session);
    if (score)
      session.score = std::move(score).value();
    else if (score.error().kind == ErrorKind::interrupted)
      return score.error();
    else
      session.error = score.error().what;
  }
  return sessions;
}

std::string date_of_file(const std::string& path) {
  std::error_code error;
  const auto changed = std::filesystem::last_write_time(path, error);
  if (error) return "";
  const std::time_t seconds = std::chrono::system_clock::to_time_t(std::chrono::file_clock::to_sys(changed));
  std::tm day{};
  gmtime_r(&seconds, &day);
  char text[16];
  return std::string(text, std::strftime(text, sizeof text, "%Y-%m-%d", &day));
}

}  // namespace trephine::workbench
