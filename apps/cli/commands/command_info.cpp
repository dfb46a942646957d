// info: lists the contents of a scan, a case or a session.
#include <algorithm>
#include <glm/geometric.hpp>
#include <sstream>
#include <utility>

#include "apps/cli/commands.h"
#include "apps/cli/commands/frame_json.h"
#include "apps/cli/commands/quality_report.h"
#include "apps/workbench/event_text.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "data-tools/meshes/mesh_reading.h"
#include "modules/catalogue.h"
#include "sim/api/forbidden.h"
#include "volume/cuts/shape_choice.h"

namespace trephine::cli {

namespace {

struct InfoArguments {
  workbench::SourceChoice source;
  bool is_listing = false, has_quality = false;
  std::string chart;
};

/// Returns the settings of a header: its encoded lines from "smoothing_alpha=" to the end, without the lines
/// of types and modules.
std::vector<std::string> setting_lines_of(const sim::SessionHeader& header) {
  std::istringstream lines(sim::encode(header));
  std::vector<std::string> settings;
  bool is_setting = false;
  for (std::string line; std::getline(lines, line);) {
    is_setting = is_setting || line.starts_with("smoothing_alpha=");
    if (is_setting && !line.starts_with("type=") && !line.starts_with("module=")) settings.push_back(line);
  }
  return settings;
}
/// Prints the names of a plan, one line for each kind of object. The list `settings` of --json has all
/// values.
void print_plan(const volume::SurgicalPlan& plan, Outcome& outcome) {
  const auto print_names = [&outcome](const char* kind, const auto& objects) {
    std::string names;
    for (const auto& object : objects) names += (names.empty() ? "" : ", ") + object.name;
    if (!names.empty()) outcome.print("  planned {kind}: {names}", {{"kind", kind}, {"names", names}});
  };
  print_names("trajectories", plan.trajectories);
  print_names("landmarks", plan.landmarks);
  print_names("outlines", plan.outlines);
  print_names("planes", plan.planes);
  print_names("targets", plan.targets);
  if (!plan.procedure.is_empty()) outcome.print("  procedure: {title}", {{"title", plan.procedure.title}});
}

Result<Outcome> describe_session(const std::string& path) {
  Result<sim::SessionReader> opened = sim::SessionReader::open(path, modules::catalogue());
  if (!opened) return opened.error();
  sim::SessionReader& session = opened.value();
  const sim::SessionHeader& h = session.header();
  std::uint64_t ticks = 0, contact = 0, undos = 0, redos = 0, dropped = 0, versions = 0, last = 0;
  std::uint32_t faults = 0;
  Json events = Json::array();
  double strongest = 0;
  std::int64_t units = 0;
  bool has_last = false;
  std::uint64_t* counted = nullptr;  // the count to which the last command belongs
  const auto add_event = [&](std::uint64_t tick, int hand, const std::string& text) {
    events.push_back(
        {{"after_seconds", static_cast<double>(tick) / h.rate_hz}, {"hand", hand}, {"text", text}});
  };
  for (sim::LogItem item;;) {
    const Result<bool> read = session.next(item);
    if (!read) return read.error();
    if (!read.value()) break;
    if (const auto* tick = std::get_if<sim::TickItem>(&item)) {
      const haptics::ServoRecord& r = tick->record;
      counted = nullptr;
      if (r.hand == 0) {
        if (has_last && r.tick > last) dropped += r.tick - last - 1;
        last = std::max(last, r.tick);
        has_last = true;
        ++ticks;
      }
      contact += r.has_contact;
      faults |= r.raised;
      strongest = std::max(strongest, glm::length(r.force_world));
    } else if (const auto* command = std::get_if<sim::CommandItem>(&item)) {
      const sim::Value& request = command->command.request;
      counted = request.as<sim::Undo>() ? &undos : request.as<sim::Redo>() ? &redos : nullptr;
      if (counted) ++*counted;
      if (const auto* remark = request.as<sim::Note>()) add_event(last, command->command.hand, remark->text);
    } else if (const auto* event = std::get_if<sim::EventItem>(&item)) {
      add_event(event->event.tick, event->event.hand,
                workbench::describe_event(event->event, h.plan.procedure).text);
      // If a refusal follows an undo or a redo, this command was refused and is not counted.
      if (counted && event->event.value.as<sim::StepRefused>()) --*std::exchange(counted, nullptr);
    } else if (const auto* version = std::get_if<sim::VersionItem>(&item)) {
      ++versions;
      units = version->removed_units;
    }
  }
  const double seconds = static_cast<double>(session.tick_count()) / h.rate_hz;
  Outcome outcome("info");
  Json& json = outcome.json;
  json["recorded_by"] = h.program;
  json["revision"] = h.revision;
  json["is_verifiable"] = h.revision == sim::k_replay_revision;
  json["case"] = h.case_name;
  json["has_scan"] = session.has_scan();
  json["scan_hash"] = session.scan_hash() ? hash_text(*session.scan_hash()) : std::string();
  const glm::ivec3 size = h.volumes[0].size;
  json["size"] = {size.x, size.y, size.z};
  json["rate_hz"] = h.rate_hz;
  json["method"] = h.hands[0].method;
  json["hands"] = h.hands.size();
  json["modules"] = Json::array();
  for (const sim::NamedVersion& module : h.modules)
    json["modules"].push_back({{"name", module.name}, {"version", module.version}});
  json["settings"] = setting_lines_of(h);
  json["seconds"] = seconds;
  json["ticks"] = ticks;
  json["dropped_ticks"] = dropped;
  json["contact_ticks"] = contact;
  json["strongest_force_n"] = strongest;
  json["undos"] = undos;
  json["redos"] = redos;
  json["versions"] = versions;
  json["removed_units"] = units;
  json["raised_faults"] = faults;
  json["events"] = events;
  json["is_closed"] = session.end().has_value();
  json["is_damaged"] = session.is_damaged();
  json["lost_bytes"] = session.lost_bytes();
  if (session.end()) json["removed_mm3"] = session.end()->removed_mm3;
  outcome.print("{file}: a session of " +
                    std::string(h.case_name.empty() ? "a scan without a name" : "case {case}") +
                    (session.has_scan() ? ", the scan included" : ""),
                {{"file", data_tools::file_name(path)}});
  outcome.print("  {seconds:.1f} s at {rate_hz:.0f} Hz, hands: {hands}, method {method}");
  outcome.print(
      "  in contact for {contact_seconds:.1f} s, at most {strongest_force_n:.2f} N; undone {undos}, redone "
      "{redos}",
      {{"contact_seconds", static_cast<double>(contact) / h.rate_hz}});
  outcome.print("  recorded by {recorded_by}");
  sim::SessionHeader without_plan = h;
  without_plan.plan = {};
  Json line = Json::array();  // settings of one line
  const auto print_settings = [&] {
    if (!line.empty()) outcome.print("  {line}", {{"line", line}});
    line.clear();
  };
  for (const std::string& setting : setting_lines_of(without_plan)) {
    if (setting.starts_with("structure=") || setting.starts_with("hand=")) print_settings();
    line.push_back(setting);
  }
  print_settings();
  print_plan(h.plan, outcome);
  for (std::size_t i = 0; i < std::min<std::size_t>(events.size(), 20); ++i)
    outcome.print("  at {after_seconds:.2f} s, hand {number}: {text}",
                  {{"after_seconds", events[i]["after_seconds"]},
                   {"number", events[i]["hand"].get<int>() + 1},
                   {"text", events[i]["text"]}});
  if (session.end()) outcome.print("  removed {removed_mm3:.2f} mm³ at its end");
  if (dropped > 0) outcome.print("  {dropped_ticks} ticks were dropped (full ring)");
  if (session.is_damaged())
    outcome.print("  damaged at byte {from}: the {lost_bytes} bytes from there on are ignored",
                  {{"from", session.complete_bytes()}});
  else if (sim::SessionWriter::is_being_written(path))
    outcome.print("  being recorded right now");
  else if (!session.end())
    outcome.print("  not closed: the program was stopped; continue with trephine resume");
  if (h.revision != sim::k_replay_revision)
    outcome.print("  recorded with another revision of the arithmetic: it can be viewed, not verified");
  return outcome;
}

/// Returns series as JSON. Descriptions, which may contain names, and dates are included with --keep-identity
/// only.
Json series_json(const std::vector<data_tools::SeriesFacts>& series) {
  Json list = Json::array();
  for (const data_tools::SeriesFacts& s : series) {
    list.push_back({{"series", s.series},
                    {"volume", s.volume},
                    {"modality", s.modality},
                    {"kernel", s.kernel},
                    {"mark", s.mark},
                    {"size", {s.size.x, s.size.y, s.size.z}},
                    {"spacing_mm", {s.spacing.x, s.spacing.y, s.spacing.z}},
                    {"is_localizer", s.is_localizer},
                    {"problem", s.problem}});
    if (!keeps_identity()) continue;
    list.back()["description"] = s.description;
    list.back()["date"] = s.date;
  }
  return list;
}

/// Reports series. The printed table always contains descriptions and dates.
void report_series(const std::vector<data_tools::SeriesFacts>& series, Outcome& outcome) {
  outcome.json["series"] = series_json(series);
  Json rows = outcome.json["series"];
  for (std::size_t i = 0; i < series.size(); ++i) {
    const data_tools::SeriesFacts& s = series[i];
    std::string kernel = s.kernel;  // DICOM separates several values by backslashes
    std::replace(kernel.begin(), kernel.end(), '\\', ' ');
    rows[i]["volume"] = s.volumes > 1 ? format_text("%d of %d", s.volume, s.volumes) : "-";
    rows[i]["kind"] = s.is_localizer ? "localizer" : s.modality;
    if (!s.problem.empty()) rows[i]["spacing_mm"] = nullptr;
    rows[i]["date"] = s.date, rows[i]["kernel"] = kernel;
    rows[i]["description"] = s.description + (s.mark.empty() ? "" : " (" + s.mark + ")") +
                             (s.problem.empty() ? "" : ": " + s.problem);
  }
  if (!series.empty())
    outcome.print_table(
        rows,
        "series = {series} | volume = {volume} | kind = {kind} | "
        "size = {size/0} x {size/1} x {size/2} | spacing, mm = {spacing_mm:.3g} | date = {date} | "
        "kernel = {kernel} | description = {description}");
}

/// Lists series and volumes without reading voxels.
Result<Outcome> list_series(const std::string& path) {
  const auto series = data_tools::list_series(path, terminal_listener().progress("reading headers"));
  if (!series) return series.error();
  Outcome outcome("info");
  report_series(series.value(), outcome);
  return outcome;
}

/// Reports structures, trajectories, landmarks and outlines of a plan.
void report_plan(const data_tools::CasePlan& plan, bool is_hounsfield, Outcome& outcome) {
  Json& json = outcome.json;
  for (const char* list : {"structures", "trajectories", "landmarks", "outlines"}) json[list] = Json::array();
  for (const data_tools::CaseStructure& s : plan.structures) {
    json["structures"].push_back({{"name", s.shape.name},
                                  {"shape", describe(s.shape, is_hounsfield)},
                                  {"touchable", s.is_touchable},
                                  {"forbidden", s.is_forbidden}});
    outcome.print(std::string("  structure {name}: {shape}") + (s.is_touchable ? "" : ", not touched") +
                      (s.is_forbidden ? ", forbidden" : ""),
                  json["structures"].back());
  }
  for (const volume::PlannedTrajectory& t : plan.trajectories) {
    json["trajectories"].push_back({{"name", t.name},
                                    {"entry", json_of(t.entry_world)},
                                    {"target", json_of(t.target_world)},
                                    {"diameter", t.diameter}});
    outcome.print("  trajectory {name}: {length:.1f} mm long" +
                      std::string(t.diameter > 0 ? ", {diameter:.3g} mm thick" : "") +
                      ", from ({entry:.1f}) to ({target:.1f})",
                  {{"name", t.name},
                   {"length", glm::length(t.target_world - t.entry_world)},
                   {"diameter", t.diameter},
                   {"entry", json_of(t.entry_world)},
                   {"target", json_of(t.target_world)}});
  }
  for (const volume::PlannedLandmark& l : plan.landmarks) {
    json["landmarks"].push_back({{"name", l.name}, {"at", json_of(l.position_world)}});
    outcome.print("  landmark {name}: ({at:.1f}) mm", json["landmarks"].back());
  }
  for (const volume::PlannedOutline& o : plan.outlines) {
    json["outlines"].push_back({{"name", o.name}, {"positions", o.points_world.size()}});
    outcome.print("  outline {name}: {positions} positions", json["outlines"].back());
  }
}

/// Reports further volumes and models of a case. Error if a model cannot be used.
Status report_files(const data_tools::CasePlan& plan, Outcome& outcome) {
  Json& json = outcome.json;
  for (const char* list : {"volumes", "models"}) json[list] = Json::array();
  for (const data_tools::CaseVolume& volume : plan.volumes) {
    json["volumes"].push_back({{"name", volume.name}, {"file", volume.file}});
    outcome.print("  volume {name}: {file}", json["volumes"].back());
  }
  for (const data_tools::CaseModel& model : plan.models) {
    const auto read = data_tools::read_polygon_model(model.path);
    if (!read) return read.error();
    if (model.is_forbidden) {
      const haptics::MeshTree surface(read.value().vertices, read.value().triangles);
      if (const auto solid = sim::Forbidden::build(model.name, surface, {}); !solid) return solid.error();
    }
    json["models"].push_back({{"name", model.name},
                              {"file", model.file},
                              {"matter", volume::k_matters[static_cast<std::size_t>(model.matter)]},
                              {"triangles", read.value().triangles.size() / 3},
                              {"touchable", model.is_touchable},
                              {"forbidden", model.is_forbidden},
                              {"notices", read.value().notices}});
    outcome.print(std::string("  model {name}: {file}, {matter}, {triangles} triangles") +
                      (model.is_touchable ? "" : ", not touched") + (model.is_forbidden ? ", forbidden" : ""),
                  json["models"].back());
    for (const std::string& notice : read.value().notices) outcome.print("    " + notice);
  }
  return std::nullopt;
}

Result<Outcome> run_info(const InfoArguments& arguments) {
  const bool wants_quality = arguments.has_quality || !arguments.chart.empty();
  const bool is_session = workbench::is_session_file(arguments.source.path);
  if (wants_quality && (arguments.is_listing || is_session))
    return Error{.what = "quality is measured for one scan at a time",
                 .where = "quality",
                 .found = is_session ? "a session" : "a list",
                 .expected = "a scan or a case",
                 .remedy = is_session ? "pass the scan of the session" : "omit --list"};
  if (arguments.is_listing && data_tools::is_case_folder(arguments.source.path))
    return Error{.what = "a case contains one scan and no series",
                 .where = "list",
                 .found = "a case",
                 .expected = "a DICOM folder",
                 .remedy = "omit --list"};
  if (arguments.is_listing) return list_series(arguments.source.path);
  if (is_session) return describe_session(arguments.source.path);
  data_tools::OutputSet outputs;
  outputs.add_input(arguments.source.path);
  outputs.add_output("chart", arguments.chart, data_tools::OutputKind::chart);
  if (Status error = outputs.check()) return *error;
  auto opened = workbench::open_source(arguments.source, terminal_listener());
  if (!opened) return opened.error();
  const workbench::Source& source = opened.value();
  const volume::Volume& v = *source.volume;
  if (v.is_hounsfield && !source.plan)
    workbench::report_large_parts(source, volume::Shape(), terminal_listener());
  const auto [low, high] = std::minmax_element(v.voxels.span().begin(), v.voxels.span().end());
  double sum = 0;
  for (const std::int16_t i : v.voxels.span()) sum += i;
  const double mean = sum / static_cast<double>(v.voxels.size());
  Outcome outcome("info");
  Json& json = outcome.json;
  json["source"] = name_in_report(source);
  json["format"] = source.format;
  json["modality"] = source.modality;
  json.update(frame_json(v));
  json["is_orthogonal"] = v.frame.is_orthogonal();
  json["is_hounsfield"] = v.is_hounsfield;
  json["min"] = *low;
  json["max"] = *high;
  json["mean"] = mean;
  json["labels"] = v.label_names;
  const glm::dvec3 near = v.frame.origin(), far = v.frame.world_from_volume(glm::dvec3(v.size - 1));
  outcome.print(std::string("{name}: {format}") + (source.modality.empty() ? "" : ", {modality}"),
                {{"name", source.name}});
  outcome.print(std::string("  ") + k_size_line);
  outcome.print(std::string("  from ({near:.1f}) to ({far:.1f}) mm, patient frame LPS") +
                    (v.frame.is_orthogonal() ? "" : ", sheared"),
                {{"near", json_of(near)}, {"far", json_of(far)}});
  outcome.print(std::string("  values {min} to {max}") + (v.is_hounsfield ? " HU" : ", not known to be HU") +
                ", mean {mean:.1f}");
  if (source.plan) {
    report_plan(*source.plan, v.is_hounsfield, outcome);
    if (Status error = report_files(*source.plan, outcome)) return *error;
  }
  // Report the quality that the case stores, unless --quality or --chart requests a measurement.
  std::optional<data_tools::ScanQuality> quality;
  volume::Shape shape;
  if (source.plan && !source.plan->structures.empty()) shape = source.plan->structures[0].shape;
  if (source.plan) quality = source.plan->quality;
  if (wants_quality) {
    if (!v.is_hounsfield && !source.plan) shape.low = volume::otsu_threshold(v);
    if (shape.is_label())
      return Error{.what = "the quality of a label cannot be measured",
                   .where = "quality",
                   .found = shape.name,
                   .expected = "a case whose first structure is a range of intensities",
                   .remedy = "pass the scan instead of the case"};
    quality = data_tools::scan_quality(v, shape);
  }
  outputs.write(arguments.chart, [&] { return write_quality_chart(*quality, arguments.chart); });
  if (Status error = outputs.result()) return *error;
  json["facts"] = Json::object();
  for (const auto& [name, value] : source.facts) {
    json["facts"][name] = value;
    if (name != "modality") outcome.print("  {name}: {value}", {{"name", name}, {"value", value}});
  }
  report_series(source.series, outcome);
  if (quality) report_quality(*quality, v.is_hounsfield, shape.low, outcome);
  json["notices"] = source.notices;
  json["read_seconds"] = source.read_seconds;
  if (!v.label_names.empty()) outcome.print("  labels: {labels}");
  for (const data_tools::SegmentFacts& segment : source.segments)
    outcome.print(
        std::string("  segment {name}: value {value}") + (segment.layer > 0 ? ", layer {layer}" : ""),
        {{"name", segment.name}, {"value", segment.value}, {"layer", segment.layer}});
  return outcome;
}

Run build_info(Options& options) {
  auto a = std::make_shared<InfoArguments>();
  add_source(options, a->source).required();
  options.add("--quality", a->has_quality,
              "Also report blur, noise, the thinnest bone, and the smallest details that can be touched "
              "(see docs/accuracy.md)");
  options.add("--chart", a->chart, "As --quality, with a chart of the measured edges").type("PNG|SVG|CSV");
  options.add("--list", a->is_listing,
              "Only list the series and volumes of a DICOM folder, including incomplete ones");
  options.add_modules();
  return run_with(a, run_info);
}

}  // namespace

const Command k_info{"info", "List the contents of a scan, a case or a session",
                     "  trephine info SCANS/HEAD\n  trephine info head --json", build_info};

}  // namespace trephine::cli
