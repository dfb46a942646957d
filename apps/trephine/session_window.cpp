#include "apps/trephine/session_window.h"

#include "apps/trephine/report.h"
#include "apps/view/view_window.h"

namespace trephine::app {

volume::Status play_in_window(workbench::OpenedSession& session, const std::string& file,
                              const std::string& title) {
  auto summary = workbench::summarize_session(file);
  if (!summary) return summary.error();
  view::WindowOptions options;
  options.wants_to_end = is_interrupted;
  options.title = title;
  options.rate_hz = session.reader->header().rate_hz;
  options.replay = session.replay.get();
  options.summary = std::move(summary).value();
  options.replay_seconds = static_cast<double>(session.reader->tick_count()) / options.rate_hz;
  const auto shown = view::run_window(view::borrowed(session.scene()), options);
  return shown ? std::nullopt : volume::Status(shown.error());
}

}  // namespace trephine::app
