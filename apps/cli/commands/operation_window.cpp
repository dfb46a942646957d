#include "apps/cli/commands/operation_window.h"

#include <charconv>

#include "apps/cli/commands/session_window.h"
#include "apps/cli/commands/window_devices.h"
#include "apps/view/render_window.h"
#include "apps/view/view_window.h"
#include "apps/workbench/continued_session.h"
#include "apps/workbench/preset.h"
#include "data-tools/cases/procedure_file.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "modules/catalogue.h"
#include "volume/base/text.h"
#include "volume/base/work_counters.h"

namespace trephine::cli {

namespace {

/// Reads NAME=PERCENT.
Result<view::StructureOpacity> opacity_of(const std::string& words) {
  const std::size_t equals = words.rfind('=');
  double percent = -1;
  const char* end = words.data() + words.size();
  const bool is_read = equals != std::string::npos && equals > 0 &&
                       std::from_chars(words.data() + equals + 1, end, percent).ptr == end;
  if (!is_read || !(percent >= 0 && percent <= 100))
    return Error{.what = "the opacity is invalid",
                 .where = "--opacity",
                 .found = words,
                 .expected = "the name of a structure and a number from 0 to 100",
                 .remedy = "pass for example --opacity bone=30"};
  return view::StructureOpacity{words.substr(0, equals), 0.01 * percent};
}

/// Services for an open window: opens scans and sessions, and starts their recordings.
class Host {
 public:
  /// `choice`, `record`: requested at the start. Every later scene (of another scan, a further scan or
  /// another shape) is recorded in FILE-2, FILE-3 and so on, or in an autosave.
  Host(workbench::Source source, std::string path, workbench::OperationChoice choice,
       workbench::RecordChoice record)
      : source_(std::move(source)),
        path_(std::move(path)),
        choice_(std::move(choice)),
        record_(std::move(record)) {}

  Result<view::OpenedScene> open(const std::string& path, const workbench::Listener& listener) {
    workbench::SourceChoice scan(path);
    scan.uses_plan = true;
    auto opened = workbench::open_source(scan, listener);
    if (!opened) return opened.error();
    workbench::OperationChoice choice = choice_for(opened.value());
    Result<view::OpenedScene> result = make(opened.value(), path, choice, listener);
    if (!result) return result;
    source_ = std::move(opened).value(), path_ = path;
    choice_ = std::move(choice);
    return result;
  }

  /// Reopens the scan that was opened last, with a further scan to touch.
  Result<view::OpenedScene> add_scan(const std::string& path, const std::string& shape,
                                     const workbench::Listener& listener) {
    workbench::OperationChoice choice = choice_;
    choice.volumes.push_back({path, workbench::parse_shape(shape)});
    Result<view::OpenedScene> result = make(source_, path_, choice, listener);
    if (result) choice_ = std::move(choice);
    return result;
  }

  /// Continues a session. Uses the open scan if the session neither contains its scan nor names a built-in
  /// scan.
  Result<view::OpenedScene> resume(const std::string& session, const workbench::Listener& listener) {
    const auto scan = scan_for(session, path_);
    if (!scan) return scan.error();
    auto continued = workbench::continue_session(session, scan.value(), true, listener, choice_.hands.size());
    if (!continued) return continued.error();
    auto resumed_session = std::make_shared<workbench::ContinuedSession>(std::move(continued).value());
    const workbench::Source& source = resumed_session->session->source;
    view::OpenedScene opened{{std::move(resumed_session->engine), resumed_session->first_tick},
                             source.written_name(),
                             std::move(resumed_session->writer),
                             session,
                             {session, path_},
                             {},
                             resumed_session,
                             resumed_session->header().rate_hz,
                             resumed_session->header().force};
    opened.plan = std::make_shared<const volume::SurgicalPlan>(resumed_session->header().plan);
    opened.scan = scan.value().path;
    // A later change of the shape or a further scan begins with this scan.
    source_ = source, path_ = scan.value().path;
    choice_ = choice_for(source);
    return opened;
  }

