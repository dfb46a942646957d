// run: plays a script of an operation and checks its expectations.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/cli/commands.h"
#include "apps/cli/commands/script_play.h"
#include "apps/cli/commands/session_window.h"
#include "apps/view/render_window.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "data-tools/formats/open_volume.h"

namespace trephine::cli {

namespace {

struct RunArguments {
  std::string script, scan, output, pictures, skill;
  std::optional<double> seed;
  bool wants_window = false, is_live = false;
  workbench::RecordChoice record;
};

/// Returns the simulated person who plays the script; nullopt: the script is played exactly.
Result<std::optional<workbench::Performance>> requested_performance(const RunArguments& arguments) {
  if (arguments.skill.empty()) {
    if (arguments.seed)
      return Error{.what = "a seed needs a skill",
                   .where = "--seed",
                   .expected = "--skill",
                   .remedy = "pass --skill novice, or omit --seed"};
    return std::optional<workbench::Performance>();
  }
  const workbench::Skill* skill = workbench::find_skill(arguments.skill);
  if (skill == nullptr) {
    std::string known;
    for (const workbench::Skill& one : workbench::skills())
      known.append(known.empty() ? "" : ", ").append(one.name);
    return Error{.what = "unknown skill", .where = "--skill", .found = arguments.skill, .expected = known};
  }
  constexpr double k_largest = 1e9;
  const double seed = arguments.seed.value_or(1);
  if (!(seed >= 0 && seed <= k_largest && seed == std::floor(seed)))
    return Error{.what = "the seed is out of range",
                 .where = "--seed",
                 .found = format_text("%g", seed),
                 .expected = "a whole number from 0 to 1000000000"};
  return std::optional(workbench::Performance{*skill, static_cast<std::uint64_t>(seed)});
}

Result<Outcome> run_script(const RunArguments& arguments) {
  if (arguments.wants_window && !view::has_display()) return view::no_display();
  auto script = data_tools::read_script(arguments.script);
  if (!script) return script.error();
  ScriptRequest request;
  request.script = std::move(script).value();
  if (!arguments.scan.empty()) {
    const bool is_builtin = workbench::is_builtin(arguments.scan);
    request.script.scan = is_builtin ? arguments.scan : std::filesystem::absolute(arguments.scan).string();
    request.script.uses_plan = request.script.uses_plan && is_builtin;
  }
  request.where = data_tools::file_name(arguments.script);
  request.folder = std::filesystem::path(arguments.script).parent_path().string();
  request.record = arguments.record;
  request.is_live = arguments.is_live;
  request.pictures = arguments.pictures;
  auto performance = requested_performance(arguments);
  if (!performance) return performance.error();
  request.performance = performance.value();
  request.wants_session = arguments.wants_window;
  request.in_use = workbench::files_of(request.script, request.folder);
  request.in_use.insert(request.in_use.end(), {arguments.script, arguments.record.file});
  data_tools::OutputSet outputs;
  for (const std::string& file : request.in_use) outputs.add_input(file);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::volume);
  if (Status error = outputs.check()) return *error;
  auto played = play_script(request);
  if (!played) return played.error();
  const workbench::ScriptReport& report = played.value().report;
  const volume::Version& version = *report.state->undoable.version;
  notify_resampled(version.base(), arguments.output);
  outputs.write(arguments.output, [&] { return data_tools::write_operated(arguments.output, version); });
  if (Status error = outputs.result()) return *error;

