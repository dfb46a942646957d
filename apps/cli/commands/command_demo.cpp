// demo: touches a skull, slides over it, drills a burr hole, and shows it; plays docs/examples/demo.toml.
#include <filesystem>

#include "apps/cli/commands.h"
#include "apps/cli/commands/script_play.h"
#include "apps/cli/demo_script.h"
#include "apps/view/render_window.h"
#include "apps/view/view_window.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::cli {

namespace {

struct DemoArguments {
  std::string source = "head", output = "out";
  workbench::ShapeChoice shape;
  bool has_no_window = false;
  workbench::RecordChoice record;
};

Result<Outcome> run_demo(const DemoArguments& arguments) {
  if (Status error = check(arguments.shape)) return *error;
  auto script = data_tools::parse_script(k_demo_script, "demo.toml");
  if (!script) return script.error();
  ScriptRequest request;
  request.script = std::move(script).value();
  request.script.scan = arguments.source;
  request.script.iso = arguments.shape.iso;
  request.script.window = arguments.shape.window;
  request.script.label = arguments.shape.label;
  request.script.is_auto = arguments.shape.is_auto;
  request.script.is_largest = arguments.shape.is_largest;
  request.where = "demo.toml";
  request.record = arguments.record;
  request.is_live = true;
  request.pictures = arguments.output;
  request.in_use = workbench::files_of(request.script, "");
  const std::string report_file = (std::filesystem::path(arguments.output) / "report.json").string();
  request.in_use.push_back(arguments.record.file);
  request.outputs.push_back(report_file);
  notice("touching and drilling " + (arguments.source == "head" ? std::string("the built-in head")
                                                                : data_tools::file_name(arguments.source)));
  auto result = play_script(request);
  if (!result) return result.error();
  const PlayedScript& played = result.value();
  const workbench::ScriptReport& report = played.report;
  const workbench::Operation& operation = played.run->operation();
  const workbench::Source& source = operation.source;
  const workbench::Place& site = played.run->places()[0];
  const volume::Version& version = *report.state->undoable.version;
  const bool is_through = is_open(site, *operation.scene(), version);
  const double removed = report.measure("removed");

  Outcome outcome("demo", report.is_met() ? exit_done : exit_check_failed);
  Json& json = outcome.json;
  json["source"] = name_in_report(source);
  json["shape"] = volume::describe(operation.scene()->items[0].field.shape(), source.volume->is_hounsfield);
  json["ready_seconds"] = played.ready_seconds;
  json["live_seconds"] = report.seconds;
  json["drawing_seconds"] = played.drawing_seconds;
  json["ticks"] = report.ticks;
  json["contact_ticks"] = report.contact_ticks[0];
  json["max_force_n"] = report.strongest_force_n;
  json["bone_thickness_mm"] = site.thickness;
  json["removed_mm3_total"] = removed;
  Json by_label = Json::object();
  for (std::size_t i = 0; i < report.removed_mm3_by_label.size(); ++i)
    if (report.removed_mm3_by_label[i] > 0)
      by_label[i < source.volume->label_names.size() ? source.volume->label_names[i] : "all"] =
          report.removed_mm3_by_label[i];
  json["removed_mm3"] = by_label;
  json["is_through"] = is_through;
  json["changes"] = static_cast<int>(report.measure("changes"));
  const haptics::ServoReport& servo = played.live->servo;
  json["servo"] = servo_json(servo);
  json["servo"]["rate_hz"] = operation.spec.rate_hz;
  json["servo"]["stale_scene_resets"] = played.live->stalls;
  json["memory"] = memory_report(*operation.scene(), version);
  json["pictures"] = played.pictures;
  json["checks"] = checks_json(report);
  if (Status error = data_tools::write_file_atomically(report_file, text_of_json(json) + "\n")) return *error;
  if (!report.is_met()) print_checks(outcome);
  outcome.print(std::string("touched and drilled {name}: {removed_mm3_total:.0f} mm³ removed") +
                    (is_through ? ", the burr hole is through" : "") +
                    ", strongest force {max_force_n:.2f} N",
                {{"name", source.name}});
  outcome.print("servo: {servo/ticks} steps, p50 {servo/step_us/p50:.1f} us, p99 {servo/step_us/p99:.1f} us");
  outcome.print("pictures and report in {folder}/", {{"folder", arguments.output}});
  if (!servo.notice.empty()) notice("note: " + servo.notice);

  if (!arguments.has_no_window && view::has_display()) {
    view::WindowOptions options;
    options.title = source.name;
    options.start = view::WindowStart{operation.engine()};
    if (auto shown = view::run_window(operation.scene(), options); !shown) return shown.error();
  }
  return outcome;
}

Run build_demo(Options& options) {
  auto a = std::make_shared<DemoArguments>();
  options.add("SRC", a->source, "Scan to drill; the same sources as for info").shows_default();
  add_shape(options, a->shape);
  options.add("-o,--output", a->output, "Folder for pictures and report.json").shows_default();
  options.add("--no-window", a->has_no_window, "Do not open a window at the end");
  add_record(options, a->record);
  return run_with(a, run_demo);
}

}  // namespace

const Command k_demo{"demo", "Drill a burr hole automatically; write pictures and a report",
                     "  trephine demo\n  trephine demo SCANS/HEAD -o out-head --no-window", build_demo};

}  // namespace trephine::cli
