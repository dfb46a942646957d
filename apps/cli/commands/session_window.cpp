#include "apps/cli/commands/session_window.h"

#include "apps/cli/report.h"
#include "apps/view/view_window.h"

namespace trephine::cli {

Status play_in_window(workbench::OpenedSession& session, const std::string& file, const std::string& title) {
  auto summary = workbench::summarize_session(file);
  if (!summary) return summary.error();
  view::WindowOptions options;
  options.should_close = is_interrupted;
  options.title = title;
  options.rate_hz = session.reader->header().rate_hz;
  options.replay = session.replay.get();
  options.plan = std::make_shared<const volume::SurgicalPlan>(session.reader->header().plan);
  options.summary = std::move(summary).value();
  options.replay_seconds = static_cast<double>(session.reader->tick_count()) / options.rate_hz;
  const auto shown = view::run_window(view::borrowed(session.scene()), options);
  return shown ? std::nullopt : Status(shown.error());
}

}  // namespace trephine::cli