  Result<view::OpenedScene> reshape(const view::ShapeRequest& request, const workbench::Listener& listener) {
    const auto range = [](double low, double high) {
      return format_text("%.17g:", low) + (std::isfinite(high) ? format_text("%.17g", high) : std::string());
    };
    workbench::Source source = source_;
    workbench::ShapeChoice shape_choice;
    if (request.preset.empty()) shape_choice.window = range(request.low, request.high);
    shape_choice.is_largest = request.is_largest;
    auto shape = workbench::prepare_shape(source, {request.preset, {}}, shape_choice, listener);
    if (!shape) return shape.error();
    // A table stays left out when the user changes the threshold of bone.
    const bool omits_holder = choice_.shape.omits_holder;
    if (omits_holder && !request.is_largest && !std::isfinite(shape.value().high) &&
        source.volume->is_hounsfield && !source.plan && !source.is_builtin)
      if (Status error = workbench::omit_holder(source, shape.value(), listener)) return *error;
    workbench::OperationChoice choice = choice_;
    choice.shape = {};
    choice.shape.omits_holder = omits_holder;
    choice.shape.window = range(shape.value().low, shape.value().high);
    Result<view::OpenedScene> result = make(source, path_, choice, listener);
    if (result) choice_ = std::move(choice);
    return result;
  }

 private:
  /// Returns the choice for another scan, without the shape, further scans and models of the last one.
  workbench::OperationChoice choice_for(const workbench::Source& source) const {
    workbench::OperationChoice choice = choice_;
    choice.shape = {};
    choice.shape.omits_holder = true;
    choice.volumes.clear(), choice.models.clear();  // positioned in the world of the first scan
    // The user can change this automatic threshold in the window.
    if (!source.plan) choice.shape.is_auto = true;
    return choice;
  }

  Result<view::OpenedScene> make(const workbench::Source& source, const std::string& path,
                                 const workbench::OperationChoice& choice,
                                 const workbench::Listener& listener) {
    auto operation = workbench::make_operation(source, choice, listener);
    if (!operation) return operation.error();
    workbench::RecordChoice record = record_;
    if (record.is_autosave)
      record.file = workbench::autosave_path();
    else if (!record.file.empty())
      record.file = format_text("%s-%d", record_.file.c_str(), ++scene_number_);
    auto recorder = workbench::start_recording(record, operation.value());
    if (!recorder) return recorder.error();
    view::OpenedScene opened{
        {operation.value().engine()}, source.written_name(), std::move(recorder).value(), "", {path}, {}, {}};
    if (opened.recorder) opened.session_file = record.file;
    opened.force = operation.value().spec.force;
    opened.scan = path;
    opened.plan = std::make_shared<const volume::SurgicalPlan>(operation.value().spec.plan);
    if (source.plan) opened.models = source.plan->models;
    return opened;
  }

