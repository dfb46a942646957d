#include <filesystem>

#include "apps/trephine/commands.h"
#include "apps/trephine/text.h"
#include "apps/view/render_window.h"
#include "apps/view/view_window.h"
#include "data-tools/atomic_file.h"
#include "volume/work_counters.h"

namespace trephine::app {

using volume::Error;
using volume::Result;

Result<Outcome> run_view(const ViewArguments& arguments) {
  if (volume::Status error = check_burr(arguments.burr_diameter)) return *error;
  if (arguments.screenshot.empty() && !view::has_display()) return view::no_display();
  if (!arguments.screenshot.empty()) {
    if (!data_tools::has_extension(arguments.screenshot, ".png"))
      return Error{"this is no picture format that trephine writes",
                   data_tools::file_name(arguments.screenshot), "", ".png", "choose this extension"};
    if (volume::Status error = data_tools::check_writable(arguments.screenshot)) return *error;
  }
  if (arguments.seconds && !view::has_display())
    notice("note: there is no display; the picture is drawn without a window");
  auto opened = open_source(arguments.source);
  if (!opened) return opened.error();
  Source& source = opened.value();
  auto scene = make_scene(source, arguments.shape);
  if (!scene) return scene.error();
  // The recording that was asked for, or one for the time when something goes wrong.
  const bool has_window = view::has_display() && (arguments.screenshot.empty() || arguments.seconds);
  RecordChoice record = arguments.record;
  const bool is_autosave = record.file.empty() && has_window && !arguments.has_no_autosave;
  if (is_autosave) record.file = autosave_path();
  haptics::ServoOptions servo;
  drilling::BurrOptions burr;
  burr.radius = 0.5 * arguments.burr_diameter;
  std::unique_ptr<sim::SessionWriter> recorder;
  if (has_window) {
    auto started = start_recording(record, source, scene.value(), haptics::ImplicitProxy(), servo, burr);
    if (!started && !is_autosave) return started.error();
    if (!started) notice("note: the session is not saved: " + started.error().message());
    if (started) recorder = std::move(started).value();
  } else if (!record.file.empty()) {
    return Error{"without a window there is nothing to record", "--record", "", "a display", ""};
  }
  view::WindowOptions options;
  options.recorder = recorder.get();
  options.burr.radius = 0.5 * arguments.burr_diameter;
  options.seconds = arguments.seconds;
  options.screenshot = arguments.screenshot;
  options.title = source.name;
  // A screenshot alone needs no window; --seconds asks for one.
  options.is_offscreen = !view::has_display() || (!arguments.screenshot.empty() && !arguments.seconds);
  auto shown = view::run_window(scene.value(), options);
  if (!shown) return shown.error();
  const view::WindowReport& r = shown.value();
  Outcome outcome{new_report("view"), "", exit_done};
  outcome.json["source"] = source.name;
  outcome.json["is_offscreen"] = options.is_offscreen;
  outcome.json["first_frame_seconds"] = r.first_frame_seconds;
  outcome.json["frames"] = r.frames;
  outcome.json["frame_ms"] = {{"p50", r.frame_p50_ms}, {"p99", r.frame_p99_ms}};
  outcome.json["triangles"] = r.triangles;
  outcome.json["counters"] = {{"surfaces_made", volume::work_counters().surfaces.load()},
                              {"gl_contexts_made", volume::work_counters().gl_contexts.load()}};
  outcome.json["removed_mm3_total"] = r.removed_mm3;
  outcome.json["strokes"] = r.strokes;
  outcome.json["servo"] = {{"ticks", r.servo.ticks},
                           {"overruns", r.servo.overruns},
                           {"step_p50_us", r.servo.step_p50_us},
                           {"step_p99_us", r.servo.step_p99_us},
                           {"faults", r.servo.faults}};
  outcome.text =
      format_text("%zu triangles; frames: %d, the first after %.2f s, removed: %.1f mm3, strokes: %zu\n",
                  r.triangles, r.frames, r.first_frame_seconds, r.removed_mm3, r.strokes);
  if (r.recording) notice("note: " + r.recording->message());
  if (is_autosave && recorder && r.strokes == 0 && r.removed_mm3 == 0) {
    recorder.reset();
    std::error_code ignored;
    std::filesystem::remove(record.file, ignored);  // nothing was done in it
  } else if (recorder) {
    outcome.json["session"] = data_tools::file_name(record.file);
    outcome.text += "session: " + record.file + "  (again: trephine replay, onward: trephine resume)\n";
  }
  if (!r.servo.notice.empty()) notice("note: " + r.servo.notice);
  return outcome;
}

}  // namespace trephine::app
