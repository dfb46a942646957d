#include "apps/cli/commands/session_window.h"

#include <cmath>
#include <filesystem>

#include "apps/cli/commands/own_program.h"
#include "apps/cli/report.h"
#include "apps/workbench/session_score.h"
#include "modules/catalogue.h"
#include "sim/session/session_fork.h"

namespace trephine::cli {

namespace {

Result<sim::Score> score(const std::string& session, const std::string& open_scan,
                         const std::function<void(const sim::Score&)>& preliminary,
                         const workbench::Listener& listener) {
  const auto scan = scan_for(session, open_scan);
  if (!scan) return scan.error();
  auto opened = workbench::open_session(session, scan.value(), listener);
  if (!opened) return opened.error();
  if (const auto final_state = workbench::score_final_state(*opened.value()))
    preliminary(final_state.value());
  auto result = workbench::score_session(*opened.value(), {}, listener);
  if (!result) return result.error();
  return std::move(result).value().score;
}

/// Runs a command in a process of its own, with the open scan if the session neither contains its scan nor
/// names a built-in scan.
Status run_with_scan(std::vector<std::string> words, const std::string& session, const std::string& open_scan,
                     const std::function<bool(double)>& progress) {
  const auto scan = scan_for(session, open_scan);
  if (!scan) return scan.error();
  if (!scan.value().path.empty()) words.insert(words.end(), {"--scan", scan.value().path});
  return run_own_program(words, progress);
}

/// Writes the page in a process of its own, because its pictures need libraries that the window is using.
Status report(const std::string& session, const std::string& open_scan, const std::string& page,
              const workbench::Listener& listener) {
  return run_with_scan({"report", session, "-o", page}, session, open_scan,
                       listener.progress("writing the report"));
}

/// Continues a copy of the first part of a session in a window. The copy is kept with the autosaved sessions.
Status operate_from(const std::string& session, const workbench::SourceChoice& scan, double seconds,
                    double rate_hz, const DisplayArguments& display) {
  const auto copy = workbench::new_autosave();
  if (!copy) return copy.error();
  const auto ticks =
      sim::fork_session(session, static_cast<std::uint64_t>(std::llround(seconds * rate_hz)), copy.value());
  if (!ticks) return ticks.error();
  auto continued = workbench::continue_session(copy.value(), scan, true, terminal_listener());
  if (!continued) {
    std::error_code ignored;
    std::filesystem::remove(copy.value(), ignored);
    return continued.error();
  }
  const auto shown = continue_in_window(std::move(continued).value(), scan.path,
                                        {copy.value(), session, scan.path}, {}, display);
  return shown ? std::nullopt : Status(shown.error());
}

Result<view::WindowOptions> replay_options(workbench::OpenedSession& session, const Playback& playback) {
  auto summary = workbench::summarize_session(playback.file);
  if (!summary) return summary.error();
  view::WindowOptions options;
  options.should_close = is_interrupted;
  options.title = playback.title;
  options.rate_hz = session.reader->header().rate_hz;
  options.force = session.reader->header().force;
  options.replay = session.replay.get();
  options.plan = std::make_shared<const volume::SurgicalPlan>(session.reader->header().plan);
  options.summary = std::move(summary).value();
  options.replay_seconds = static_cast<double>(session.reader->tick_count()) / options.rate_hz;
  if (!playback.is_temporary) options.replayed_file = playback.file;
  return options;
}

}  // namespace

Result<workbench::SourceChoice> scan_for(const std::string& session, const std::string& open_scan) {
  const auto reader = sim::SessionReader::open(session, modules::catalogue());
  if (!reader) return reader.error();
  workbench::SourceChoice scan;
  if (!workbench::has_own_scan(reader.value())) scan.path = open_scan;
  return scan;
}

void add_recordings(view::WindowHost& host, const std::string& language) {
  host.score = score, host.report = report;
  host.replay = [language](const std::string& session, const std::string& open_scan,
                           const workbench::Listener& listener) {
    std::vector<std::string> words{"replay", session, "--show"};
    if (!language.empty()) words.insert(words.end(), {"--language", language});
    return run_with_scan(std::move(words), session, open_scan, listener.progress("replay"));
  };
}

Status play_in_window(workbench::OpenedSession& session, const Playback& playback,
                      const DisplayArguments& display, workbench::OpenedSession* companion,
                      const Playback& companion_playback) {
  auto opened = replay_options(session, playback);
  if (!opened) return opened.error();
  view::WindowOptions& options = opened.value();
  options.may_take_over = true;
  if (Status error = choose_display(display, options)) return error;
  if (companion) {
    auto second = replay_options(*companion, companion_playback);
    if (!second) return second.error();
    options.companion = std::make_shared<const view::WindowOptions::Companion>(
        view::WindowOptions::Companion{view::borrowed(companion->scene()), std::move(second).value()});
  }
  const auto shown = view::run_window(view::borrowed(session.scene()), options);
  if (!shown) return shown.error();
  if (!shown.value().taken_over_at) return std::nullopt;
  return operate_from(playback.file, playback.scan, *shown.value().taken_over_at, options.rate_hz, display);
}

Result<view::WindowReport> continue_in_window(workbench::ContinuedSession continued, const std::string& scan,
                                              const std::vector<std::string>& in_use,
                                              const workbench::ChosenDevices& devices,
                                              const DisplayArguments& display) {
  const sim::SessionHeader& header = continued.header();
  const auto scene = continued.engine.servo_scene()->hands[0].scene;
  view::WindowOptions options;
  options.catalogue = &modules::catalogue();
  options.should_close = is_interrupted;
  options.title = continued.session->source.written_name();
  options.rate_hz = header.rate_hz;
  options.force = header.force;
  options.recorder = continued.writer.get();
  options.session_file = in_use.front();
  options.in_use = in_use;
  options.plan = std::make_shared<const volume::SurgicalPlan>(header.plan);
  options.start = view::WindowStart{std::move(continued.engine), continued.first_tick};
  options.scan = scan;
  // The summary has the mean position of the work so far: the camera starts on this side.
  if (auto summary = workbench::summarize_session(in_use.front()))
    options.summary = std::move(summary).value();
  options.device = devices.device;
  options.left_device = devices.left;
  options.pedal = devices.pedal;
  if (Status error = choose_display(display, options)) return *error;
  add_recordings(options.host, display.language);
  return view::run_window(scene, options);
}

}  // namespace trephine::cli