  workbench::Source source_;
  std::string path_;
  workbench::OperationChoice choice_;
  workbench::RecordChoice record_;
  int scene_number_ = 1;  ///< N in the name FILE-N of the newest recording; 1: FILE itself
};

}  // namespace

Result<Outcome> run_operation_window(const WindowArguments& arguments, const char* name) {
  if (arguments.seconds && !(*arguments.seconds > 0 && *arguments.seconds <= 1e6))
    return Error{.what = "the time is out of range",
                 .where = "--seconds",
                 .found = rounded_text(*arguments.seconds),
                 .expected = "above 0, at most 1000000 s"};
  if (Status error = check(arguments.record)) return *error;
  if (arguments.screenshot.empty() && !view::has_display()) return view::no_display();
  data_tools::OutputSet outputs;
  outputs.add_input(arguments.source.path);
  if (data_tools::is_procedure_path(arguments.procedure)) outputs.add_input(arguments.procedure);
  for (const std::string& file : arguments.models.files()) outputs.add_input(file);
  if (!arguments.display.head_tracker.starts_with("udp:")) outputs.add_input(arguments.display.head_tracker);
  outputs.add_output("screenshot", arguments.screenshot, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  if (arguments.seconds && !view::has_display())
    notice("note: no display; the picture is drawn without a window");
  // A screenshot alone needs no window; --seconds requests one.
  const bool is_offscreen = !view::has_display() || (!arguments.screenshot.empty() && !arguments.seconds);
  auto devices = open_window_devices(arguments.device, arguments.display.language, !is_offscreen);
  if (!devices) return devices.error();
  workbench::OperationChoice choice;
  choice.shape = arguments.shape;
  choice.procedure = arguments.procedure;
  choice.procedure_use = workbench::ProcedureUse::begins_without_tools;
  choice.shape.omits_holder = !choice.shape.is_set();
  choice.hands[0] = sim::HandSpec(drilling::burr(arguments.burr));
  choice.hands[0].effects = arguments.effects;
  choice.devices = workbench::capabilities_of(devices.value());
  if (devices.value().left) choice.hands.emplace_back();  // takes an instrument in the window
  if (Status error = choose_models(arguments.models, choice)) return *error;
  if (!choice.tools.empty()) choice.hands[0].instrument.clear(), choice.hands[0].parameters.clear();
  if (arguments.models.is_any()) choice.hands[0].method = haptics::general_method(*choice.hands[0].tool).name;
  // The user may choose another burr in the window. Cuts are therefore sampled for a burr of 2 mm, unless
  // --smallest-burr requests another size or the first burr is smaller. With --round, but without
  // --smallest-burr, they are sampled for the first burr.
  constexpr double k_fine_burr = 2;
  choice.smallest_burr = arguments.smallest_burr;
  if (!arguments.smallest_burr && !arguments.burr.is_round)
    choice.smallest_burr = std::min(2 * arguments.burr.body().min_radius(), k_fine_burr);
  std::vector<std::string> notices;
  workbench::Listener listener = terminal_listener();
  listener.notice = [&notices, print = listener.notice](const std::string& text) {
    print(text);
    notices.push_back(text);
  };
  // Keep the scan as it was read: the window can choose another shape of it.
  workbench::SourceChoice scan = arguments.source;
  scan.uses_plan = true;
  auto original = workbench::open_source(scan, listener);
  if (!original) return original.error();
  auto opened = workbench::make_operation(original.value(), choice, listener);
  if (!opened) return opened.error();
  const workbench::Operation& operation = opened.value();
  const workbench::Source& source = operation.source;
  const std::shared_ptr<const haptics::TouchScene> scene = operation.scene();

  view::WindowOptions options;
  options.start = view::WindowStart{operation.engine()};
  options.force = operation.spec.force;
  options.notices = std::move(notices);
  options.catalogue = &modules::catalogue();
  options.device = devices.value().device;
  options.left_device = devices.value().left;
  options.pedal = devices.value().pedal;
  options.scan = arguments.source.path;
  options.in_use = {arguments.source.path};
  for (const workbench::ModelChoice& model : choice.models) options.in_use.push_back(model.file);
  options.seconds = arguments.seconds;
  options.should_close = is_interrupted;
  options.screenshot = arguments.screenshot;
  options.side = side_of(arguments.side);
  for (const std::string& words : arguments.opacities) {
    const auto opacity = opacity_of(words);
    if (!opacity) return opacity.error();
    options.opacities.push_back(opacity.value());
  }
  if (Status error = view::check_opacities(*scene, options.opacities, "--opacity")) return *error;
  if (Status error = choose_display(arguments.display, options)) return *error;
  options.has_tool = arguments.side.empty();  // a picture with --from shows only the anatomy and its plan
  options.plan = std::make_shared<const volume::SurgicalPlan>(operation.spec.plan);
  if (source.plan) options.models = source.plan->models;
  options.title = source.written_name();
  options.is_offscreen = is_offscreen;

  // The requested recording, or an autosave.
  workbench::RecordChoice record = arguments.record;
  const bool is_autosave = record.file.empty() && !options.is_offscreen && !arguments.has_no_autosave;
  if (is_autosave) {
    workbench::prune_autosaves();
    record.file = workbench::autosave_path();
    record.is_autosave = true;
  }
  if (options.is_offscreen && !record.file.empty())
    return Error{.what = "recording needs a window",
                 .where = "--record",
                 .expected = "a window",
                 .remedy = view::has_display() ? "pass --seconds too, so that a window opens"
                                               : "start trephine on a display"};
  if (is_autosave) options.host.interrupted_session = workbench::interrupted_autosave();
  auto started = workbench::start_recording(record, operation);
  if (!started && !is_autosave) return started.error();
  if (!started) notice("note: the session is not saved: " + started.error().message());
  const std::unique_ptr<sim::SessionWriter> recorder = started ? std::move(started).value() : nullptr;
  options.recorder = recorder.get();
  if (recorder) options.session_file = record.file;

  const auto host =
      std::make_shared<Host>(std::move(original).value(), arguments.source.path, choice, record);
  options.host.open = [host](const std::string& path, const workbench::Listener& listener) {
    return host->open(path, listener);
  };
  options.host.resume = [host](const std::string& session, const workbench::Listener& listener) {
    return host->resume(session, listener);
  };
  options.host.add_scan = [host](const std::string& path, const std::string& shape,
                                 const workbench::Listener& listener) {
    return host->add_scan(path, shape, listener);
  };
  options.host.session_folder = workbench::autosave_folder();
  add_recordings(options.host, arguments.display.language);
  options.host.reshape = [host](const view::ShapeRequest& shape, const workbench::Listener& listener) {
    return host->reshape(shape, listener);
  };

  const double ready_seconds = process_seconds();
  auto shown = view::run_window(scene, options);
  if (!shown) return shown.error();
  const view::WindowReport& r = shown.value();
  Outcome outcome(name, is_interrupted() ? exit_interrupted : exit_done);
  Json& json = outcome.json;
  json["source"] = name_in_report(source);
  json["is_offscreen"] = options.is_offscreen;
  json["window"] = r.window;
  json["first_frame_seconds"] = r.first_frame_seconds;
  json["open_to_touch_seconds"] = ready_seconds + r.first_frame_seconds;
  json["frames"] = r.frames, json["frames_skipped"] = r.frames_skipped;
  json["frame_ms"] = {{"p50", r.frame_p50_ms}, {"p99", r.frame_p99_ms}};
  json["drilling_frames"] = r.drilling_frames;
  if (arguments.burr.is_round)
    json["round_tool"] = {{"touch_radius_mm", scene->tool->radius()},
                          {"field_updates", r.offset_updates},
                          {"longest_update_s", r.longest_offset_update_seconds}};
  json["edits"] = {{"longest_tick_ms", 1e3 * r.edits.longest_tick_seconds},
                   {"longest_command_ms", 1e3 * r.edits.longest_command_seconds},
                   {"longest_command", r.edits.longest_command}};
  json["drilling_frame_ms"] = {{"p50", r.drilling_p50_ms}, {"p99", r.drilling_p99_ms}};
  json["triangles"] = r.triangles;
  json["counters"] = {{"surfaces_made", work_counters().surfaces.load()},
                      {"gl_contexts_made", work_counters().gl_contexts.load()}};
  json["removed_mm3_total"] = r.removed_mm3;
  json["strokes"] = r.strokes;
  json["servo"] = {{"ticks", r.servo.ticks},
                   {"overruns", r.servo.overruns},
                   {"step_p50_us", r.servo.step_p50_us},
                   {"step_p99_us", r.servo.step_p99_us},
                   {"late_p50_us", r.servo.late_p50_us},
                   {"late_p99_us", r.servo.late_p99_us},
                   {"faults", r.servo.faults},
                   {"force_faults", r.force_faults}};
  outcome.print(
      "{triangles} triangles; frames: {frames}, the first after {first_frame_seconds:.2f} s, removed: "
      "{removed_mm3_total:.1f} mm³, strokes: {strokes}");
  if (r.recording_error) notice("note: " + r.recording_error->message());
  if (recorder && (!is_autosave || recorder->has_edits())) {
    json["is_recorded"] = true;
    outcome.print("session: {path}  (repeat: trephine replay, continue: trephine resume)",
                  {{"path", record.file}});
  }
  if (!r.servo.notice.empty()) notice("note: " + r.servo.notice);
  return outcome;
}

}  // namespace trephine::cli
