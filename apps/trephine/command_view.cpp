#include "apps/trephine/commands.h"
#include "apps/trephine/text.h"
#include "apps/view/render_window.h"
#include "apps/view/view_window.h"
#include "data-tools/atomic_file.h"
#include "haptics/proxy/subvoxel_proxy.h"
#include "volume/work_counters.h"

namespace trephine::app {

using volume::Error;
using volume::Result;

namespace {

/// What the window asks for while it is open: scans, and recordings of what is done to them.
class Host {
 public:
  /// `record`: what was asked for at the start; what is opened later goes on in FILE-2, FILE-3 and so on, or
  /// in autosaves.
  Host(Source source, RecordChoice record, bool is_autosaving, double smallest_burr)
      : source_(std::move(source)),
        record_(std::move(record)),
        is_autosaving_(is_autosaving),
        smallest_burr_(smallest_burr) {}

  Result<view::OpenedScene> open(const std::string& path, drilling::Burr burr) {
    Result<Source> opened = open_source(path);
    if (!opened) return opened.error();
    Source source = std::move(opened).value();
    ShapeChoice choice;
    // A person can move the window from here; a program would have been asked for a shape.
    if (!source.volume->is_hounsfield && !source.plan) choice.iso = brighter_half(*source.volume);
    Result<haptics::TouchScene> scene = make_scene(source, choice);
    if (!scene) return scene.error();
    source_ = std::move(source);
    return wrap(std::move(scene).value(), burr);
  }

  Result<view::OpenedScene> reshape(double low, double high, drilling::Burr burr) {
    ShapeChoice choice;
    choice.window =
        format_text("%.17g:", low) + (std::isfinite(high) ? format_text("%.17g", high) : std::string());
    Result<haptics::TouchScene> scene = make_scene(source_, choice);
    if (!scene) return scene.error();
    return wrap(std::move(scene).value(), burr);
  }

 private:
  static double brighter_half(const volume::Volume& v) {
    const auto [low, high] = std::minmax_element(v.voxels.span().begin(), v.voxels.span().end());
    return 0.5 * (*low + *high);
  }

  Result<view::OpenedScene> wrap(haptics::TouchScene scene, drilling::Burr burr) {
    view::OpenedScene opened;
    opened.title = source_.name;
    if (volume::Status error = make_ready_for(burr, {}, smallest_burr_, scene)) return *error;
    RecordChoice record = record_;
    if (is_autosaving_)
      record.file = autosave_path();
    else if (!record.file.empty())
      record.file = format_text("%s-%d", record_.file.c_str(), ++opened_);
    auto forbidden = forbidden_of(source_);
    if (!forbidden) return forbidden.error();
    opened.forbidden = forbidden.value().watched;
    if (!record.file.empty()) {
      auto started = start_recording(record, source_, scene, haptics::SubvoxelProxy(), {},
                                     drilling::burr(burr), {}, forbidden.value().told);
      if (!started) return started.error();
      opened.recorder = std::move(started).value();
      opened.session_file = record.file;
    }
    opened.scene = std::make_shared<const haptics::TouchScene>(std::move(scene));
    return opened;
  }