  const double removed = report.measure("removed");
  // Expectations that a simulated person does not meet are results, and do not make the command fail.
  Outcome outcome("run", report.is_met() || request.performance ? exit_done : exit_check_failed);
  Json& json = outcome.json;
  json["title"] = request.script.title;
  if (request.performance) {
    json["skill"] = request.performance->skill.name;
    json["seed"] = request.performance->seed;
  }
  json["ticks"] = report.ticks;
  json["seconds"] = report.seconds;
  json["played_seconds"] = played.value().played_seconds;
  json["removed_mm3_total"] = removed;
  json["strongest_force_n"] = report.strongest_force_n;
  json["content_hash"] = hash_text(version.content_hash());
  json["is_met"] = report.is_met();
  json["checks"] = checks_json(report);
  json["places"] = places_json(*played.value().run);
  if (!request.pictures.empty()) json["pictures"] = played.value().pictures;
  if (const auto& live = played.value().live) json["servo"] = servo_json(live->servo);
  const auto failed = std::count_if(report.checks.begin(), report.checks.end(),
                                    [](const workbench::ScriptCheck& check) { return !check.is_met; });
  print_checks(outcome, request.performance ? "missed" : "FAILED");
  outcome.print(std::string("{seconds:.1f} s played in {played_seconds:.1f} s, {removed_mm3_total:.2f} mm³ "
                            "removed, at most {strongest_force_n:.2f} N: ") +
                    (report.checks.empty() ? "the script has no expectations"
                     : failed == 0         ? "all of {count} checks met"
                     : request.performance ? "{failed} of {count} checks missed, which are only reported"
                                           : "{failed} of {count} checks FAILED"),
                {{"failed", failed}, {"count", report.checks.size()}});
  if (!arguments.output.empty()) outcome.print("wrote {path}", {{"path", arguments.output}});
  if (!request.pictures.empty() && played.value().pictures.empty())
    outcome.print("no pictures written: the script has no [[pictures]]");
  if (!played.value().pictures.empty())
    outcome.print(
        std::string("{count} picture") + (played.value().pictures.size() == 1 ? "" : "s") + " in {folder}/",
        {{"count", played.value().pictures.size()}, {"folder", request.pictures}});
  if (report.recording_error) {  // the recording failed; other outputs are kept
    notice("note: " + report.recording_error->message());
    json["recording"] = report.recording_error->message();
    if (report.is_met()) outcome.exit_code = exit_code_of(*report.recording_error);
    return outcome;
  }
  if (arguments.wants_window) {
    const std::string scan = workbench::scan_of(request.script, request.folder);
    auto session = workbench::open_session(played.value().session, scan, terminal_listener());
    if (!session) return session.error();
    if (Status error = play_in_window(
            *session.value(),
            {played.value().session, scan, request.script.title.empty() ? "script" : request.script.title,
             !played.value().temporary.path.empty()},
            {}))
      return *error;
  }
  if (is_interrupted()) outcome.exit_code = exit_interrupted;
  return outcome;
}

Run build_run(Options& options) {
  auto a = std::make_shared<RunArguments>();
  options.add("SCRIPT", a->script, "Scan, hands, commands and expectations: docs/file-formats.md").required();
  options.add("--scan", a->scan, "A scan or a case to use instead of that of the script").type("SRC");
  options.add(
      "-o,--output", a->output,
      "Write the remaining volume at the end: " + data_tools::extensions_of(data_tools::OutputKind::volume));
  options.add("--pictures", a->pictures, "Write the script's pictures to this folder").type("FOLDER");
  options
      .add("--skill", a->skill,
           "Play as a simulated person: novice, trained or expert; expectations are then only reported")
      .type("SKILL");
  options.add("--seed", a->seed, "Seed of the person's errors (default: 1)").type("N");
  options.add("--live", a->is_live, "Play the script on a servo thread in real time");
  options.add("--show", a->wants_window, "Play the result in the window");
  add_record(options, a->record);
  options.add_modules();
  return run_with(a, run_script);
}

}  // namespace

const Command k_run{
    "run",
    "Play a script of an operation and check its expectations; exits with 0 if all are met, else with 1",
    "  trephine run docs/examples/burr-hole.toml\n"
    "  trephine run docs/examples/burr-hole.toml --show --record burr-hole.session\n"
    "  trephine run docs/examples/demo.toml --live --pictures out",
    build_run};

}  // namespace trephine::cli
