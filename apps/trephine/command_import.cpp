// import: a scan becomes a case folder.
#include <filesystem>

#include "apps/trephine/commands.h"
#include "data-tools/atomic_file.h"
#include "data-tools/case_folder.h"
#include "data-tools/label_file.h"

namespace trephine::app {

using volume::Error;
using volume::Result;
using volume::Status;

namespace {

struct ImportArguments {
  workbench::SourceChoice source;
  std::string output, name, labels;
  workbench::ShapeChoice shape;
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
  return std::nullopt;
}

Result<Outcome> run_import(const ImportArguments& arguments) {
  namespace fs = std::filesystem;
  fs::path target(arguments.output);
  if (!target.has_filename()) target = target.parent_path();
  std::error_code error;
  if (fs::exists(target, error))
    return Error{"there is something of that name already", target.filename().string(), "",
                 "the name of a new folder", "choose another name, or remove it first"};
  if (Status bad = check(arguments.shape)) return *bad;
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
    auto copy = volume::make_volume(scan->size, scan->frame);
    if (!copy) return copy.error();
    std::copy(scan->voxels.span().begin(), scan->voxels.span().end(), copy.value().voxels.data());
    copy.value().is_hounsfield = scan->is_hounsfield;
    if (Status bad = add_labels(copy.value(), arguments.labels)) return *bad;
    scan = std::make_shared<const volume::Volume>(std::move(copy).value());
    source.volume = scan;
  }

  data_tools::CasePlan plan = source.plan.value_or(data_tools::CasePlan{});
  plan.name = name;
  plan.modality = source.modality;
  plan.is_hounsfield = scan->is_hounsfield;
  plan.label_names = scan->label_names;
  if (!source.plan || !arguments.labels.empty() || arguments.shape.is_made()) {
    plan.structures.clear();
    auto shape = workbench::choose_shape(source, arguments.shape, person());
    if (!shape) return shape.error();
    if (arguments.shape.is_largest) {
      if (Status bad = workbench::keep_largest(source, shape.value(), person())) return *bad;
      scan = source.volume;
    } else {
      workbench::offer_largest(source, shape.value(), person());
    }
    plan.structures.push_back({shape.value(), true, false, {}});
    // Every label is there to be made touchable or forbidden.
    for (std::size_t i = 1; i < scan->label_names.size(); ++i) {
      volume::Shape label;
      label.name = scan->label_names[i];
      label.label = static_cast<int>(i);
      if (label.label != shape.value().label) plan.structures.push_back({label, false, false, {}});
    }
  }
  ProgressLine progress("importing");
  if (Status bad =
          data_tools::write_case(target.string(), plan, *scan, [&](double share) { return progress(share); }))
    return *bad;
  const bool is_straight = scan->frame.is_orthogonal();
  if (!is_straight) notice("note: the sheared volume was resampled to right angles, as .mha needs it");

  Outcome outcome{new_report("import"), "", exit_done};
  outcome.json["source"] = name_in_report(source);
  outcome.json["case"] = name;
  outcome.json["structures"] = plan.structures.size();
  outcome.json["labels"] = plan.label_names;
  outcome.json["is_resampled"] = !is_straight;
  outcome.json["seconds"] = seconds_since(start);
  outcome.text = "case " + name + ": " + std::to_string(plan.structures.size()) + " structure" +
                 (plan.structures.size() == 1 ? "" : "s") + ", written to " + arguments.output + "\n  edit " +
                 (target / "case.toml").string() + " to name structures, materials and the plan\n";
  return outcome;
}

Run build(Options& options) {
  auto a = std::make_shared<ImportArguments>();
  add_source(options, a->source).required();
  add_shape(options, a->shape);
  options
      .add("--labels", a->labels,
           "Labels of the scan: .seg.nrrd with names, or any label map, on whatever grid")
      .type("FILE");
  options
      .add("--name", a->name,
           "Of the case, never a patient's; it stands in pictures and sessions (default: case)")
      .type("NAME");
  options.add("-o,--output", a->output, "A new folder").required().type("CASE");
  return run_with(a, run_import);
}

}  // namespace

const Command k_import{
    "import", "Make a case of a scan: volumes in open formats and a plan to edit",
    "  trephine import SCANS/HEAD -o head-case\n  trephine import head --name training -o training-case",
    build};

}  // namespace trephine::app
