// run: a script of an operation, played and checked.
#include <filesystem>

#include "apps/trephine/commands.h"
#include "apps/trephine/outputs.h"
#include "apps/view/render_window.h"
#include "apps/view/view_window.h"
#include "apps/workbench/catalogue.h"
#include "apps/workbench/script.h"
#include "data-tools/atomic_file.h"
#include "data-tools/open_volume.h"
#include "volume/operated_volume.h"

namespace trephine::app {

using volume::Error;
using volume::Result;
using volume::Status;

namespace {

struct RunArguments {
  std::string script, output;
  bool wants_window = false;
  workbench::RecordChoice record;
};

/// The session that was just played, in the window.
Status show(const std::string& session_file, const std::string& scan, const std::string& title) {
  auto opened = workbench::open_session(session_file, scan, person());
  if (!opened) return opened.error();
  workbench::OpenedSession& session = *opened.value();
  view::WindowOptions options;
  options.wants_to_end = is_interrupted;
  options.title = title;
  options.rate_hz = session.reader->header().rate_hz;
  options.replay = session.replay.get();
  options.replay_seconds = static_cast<double>(session.reader->tick_count()) / options.rate_hz;
  auto shown = view::run_window(view::borrowed(session.scene()), options);
  return shown ? std::nullopt : Status(shown.error());
}

/// Gone with the command.
struct TemporarySession {
  std::string file;
  ~TemporarySession() {
    std::error_code ignored;
    if (!file.empty()) std::filesystem::remove(file, ignored);
  }
};

Result<Outcome> run_script(const RunArguments& arguments) {
  if (arguments.wants_window && !view::has_display()) return view::no_display();
  if (Status error = check(arguments.record)) return *error;
  if (!arguments.output.empty()) {
    if (!data_tools::is_writable_volume_file(arguments.output))
      return Error{"this is no volume format that trephine writes", data_tools::file_name(arguments.output),
                   "", ".mha, .nrrd, .nii or .nii.gz", "choose one of these extensions"};
    if (Status error = data_tools::check_writable(arguments.output)) return *error;
  }
  auto script = data_tools::read_script(arguments.script);
  if (!script) return script.error();
  const std::string where = data_tools::file_name(arguments.script);
  const std::string folder = std::filesystem::path(arguments.script).parent_path().string();
  std::vector<std::string> in_use = workbench::files_of(script.value(), folder);
  in_use.insert(in_use.end(), {arguments.script, arguments.record.file});
  if (Status error = check_apart(arguments.output, in_use)) return *error;
  auto opened = workbench::ScriptRun::open(script.value(), folder, where, person());
  if (!opened) return opened.error();
  workbench::ScriptRun& run = *opened.value();

  workbench::RecordChoice record = arguments.record;
  TemporarySession temporary;
  if (arguments.wants_window && record.file.empty()) {
    temporary.file = record.file = workbench::autosave_path();
    record.is_embedding = true;
    if (record.file.empty())
      return Error{
          "there is no place for the session", "", "neither HOME nor XDG_STATE_HOME", "--record FILE", "",
          volume::ErrorKind::missing_here};
  }
  auto recorder = workbench::start_recording(record, run.operation());
  if (!recorder) return recorder.error();
  const auto begin = Clock::now();
  auto played = run.play(recorder.value().get(), person());
  if (!played) return played.error();
  const workbench::ScriptReport& report = played.value();
  if (!arguments.output.empty()) {
    auto result = volume::operated_volume(*run.engine().current());
    if (!result) return result.error();
    if (Status error = data_tools::write_volume(arguments.output, result.value())) return *error;
  }

  Outcome outcome{new_report("run"), "", report.is_met() ? exit_done : exit_check_failed};
  Json& json = outcome.json;
  json["script"] = where;
  json["title"] = script.value().title;
  json["ticks"] = report.ticks;
  json["seconds"] = report.seconds;
  json["played_seconds"] = seconds_since(begin);
  json["removed_mm3_total"] = run.engine().removed_mm3();
  json["strongest_force_n"] = report.strongest_force_n;
  json["content_hash"] = hash_text(run.engine().current()->content_hash());
  json["is_met"] = report.is_met();
  json["checks"] = Json::array();
  std::size_t failed = 0;
  for (const workbench::ScriptCheck& c : report.checks) {
    json["checks"].push_back(
        {{"line", c.line}, {"at_seconds", c.at}, {"what", c.what}, {"found", c.found}, {"is_met", c.is_met}});
    failed += !c.is_met;
    outcome.text += format_text("%s  line %d, at %.3f s: %s (%s)\n", c.is_met ? "ok    " : "FAILED", c.line,
                                c.at, c.what.c_str(), c.found.c_str());
  }
  outcome.text += format_text("%.1f s played in %.1f s, %.2f mm3 removed, at most %.2f N: ", report.seconds,
                              seconds_since(begin), run.engine().removed_mm3(), report.strongest_force_n);
  outcome.text += failed == 0 ? format_text("all of %zu checks met\n", report.checks.size())
                              : format_text("%zu of %zu checks FAILED\n", failed, report.checks.size());
  if (!arguments.output.empty()) outcome.text += "written to " + arguments.output + "\n";
  if (report.recording) {  // what was played and written stays
    notice("note: " + report.recording->message());
    json["recording"] = report.recording->message();
    if (report.is_met()) outcome.exit_code = exit_code_of(*report.recording);
    return outcome;
  }
  if (arguments.wants_window)
    if (Status error = show(record.file, "", script.value().title.empty() ? where : script.value().title))
      return *error;
  if (is_interrupted()) outcome.exit_code = exit_interrupted;
  return outcome;
}

Run build(Options& options) {
  auto a = std::make_shared<RunArguments>();
  options.add("SCRIPT", a->script, "Scan, hands, commands and expectations: docs/file-formats.md").required();
  options.add("-o,--output", a->output, "Write what is left at the end: .mha, .nrrd, .nii or .nii.gz");
  options.add("--window", a->wants_window, "Then play it in the window");
  add_record(options, a->record);
  return run_with(a, run_script);
}

}  // namespace

const Command k_run{"run", "Play a script of an operation and check what it expects; ends with 0 or 1",
                    "  trephine run docs/examples/burr-hole.toml\n"
                    "  trephine run docs/examples/burr-hole.toml --window --record burr-hole.session",
                    build};

}  // namespace trephine::app
