// import: writes a scan as a case folder.
#include <array>
#include <filesystem>
#include <glm/geometric.hpp>
#include <sstream>

#include "apps/cli/commands.h"
#include "apps/cli/commands/quality_report.h"
#include "apps/view/view_window.h"
#include "apps/workbench/operation.h"
#include "apps/workbench/preset.h"
#include "data-tools/cases/case_folder.h"
#include "data-tools/cases/label_file.h"
#include "data-tools/cases/phantom_cases.h"
#include "data-tools/cases/plan_file.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "data-tools/files/words.h"
#include "modules/catalogue.h"

namespace trephine::cli {

namespace {

struct ImportArguments {
  workbench::SourceChoice source;
  std::string output, name, labels, screenshot;
  std::vector<std::string> plans;
  std::string forbid, side;
  workbench::ShapeChoice shape;
  workbench::PresetChoice preset;
};

/// Reads labels from a file and resamples them to `scan`.
Status add_labels(volume::Volume& scan, const std::string& file) {
  data_tools::OpenOptions options;
  options.progress = terminal_listener().progress("reading the labels");
  auto read = data_tools::read_labels(file, scan, options);
  if (!read) return read.error();
  for (const std::string& text : read.value().notices) notice("note: " + text);
  scan.labels = std::move(read.value().labels);
  scan.label_names = std::move(read.value().names);
  scan.label_colours = std::move(read.value().colours);
  return std::nullopt;
}

/// Returns the reason why a trajectory is implausible, as if its unit, frame or patient were wrong; empty if
/// it is plausible.
std::string implausibility_of(const volume::PlannedTrajectory& t, const volume::Volume& scan,
                              const data_tools::CasePlan& plan) {
  const double length = glm::length(t.target_world - t.entry_world);
  if (length < 8 || length > 200) return format_text("is %.3g mm long: are its numbers in mm?", length);
  if (t.diameter > 15 || (t.diameter > 0 && t.diameter < 0.5))
    return format_text("is %.3g mm thick: are its numbers in mm?", t.diameter);
  if (plan.structures.empty() || plan.structures[0].shape.is_label()) return "";
  for (double mm = 0; mm <= length; mm += 0.5) {
    const glm::ivec3 p(
        glm::floor(scan.frame.volume_from_world(glm::mix(t.entry_world, t.target_world, mm / length)) + 0.5));
    if (scan.contains(p) &&
        plan.structures[0].shape.is_solid(scan.window_voxels()[scan.index(p.x, p.y, p.z)]))
      return "";
  }
  return "meets no " + plan.structures[0].shape.name +
         " along its length: is it the plan of this patient, in the right frame?";
}

/// Returns `name`, or, if `others` contain it, a similar unique name, with a notice.
template <class Others>
std::string unique_name(const std::string& name, const Others& others) {
  const auto is_used = [&](const std::string& text) {
    return std::any_of(others.begin(), others.end(), [&](const auto& other) { return other.name == text; });
  };
  if (!is_used(name)) return name;
  for (int k = 2;; ++k)
    if (const std::string candidate = name + "-" + std::to_string(k); !is_used(candidate)) {
      notice("note: the plan has several items named " + name + ": one was renamed to " + candidate);
      return candidate;
    }
}

/// Adds trajectories and landmarks of a plan file of another program; warns about points outside the scan.
Status add_plan(data_tools::CasePlan& plan, const std::string& file, const volume::Volume& scan) {
  auto read = data_tools::read_plan(file);
  if (!read) return read.error();
  for (const std::string& text : read.value().notices) notice("note: " + text);
  std::string outside;
  const auto check_inside = [&](const std::string& name, const glm::dvec3& world) {
    const glm::dvec3 p = scan.frame.volume_from_world(world);
    for (int a = 0; a < 3; ++a)
      if (p[a] < -0.5 || p[a] > scan.size[a] - 0.5) {
        outside += (outside.empty() ? "" : ", ") + name;
        return;
      }
  };
  for (const volume::PlannedTrajectory& t : read.value().trajectories) {
    check_inside(t.name + " (entry)", t.entry_world);
    check_inside(t.name + " (target)", t.target_world);
    if (const std::string reason = implausibility_of(t, scan, plan); !reason.empty())
      notice("warning: " + t.name + " " + reason);
    plan.trajectories.push_back(t);
    plan.trajectories.back().name =
        unique_name(t.name, std::span(plan.trajectories).first(plan.trajectories.size() - 1));
  }
  for (const volume::PlannedLandmark& l : read.value().landmarks) {
    check_inside(l.name, l.position_world);
    plan.landmarks.push_back(l);
    plan.landmarks.back().name =
        unique_name(l.name, std::span(plan.landmarks).first(plan.landmarks.size() - 1));
  }
  if (!outside.empty())
    notice("warning: these points of the plan are outside the scan: " + outside.substr(0, 400) +
           "; is it the plan of this patient, in the right frame?");
  return std::nullopt;
}

/// Sets the structures of the plan. The structures of a case stay, unless the arguments define another shape.
Status choose_structures(const ImportArguments& arguments, workbench::Source& source,
                         data_tools::CasePlan& plan) {
  const bool is_overridden = !arguments.labels.empty() || arguments.shape.is_set() ||
                             !arguments.preset.name.empty() || arguments.preset.thin_mm;
  if (source.plan && !is_overridden)
    return arguments.shape.is_largest && !plan.structures.empty()
               ? workbench::keep_largest(source, plan.structures[0].shape, terminal_listener())
               : std::nullopt;
  plan.structures.clear();
  auto shape = workbench::prepare_shape(source, arguments.preset, arguments.shape, terminal_listener());
  if (!shape) return shape.error();
  plan.structures.push_back({.shape = shape.value(), .material = {}});
  // Every label that occurs becomes a structure, which the user can make touchable or forbidden.
  const volume::Volume& scan = *source.volume;
  std::array<bool, 256> occurs{};
  for (const std::uint8_t label : scan.labels.span()) occurs[label] = true;
  for (std::size_t i = 1; i < scan.label_names.size(); ++i) {
    if (!occurs[i]) continue;
    volume::Shape label;
    label.name = scan.label_names[i];
    label.label = static_cast<int>(i);
    if (label.label != shape.value().label)
      plan.structures.push_back({.shape = label, .is_touchable = false, .material = {}});
  }
  return std::nullopt;
}

/// Marks structures as forbidden, by a comma-separated list of names: "dura, brain".
Status forbid(data_tools::CasePlan& plan, const std::string& names) {
  std::istringstream list(names);
  for (std::string name; std::getline(list, name, ',');) {
    name.erase(0, std::min(name.size(), name.find_first_not_of(' ')));
    name.erase(name.find_last_not_of(' ') + 1);
    bool is_known = false;
    std::string names_list;
    for (data_tools::CaseStructure& s : plan.structures) {
      names_list += (names_list.empty() ? "" : ", ") + s.shape.name;
      if (s.shape.name != name) continue;
      is_known = s.is_forbidden = true;
    }
    if (!is_known)
      return Error{
          .what = "unknown structure", .where = "forbid", .found = name, .expected = "one of " + names_list};
  }
  return std::nullopt;
}

/// Draws the initial view of the case to a PNG file.
Status draw(const workbench::Source& source, const std::string& path, const std::string& side) {
  const workbench::OperationChoice choice;
  auto operation = workbench::make_operation(source, choice, terminal_listener());
  if (!operation) return operation.error();
  view::WindowOptions options;
  options.start = view::WindowStart{operation.value().engine()};
  options.catalogue = &modules::catalogue();
  options.screenshot = path;
  options.title = source.written_name();
  options.is_offscreen = true;
  options.side = side_of(side);
  options.has_tool = false;
  options.plan = std::make_shared<const volume::SurgicalPlan>(*source.plan);
  const auto report = view::run_window(operation.value().scene(), options);
  return report ? std::nullopt : Status(report.error());
}

Result<Outcome> run_import(const ImportArguments& arguments) {
  namespace fs = std::filesystem;
  fs::path target(arguments.output);
  if (!target.has_filename()) target = target.parent_path();
  if (Status error = check(arguments.preset, arguments.shape)) return *error;
  if (!data_tools::is_utf8(arguments.name))
    return Error{.what = "the name of the case is not text",
                 .where = "name",
                 .found = "a byte that is not UTF-8",
                 .expected = "a name in UTF-8"};
  data_tools::OutputSet outputs;
  for (const std::string& input : {arguments.source.path, arguments.labels}) outputs.add_input(input);
  for (const std::string& input : arguments.plans) outputs.add_input(input);
  outputs.add_output("output", target.string(), data_tools::OutputKind::folder);
  outputs.add_output("screenshot", arguments.screenshot, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  const auto start = Clock::now();
  auto opened = workbench::open_source(arguments.source, terminal_listener());
  if (!opened) return opened.error();
  workbench::Source& source = opened.value();
  // The name of a folder may identify a patient, so it is never used as the name of the case.
  const std::string name = !arguments.name.empty()     ? arguments.name
                           : !source.case_name.empty() ? source.case_name
                                                       : "case";
  std::shared_ptr<const volume::Volume> scan = source.volume;
  if (!arguments.labels.empty()) {
    auto copy = volume::copy_of(*scan);
    if (!copy) return copy.error();
    if (Status error = add_labels(copy.value(), arguments.labels)) return *error;
    scan = std::make_shared<const volume::Volume>(std::move(copy).value());
    source.volume = scan;
  }

  // A built-in phantom has its own plan.
  if (!source.plan && source.is_builtin && !arguments.shape.is_set() && arguments.preset.name.empty())
    source.plan = data_tools::phantom_plan(source.name);
  data_tools::CasePlan plan = source.plan.value_or(data_tools::CasePlan{});
  plan.name = name;
  plan.modality = source.modality;
  plan.is_hounsfield = scan->is_hounsfield;
  plan.label_names = scan->label_names;
  plan.label_colours = scan->label_colours;
  if (Status error = choose_structures(arguments, source, plan)) return *error;
  if (Status error = forbid(plan, arguments.forbid)) return *error;
  // Measure the quality of the scan as it was before choose_structures() filled or removed voxels, because
  // the changed voxels do not come from the scanner.
  if (!plan.structures.empty() && !plan.structures[0].shape.is_label())
    plan.quality = data_tools::scan_quality(*scan, plan.structures[0].shape);
  scan = source.volume;
  for (const std::string& file : arguments.plans)
    if (Status error = add_plan(plan, file, *scan)) return *error;
  ProgressLine progress("importing");
  outputs.write(target.string(), [&] {
    return data_tools::write_case(target.string(), plan, *scan,
                                  [&](double share) { return progress(share); });
  });
  outputs.write(arguments.screenshot, [&] {
    source.plan = plan;
    source.case_name = name;
    // Surgery of the spine approaches from behind.
    const bool is_spine = arguments.side.empty() && arguments.preset.name == "spine";
    return draw(source, arguments.screenshot, is_spine ? "back" : arguments.side);
  });
  const bool is_straight = scan->frame.is_orthogonal();
  if (!is_straight) notice("note: the sheared volume was resampled to right angles: .mha stores no shear");

  Outcome outcome("import");
  outcome.json["source"] = name_in_report(source);
  outcome.json["case"] = name;
  outcome.json["structures"] = plan.structures.size();
  outcome.json["trajectories"] = plan.trajectories.size();
  outcome.json["landmarks"] = plan.landmarks.size();
  outcome.json["labels"] = plan.label_names;
  outcome.json["is_resampled"] = !is_straight;
  outcome.json["seconds"] = seconds_since(start);
  outcome.print(
      "case {case}: structures: {structures}, trajectories: {trajectories}, landmarks: {landmarks}");
  outcome.print("  edit {file} to name structures, materials and the plan",
                {{"file", (target / "case.toml").string()}});
  if (plan.quality) report_quality(*plan.quality, scan->is_hounsfield, plan.structures[0].shape.low, outcome);
  return finished(outputs, std::move(outcome));
}

Run build_import(Options& options) {
  auto a = std::make_shared<ImportArguments>();
  add_source(options, a->source).required();
  add_shape(options, a->shape);
  options
      .add("--preset", a->preset.name,
           "Bone alone, of " + workbench::preset_names() +
               ": a threshold, parts connected to dense bone, thin walls closed, small parts removed")
      .type("NAME");
  options
      .add("--fill-thin", a->preset.thin_mm,
           "Largest gap to close in walls that are too thin for the scan (default: the preset's, else 0)")
      .type("MM");
  options.add("--plan", a->plans, "Trajectories and landmarks: .mrk.json of 3D Slicer, .fcsv or .csv")
      .type("FILE");
  options.add("--forbid", a->forbid, "Labels that must not be cut: drill exits with 1 if it enters one")
      .type("NAME,NAME");
  options.add("--screenshot", a->screenshot, "Also write a picture of the case").type("PNG");
  add_side(options, a->side);
  options
      .add("--labels", a->labels,
           "Labels of the scan: .seg.nrrd or DICOM SEG with names, or any label map, on any grid")
      .type("FILE");
  options
      .add(
          "--name", a->name,
          "Name of the case, never of a patient; pictures and sessions show it (default: the name of the case or "
          "phantom that is imported, else case)")
      .type("NAME");
  options.add("-o,--output", a->output, "A new folder").required().type("CASE");
  return run_with(a, run_import);
}

}  // namespace

const Command k_import{"import", "Make a case of a scan: volumes in open formats and a plan to edit",
                       "  trephine import SCANS/HEAD --preset skull -o head-case --screenshot head.png\n"
                       "  trephine import head --name training -o training-case",
                       build_import};

}  // namespace trephine::cli