  Source source_;
  RecordChoice record_;
  bool is_autosaving_;
  double smallest_burr_;  ///< mm, of what may be chosen in the window
  int opened_ = 1;
};

}  // namespace

Result<Outcome> run_view(const ViewArguments& arguments) {
  if (volume::Status error = check_burr(arguments.burr_diameter)) return *error;
  if (arguments.screenshot.empty() && !view::has_display()) return view::no_display();
  if (!arguments.screenshot.empty()) {
    if (!data_tools::has_extension(arguments.screenshot, ".png"))
      return Error{"this is no picture format that trephine writes",
                   data_tools::file_name(arguments.screenshot), "", ".png", "choose this extension"};
    if (volume::Status error = data_tools::check_writable(arguments.screenshot)) return *error;
    if (volume::Status error = check_apart(arguments.screenshot, {arguments.source})) return *error;
  }
  if (arguments.seconds && !view::has_display())
    notice("note: there is no display; the picture is drawn without a window");
  auto opened = open_source(arguments.source);
  if (!opened) return opened.error();
  Source& source = opened.value();
  auto made = make_scene(source, arguments.shape);
  if (!made) return made.error();

  view::WindowOptions options;
  options.burr.diameter = arguments.burr_diameter;
  options.burr.is_round = arguments.is_round;
  // Other burrs may be chosen in the window: a fine one leaves its hole too, unless a finer yet is named.
  constexpr double k_fine_burr = 2;
  if (volume::Status error = make_ready_for(options.burr, arguments.smallest_burr,
                                            std::min(arguments.burr_diameter, k_fine_burr), made.value()))
    return *error;
  const auto scene = std::make_shared<const haptics::TouchScene>(std::move(made).value());
  options.seconds = arguments.seconds;
  options.wants_to_end = is_interrupted;
  options.screenshot = arguments.screenshot;
  options.title = arguments.screenshot.empty() ? source.name : source.written_name();
  // A screenshot alone needs no window; --seconds asks for one.
  options.is_offscreen = !view::has_display() || (!arguments.screenshot.empty() && !arguments.seconds);

  // The recording that was asked for, or one for the time when something goes wrong.
  RecordChoice record = arguments.record;
  const bool is_autosave = record.file.empty() && !options.is_offscreen && !arguments.has_no_autosave;
  if (is_autosave) {
    prune_autosaves();
    record.file = autosave_path();
    record.is_autosave = true;
  }
  if (options.is_offscreen && !record.file.empty())
    return Error{"without a window there is nothing to record", "--record", "", "a display", ""};
  auto forbidden = forbidden_of(source);
  if (!forbidden) return forbidden.error();
  options.forbidden = forbidden.value().watched;
  auto started = start_recording(record, source, *scene, haptics::SubvoxelProxy(), {},
                                 drilling::burr(options.burr), {}, forbidden.value().told);
  if (!started && !is_autosave) return started.error();
  if (!started) notice("note: the session is not saved: " + started.error().message());
  const std::unique_ptr<sim::SessionWriter> recorder = started ? std::move(started).value() : nullptr;
  options.recorder = recorder.get();
  if (recorder) options.session_file = record.file;

  const auto host = std::make_shared<Host>(source, record, is_autosave, scene->smallest_burr);
  options.host.open = [host, burr = options.burr](const std::string& path) { return host->open(path, burr); };
  options.host.reshape = [host, burr = options.burr](double low, double high) {
    return host->reshape(low, high, burr);
  };

  const double ready_seconds = process_seconds();
  auto shown = view::run_window(scene, options);
  if (!shown) return shown.error();
  const view::WindowReport& r = shown.value();
  Outcome outcome{new_report("view"), "", is_interrupted() ? exit_interrupted : exit_done};
  Json& json = outcome.json;
  json["source"] = source.name;
  json["is_offscreen"] = options.is_offscreen;
  json["window"] = r.window;
  json["first_frame_seconds"] = r.first_frame_seconds;
  json["open_to_touch_seconds"] = ready_seconds + r.first_frame_seconds;
  json["frames"] = r.frames;
  json["frame_ms"] = {{"p50", r.frame_p50_ms}, {"p99", r.frame_p99_ms}};
  json["drilling_frames"] = r.drilling_frames;
  if (arguments.is_round)
    json["round_tool"] = {{"touch_radius_mm", scene->tool_radius},
                          {"field_updates", r.offset_updates},
                          {"longest_update_s", r.longest_offset_update_seconds}};
  json["edits"] = {{"longest_tick_ms", 1e3 * r.edits.longest_tick_seconds},
                   {"longest_command_ms", 1e3 * r.edits.longest_command_seconds},
                   {"longest_command", r.edits.longest_command}};
  json["drilling_frame_ms"] = {{"p50", r.drilling_p50_ms}, {"p99", r.drilling_p99_ms}};
  json["triangles"] = r.triangles;
  json["counters"] = {{"surfaces_made", volume::work_counters().surfaces.load()},
                      {"gl_contexts_made", volume::work_counters().gl_contexts.load()}};
  json["removed_mm3_total"] = r.removed_mm3;
  json["strokes"] = r.strokes;
  json["servo"] = {{"ticks", r.servo.ticks},
                   {"overruns", r.servo.overruns},
                   {"step_p50_us", r.servo.step_p50_us},
                   {"step_p99_us", r.servo.step_p99_us},
                   {"late_p50_us", r.servo.late_p50_us},
                   {"late_p99_us", r.servo.late_p99_us},
                   {"faults", r.servo.faults}};
  outcome.text =
      format_text("%zu triangles; frames: %d, the first after %.2f s, removed: %.1f mm3, strokes: %zu\n",
                  r.triangles, r.frames, r.first_frame_seconds, r.removed_mm3, r.strokes);
  if (r.recording) notice("note: " + r.recording->message());
  if (recorder && (!is_autosave || recorder->has_edits())) {
    json["session"] = data_tools::file_name(record.file);
    outcome.text += "session: " + record.file + "  (again: trephine replay, onward: trephine resume)\n";
  }
  if (!r.servo.notice.empty()) notice("note: " + r.servo.notice);
  return outcome;
}

}  // namespace trephine::app
