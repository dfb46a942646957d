// import: a scan becomes a case folder.
#include <array>
#include <filesystem>
#include <glm/geometric.hpp>
#include <sstream>

#include "apps/trephine/commands.h"
#include "apps/trephine/quality_report.h"
#include "apps/view/view_window.h"
#include "apps/workbench/operation.h"
#include "apps/workbench/preset.h"
#include "data-tools/atomic_file.h"
#include "data-tools/case_folder.h"
#include "data-tools/label_file.h"
#include "data-tools/output_set.h"
#include "data-tools/phantom_cases.h"
#include "data-tools/plan_file.h"
#include "data-tools/words.h"
#include "modules/catalogue.h"

namespace trephine::app {

using volume::Error;
using volume::Result;
using volume::Status;

namespace {

struct ImportArguments {
  workbench::SourceChoice source;
  std::string output, name, labels, screenshot;
  std::vector<std::string> plans;
  std::string forbid, side;
  workbench::ShapeChoice shape;
  workbench::PresetChoice preset;
};

/// The labels of a file, brought into `scan`.
Status add_labels(volume::Volume& scan, const std::string& file) {
  data_tools::OpenOptions options;
  options.progress = person().progress("reading the labels");
  auto read = data_tools::read_labels(file, scan, options);
  if (!read) return read.error();
  for (const std::string& text : read.value().notices) notice("note: " + text);
  scan.labels = std::move(read.value().labels);
  scan.label_names = std::move(read.value().names);
  scan.label_colours = std::move(read.value().colours);
  return std::nullopt;
}

/// Implausible plans: another unit, another frame or another patient may be behind them.
std::string what_is_odd(const data_tools::CaseTrajectory& t, const volume::Volume& scan,
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
         " on its way: is it the plan of this patient, in the right frame?";
}

/// Returns `name`, or a name like it that none of `others` has, with a notice.
template <class Others>
std::string unique_name(const std::string& name, const Others& others) {
  const auto is_used = [&](const std::string& text) {
    return std::any_of(others.begin(), others.end(), [&](const auto& one) { return one.name == text; });
  };
  if (!is_used(name)) return name;
  for (int k = 2;; ++k)
    if (const std::string candidate = name + "-" + std::to_string(k); !is_used(candidate)) {
      notice("note: the plan has several places named " + name + ": one is " + candidate + " now");
      return candidate;
    }
}

/// Trajectories and landmarks of other programs; what lies outside of the scan is reported.
Status add_plan(data_tools::CasePlan& plan, const std::string& file, const volume::Volume& scan) {
  auto read = data_tools::read_plan(file);
  if (!read) return read.error();
  for (const std::string& text : read.value().notices) notice("note: " + text);
  std::string outside;
  const auto look = [&](const std::string& name, const glm::dvec3& world) {
    const glm::dvec3 p = scan.frame.volume_from_world(world);
    for (int a = 0; a < 3; ++a)
      if (p[a] < -0.5 || p[a] > scan.size[a] - 0.5) {
        outside += (outside.empty() ? "" : ", ") + name;
        return;
      }
  };
  for (const data_tools::CaseTrajectory& t : read.value().trajectories) {
    look(t.name + " (entry)", t.entry_world);
    look(t.name + " (target)", t.target_world);
    if (const std::string odd = what_is_odd(t, scan, plan); !odd.empty())
      notice("warning: " + t.name + " " + odd);
    plan.trajectories.push_back(t);
    plan.trajectories.back().name =
        unique_name(t.name, std::span(plan.trajectories).first(plan.trajectories.size() - 1));
  }
  for (const data_tools::CaseLandmark& l : read.value().landmarks) {
    look(l.name, l.place_world);
    plan.landmarks.push_back(l);
    plan.landmarks.back().name =
        unique_name(l.name, std::span(plan.landmarks).first(plan.landmarks.size() - 1));
  }
  if (!outside.empty())
    notice("warning: these places of the plan lie outside of the scan: " + outside.substr(0, 400) +
           "; is it the plan of this patient, in the right frame?");
  return std::nullopt;
}

/// Solid shape and its material: the case's own plan, unless something else was asked for.
Status choose_structures(const ImportArguments& arguments, workbench::Source& source,
                         data_tools::CasePlan& plan) {
  const bool is_asked = !arguments.labels.empty() || arguments.shape.is_made() ||
                        !arguments.preset.name.empty() || arguments.preset.thin_mm;
  if (source.plan && !is_asked)
    return arguments.shape.is_largest && !plan.structures.empty()
               ? workbench::keep_largest(source, plan.structures[0].shape, person())
               : std::nullopt;
  plan.structures.clear();
  auto shape = workbench::bring_out(source, arguments.preset, arguments.shape, person());
  if (!shape) return shape.error();
  plan.structures.push_back({shape.value(), true, false, {}});
  // Every label that occurs is there to be made touchable or forbidden.
  const volume::Volume& scan = *source.volume;
  std::array<bool, 256> occurs{};
  for (const std::uint8_t label : scan.labels.span()) occurs[label] = true;
  for (std::size_t i = 1; i < scan.label_names.size(); ++i) {
    if (!occurs[i]) continue;
    volume::Shape label;
    label.name = scan.label_names[i];
    label.label = static_cast<int>(i);
    if (label.label != shape.value().label) plan.structures.push_back({label, false, false, {}});
  }
  return std::nullopt;
}

/// "dura, brain": what must not be cut.
Status forbid(data_tools::CasePlan& plan, const std::string& names) {
  std::istringstream list(names);
  for (std::string name; std::getline(list, name, ',');) {
    name.erase(0, std::min(name.size(), name.find_first_not_of(' ')));
    name.erase(name.find_last_not_of(' ') + 1);
    bool is_there = false;
    std::string known;
    for (data_tools::CaseStructure& s : plan.structures) {
      known += (known.empty() ? "" : ", ") + s.shape.name;
      if (s.shape.name != name) continue;
      is_there = s.is_forbidden = true;
    }
    if (!is_there) return Error{"there is no structure of that name", "forbid", name, "one of " + known, ""};
  }
  return std::nullopt;
}

/// The case as a person would first see it.
Status draw(const workbench::Source& source, const std::string& path, const std::string& side) {
  const workbench::OperationChoice choice;
  auto operation = workbench::make_operation(source, choice, person());
  if (!operation) return operation.error();
  view::WindowOptions options;
  options.start = view::WindowStart{operation.value().engine()};
  options.catalogue = &modules::catalogue();
  options.screenshot = path;
  options.title = source.written_name();
  options.is_offscreen = true;
  options.side = side_of(side);
  options.has_tool = false;
  options.plan = workbench::plan_overlays(*source.plan);
  const auto report = view::run_window(operation.value().scene(), options);
  return report ? std::nullopt : Status(report.error());
}

Result<Outcome> run_import(const ImportArguments& arguments) {
  namespace fs = std::filesystem;
  fs::path target(arguments.output);
  if (!target.has_filename()) target = target.parent_path();
  if (Status bad = check(arguments.preset, arguments.shape)) return *bad;
  if (!data_tools::is_utf8(arguments.name))
    return Error{"the case's name is no text", "name", "a byte that is no UTF-8", "a name in UTF-8", ""};
  data_tools::OutputSet outputs;
  for (const std::string& read : {arguments.source.path, arguments.labels}) outputs.reads(read);
  for (const std::string& read : arguments.plans) outputs.reads(read);
  outputs.writes("output", target.string(), data_tools::OutputKind::folder);
  outputs.writes("screenshot", arguments.screenshot, data_tools::OutputKind::picture);
  if (Status bad = outputs.check()) return *bad;
  const auto start = Clock::now();
  auto opened = workbench::open_source(arguments.source, person());
  if (!opened) return opened.error();
  workbench::Source& source = opened.value();
  // A folder's name may be a patient's; what stands in the case is chosen.
  const std::string name = !arguments.name.empty()     ? arguments.name
                           : !source.case_name.empty() ? source.case_name
                                                       : "case";
  std::shared_ptr<const volume::Volume> scan = source.volume;
  if (!arguments.labels.empty()) {
    auto copy = volume::copy_of(*scan);
    if (!copy) return copy.error();
    if (Status bad = add_labels(copy.value(), arguments.labels)) return *bad;
    scan = std::make_shared<const volume::Volume>(std::move(copy).value());
    source.volume = scan;
  }

  // A phantom that is built in brings its plan.
  if (!source.plan && source.is_builtin && !arguments.shape.is_made() && arguments.preset.name.empty())
    source.plan = data_tools::phantom_plan(source.name);
  data_tools::CasePlan plan = source.plan.value_or(data_tools::CasePlan{});
  plan.name = name;
  plan.modality = source.modality;
  plan.is_hounsfield = scan->is_hounsfield;
  plan.label_names = scan->label_names;
  plan.label_colours = scan->label_colours;
  if (Status bad = choose_structures(arguments, source, plan)) return *bad;
  if (Status bad = forbid(plan, arguments.forbid)) return *bad;
  // Quality of the scan as it came: filled or removed voxels are not the scanner's.
  if (!plan.structures.empty() && !plan.structures[0].shape.is_label())
    plan.quality = data_tools::scan_quality(*scan, plan.structures[0].shape);
  scan = source.volume;
  for (const std::string& file : arguments.plans)
    if (Status bad = add_plan(plan, file, *scan)) return *bad;
  ProgressLine progress("importing");
  outputs.write(target.string(), [&] {
    return data_tools::write_case(target.string(), plan, *scan,
                                  [&](double share) { return progress(share); });
  });
  outputs.write(arguments.screenshot, [&] {
    source.plan = plan;
    source.case_name = name;
    // Spines are operated on from behind.
    const bool is_spine = arguments.side.empty() && arguments.preset.name == "spine";
    return draw(source, arguments.screenshot, is_spine ? "back" : arguments.side);
  });
  if (Status bad = outputs.result()) return *bad;
  const bool is_straight = scan->frame.is_orthogonal();
  if (!is_straight) notice("note: the sheared volume was resampled to right angles, as .mha needs it");

  Outcome outcome{new_report("import"), "", exit_done};
  outcome.json["source"] = name_in_report(source);
  outcome.json["case"] = name;
  outcome.json["written"] = outputs.written();
  outcome.json["structures"] = plan.structures.size();
  outcome.json["trajectories"] = plan.trajectories.size();
  outcome.json["landmarks"] = plan.landmarks.size();
  outcome.json["labels"] = plan.label_names;
  outcome.json["is_resampled"] = !is_straight;
  if (plan.quality) outcome.json["quality"] = quality_json(*plan.quality);
  outcome.json["seconds"] = seconds_since(start);
  const std::string quality =
      plan.quality ? quality_text(*plan.quality, scan->is_hounsfield, plan.structures[0].shape.low) : "";
  outcome.text = "case " + name + ": " + std::to_string(plan.structures.size()) + " structure" +
                 (plan.structures.size() == 1 ? "" : "s") + ", written to " + arguments.output + "\n  edit " +
                 (target / "case.toml").string() + " to name structures, materials and the plan\n" + quality;
  return outcome;
}

Run build(Options& options) {
  auto a = std::make_shared<ImportArguments>();
  add_source(options, a->source).required();
  add_shape(options, a->shape);
  options
      .add("--preset", a->preset.name,
           "Bone by itself, of " + workbench::preset_names() +
               ": a threshold, of that what hangs together with dense bone, thin walls closed, small parts "
               "gone")
      .type("NAME");
  options
      .add("--fill-thin", a->preset.thin_mm,
           "How far gaps in walls that are too thin for the scan are closed (default: the preset's, else 0)")
      .type("MM");
  options.add("--plan", a->plans, "Trajectories and landmarks: .mrk.json of 3D Slicer, .fcsv or .csv")
      .type("FILE");
  options.add("--forbid", a->forbid, "Labels that must not be cut: drill watches them, and ends with 1")
      .type("NAME,NAME");
  options.add("--screenshot", a->screenshot, "Also write a picture of the case").type("PNG");
  add_side(options, a->side);
  options
      .add("--labels", a->labels,
           "Labels of the scan: .seg.nrrd or DICOM SEG with names, or any label map, on whatever grid")
      .type("FILE");
  options
      .add("--name", a->name,
           "Of the case, never a patient's; it stands in pictures and sessions (default: case)")
      .type("NAME");
  options.add("-o,--output", a->output, "A new folder").required().type("CASE");
  return run_with(a, run_import);
}

}  // namespace

const Command k_import{"import", "Make a case of a scan: volumes in open formats and a plan to edit",
                       "  trephine import SCANS/HEAD --preset skull -o head-case --screenshot head.png\n"
                       "  trephine import head --name training -o training-case",
                       build};

}  // namespace trephine::app
