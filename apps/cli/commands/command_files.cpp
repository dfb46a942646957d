// phantom, mesh and convert: commands that write volumes and meshes.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "apps/cli/commands.h"
#include "apps/cli/commands/frame_json.h"
#include "data-tools/cases/case_folder.h"
#include "data-tools/cases/phantom_cases.h"
#include "data-tools/cases/procedure_file.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/meshes/mesh_files.h"
#include "data-tools/phantoms/phantoms.h"
#include "haptics/mesh/wall_thickness.h"
#include "volume/surface/surface_facts.h"
#include "volume/surface/surface_nets.h"

namespace trephine::cli {

namespace {

struct PhantomArguments {
  std::string name, size, spacing, output, labels_output, case_output, approach;
  std::optional<double> psf;
  double shear = 0;
  std::uint64_t seed = 1;
  std::vector<std::string> settings;  ///< key=value
};
struct ConvertArguments {
  workbench::SourceChoice source;
  std::string output, as, labels_output;
};
struct MeshArguments {
  workbench::SourceChoice source;
  std::string output;
  workbench::ShapeChoice shape;
  bool is_open = false;
  std::optional<double> printed_wall;  ///< mm; empty: walls are not measured
};

/// Parses "N" or "X,Y,Z".
Result<glm::dvec3> parse_triple(const std::string& text, const char* option) {
  const Error bad{"the value is neither one number nor three", option, text, "N or X,Y,Z", ""};
  glm::dvec3 value(0);
  int count = 0;
  const char* at = text.data();
  const char* end = at + text.size();
  while (at < end && count < 3) {
    const auto [next, error] = std::from_chars(at, end, value[count]);
    if (error != std::errc() || !std::isfinite(value[count])) return bad;
    ++count;
    at = next;
    if (at < end) {
      if (*at != ',' || at + 1 == end) return bad;
      ++at;
    }
  }
  if (at != end || (count != 1 && count != 3)) return bad;
  return count == 1 ? glm::dvec3(value.x) : value;
}

Result<Outcome> run_phantom(const PhantomArguments& arguments) {
  data_tools::OutputSet outputs;
  outputs.add_output("output", arguments.output, data_tools::OutputKind::volume);
  outputs.add_output("labels", arguments.labels_output, data_tools::OutputKind::volume);
  outputs.add_output("case", arguments.case_output, data_tools::OutputKind::folder);
  if (Status error = outputs.check()) return *error;
  if (arguments.output.empty() && arguments.case_output.empty())
    return Error{.what = "no output given", .expected = "-o FILE or --case FOLDER"};
  std::optional<data_tools::PhantomCase> written_case;
  if (!arguments.case_output.empty()) {
    written_case = data_tools::phantom_case(arguments.name, arguments.seed, arguments.approach);
    if (written_case && !arguments.approach.empty())
      written_case->plan.procedure = data_tools::shipped_procedure("craniotomy").value().procedure;
  }
  if (!arguments.case_output.empty() && !written_case)
    return Error{.what = "this phantom has no case",
                 .where = "case",
                 .found = arguments.name,
                 .expected = "head or spine",
                 .remedy = "write the volume with -o, then make a case of it with trephine import"};
  data_tools::PhantomOptions options;
  options.approach = arguments.approach;
  if (!arguments.size.empty()) {
    auto size = parse_triple(arguments.size, "--size");
    if (!size) return size.error();
    for (int i = 0; i < 3; ++i)
      if (size.value()[i] != std::floor(size.value()[i]) || std::abs(size.value()[i]) > 1e9)
        return Error{.what = "the size is not a whole number of voxels",
                     .where = "--size",
                     .found = arguments.size,
                     .expected = "N or X,Y,Z"};
    options.size = glm::ivec3(size.value());
  }
  if (!arguments.spacing.empty()) {
    auto spacing = parse_triple(arguments.spacing, "--spacing");
    if (!spacing) return spacing.error();
    options.spacing_mm = spacing.value();
  }
  if (arguments.psf) options.psf_sigma_voxels = *arguments.psf, options.is_psf_given = true;
  options.shear_degrees = arguments.shear;
  options.seed = arguments.seed;
  for (const std::string& setting : arguments.settings) {
    const std::size_t equals = setting.find('=');
    double value = 0;
    const char* end = setting.data() + setting.size();
    if (equals == std::string::npos || std::from_chars(setting.data() + equals + 1, end, value).ptr != end ||
        equals + 1 == setting.size())
      return Error{.what = "not a key=value pair with a number",
                   .where = "--set",
                   .found = setting,
                   .expected = "for example --set radius=40"};
    options.parameters[setting.substr(0, equals)] = value;
  }
  auto phantom = data_tools::make_phantom(arguments.name, options);
  if (!phantom) return phantom.error();
  if (is_interrupted()) return interrupted("making the phantom");
  const volume::Volume& v = phantom.value();
  notify_resampled(v, arguments.case_output.empty() ? arguments.output : arguments.case_output);
  outputs.write(arguments.case_output, [&] {
    return data_tools::write_case(arguments.case_output, written_case->plan, v, {}, written_case->surfaces);
  });
  outputs.write(arguments.output, [&] { return data_tools::write_volume(arguments.output, v); });
  outputs.write(arguments.labels_output,
                [&] { return data_tools::write_labels(arguments.labels_output, v); });
  Outcome outcome("phantom");
  outcome.json["name"] = arguments.name;
  outcome.json.update(frame_json(v));
  outcome.json["labels"] = v.label_names;
  outcome.print(std::string("{name}: ") + k_size_line);
  return finished(outputs, std::move(outcome));
}

/// Adds the size, shells and walls of a surface to the report, for a 3-D printer whose thinnest possible wall
/// is `limit` mm.
void report_walls(const volume::Mesh& mesh, const volume::Frame& frame, double limit, Outcome& outcome) {
  std::vector<glm::dvec3> vertices;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    vertices.push_back(frame.world_from_volume(glm::dvec3(mesh.vertices[v])));
  const std::uint32_t* corners = mesh.triangles.data();
  const haptics::MeshTree surface(std::move(vertices), {corners, corners + mesh.triangles.size()});
  const volume::SurfaceFacts facts = volume::facts_of(surface.vertices(), surface.triangles());
  const haptics::WallFacts walls = haptics::walls_of(surface, limit);
  outcome.json["size_mm"] = json_of(facts.size);
  outcome.add("open_edges", facts.open_edges);
  outcome.add("shells", walls.shells);
  outcome.json["thin_wall_percent"] = 100 * walls.thin_share;
  outcome.json["thinnest_wall_mm"] = walls.thinnest;
  outcome.json["thinnest_wall_at"] = json_of(walls.thinnest_at);
  outcome.print(
      "  size ({size_mm:.1f}) mm; walls: {thin_wall_percent:.1f} % thinner than {limit:.2g} mm, the thinnest "
      "{thinnest_wall_mm:.2f} mm at ({thinnest_wall_at:.1f})",
      {{"limit", limit}});
  if (walls.shells > 1)
    outcome.print("  {shells} separate surfaces: choose the largest part before printing");
}

Result<Outcome> run_mesh(const MeshArguments& arguments) {
  if (arguments.printed_wall)
    if (Status error = check_range(*arguments.printed_wall, 0.01, 100, "--printed-wall")) return *error;
  data_tools::OutputSet outputs;
  outputs.add_input(arguments.source.path);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::mesh);
  if (Status error = outputs.check()) return *error;
  auto opened = workbench::open_touch(arguments.source, arguments.shape, terminal_listener());
  if (!opened) return opened.error();
  const workbench::Source& source = opened.value().source;
  const haptics::TouchItem& shape = opened.value().scene.items[0];
  const auto start = Clock::now();
  const volume::Mesh mesh = volume::surface_net({&shape.field, nullptr, shape.bits.get(), arguments.is_open});
  const double seconds = seconds_since(start);
  if (is_interrupted()) return interrupted("making the mesh");
  outputs.write(arguments.output,
                [&] { return data_tools::write_mesh(arguments.output, mesh, source.volume->frame); });
  Outcome outcome("mesh");
  outcome.json["source"] = name_in_report(source);
  outcome.json["shape"] = volume::describe(shape.field.shape(), source.volume->is_hounsfield);
  outcome.add("vertices", mesh.vertices.size());
  outcome.add("triangles", mesh.triangle_count());
  outcome.add("mesh_seconds", seconds);
  if (arguments.printed_wall) report_walls(mesh, source.volume->frame, *arguments.printed_wall, outcome);
  return finished(outputs, std::move(outcome));
}

Result<Outcome> run_convert(const ConvertArguments& arguments) {
  const bool is_folder = !arguments.as.empty();
  const std::string extension = std::filesystem::path(arguments.output).extension().string();
  const bool is_slice =
      extension == ".dcm" || extension == ".png" || extension == ".tif" || extension == ".tiff";
  if (!is_folder && is_slice)
    return Error{.what = "this format stores one slice per file",
                 .where = "output",
                 .found = extension,
                 .expected = "a folder of them",
                 .remedy = extension == ".dcm"   ? "-o FOLDER --as dicom"
                           : extension == ".png" ? "-o FOLDER --as png"
                                                 : "-o FOLDER --as tiff"};
  if (is_folder &&
      (is_slice || !data_tools::check_extension(data_tools::OutputKind::volume, arguments.output)))
    return Error{.what = "the folder of slices has the extension of a file",
                 .where = "output",
                 .found = extension,
                 .expected = "a folder's name",
                 .remedy = "remove the extension, or omit --as to write one file"};
  data_tools::OutputSet outputs;
  outputs.add_input(arguments.source.path);
  outputs.add_output("output", arguments.output,
                     is_folder ? data_tools::OutputKind::folder : data_tools::OutputKind::volume);
  outputs.add_output("labels", arguments.labels_output, data_tools::OutputKind::volume);
  if (Status error = outputs.check()) return *error;
  auto opened = workbench::open_source(arguments.source, terminal_listener());
  if (!opened) return opened.error();
  std::shared_ptr<const volume::Volume> scan = opened.value().volume;
  if (!is_folder && !scan->frame.is_orthogonal() && !data_tools::keeps_shear(arguments.output)) {
    notify_resampled(*scan, arguments.output);
    auto straight = data_tools::orthogonalized(*scan);
    if (!straight) return straight.error();
    scan = std::make_shared<const volume::Volume>(std::move(straight).value());
  }
  const volume::Volume& v = *scan;
  if (!arguments.labels_output.empty() && v.labels.is_empty())
    return Error{.what = "this scan has no labels to write",
                 .where = "labels",
                 .expected = "a case or phantom with labels",
                 .remedy = "pass a case, or import the scan with --labels"};
  if (arguments.as == "dicom" && !v.is_hounsfield && opened.value().modality != "MR")
    notice(
        "note: the series is written as MR, because its values are not known to be Hounsfield units; pass "
        "--hounsfield if they are");
  outputs.write(arguments.output, [&]() -> Status {
    if (!is_folder) return data_tools::write_volume(arguments.output, v);
    using data_tools::FolderFormat;
    ProgressLine progress("writing");
    return data_tools::write_volume_folder(arguments.output,
                                           arguments.as == "dicom" ? FolderFormat::dicom
                                           : arguments.as == "png" ? FolderFormat::png
                                                                   : FolderFormat::tiff,
                                           v, [&](double share) { return progress(share); });
  });
  outputs.write(arguments.labels_output,
                [&] { return data_tools::write_labels(arguments.labels_output, v); });
  Outcome outcome("convert");
  outcome.json["source"] = name_in_report(opened.value());
  outcome.json.update(frame_json(v));
  outcome.print(k_size_line);
  return finished(outputs, std::move(outcome));
}

Run build_phantom(Options& options) {
  auto a = std::make_shared<PhantomArguments>();
  options
      .add("NAME", a->name,
           "sphere, plane, plate, torus, gyroid, shell, groove, corner, slot, cone, steps, box, peg, hole, "
           "head or spine")
      .required();
  options.add("--size", a->size, "Voxels along each axis").type("N|X,Y,Z");
  options.add("--spacing", a->spacing, "Voxel size, mm").type("S|X,Y,Z");
  options
      .add("--psf", a->psf,
           "Scanner blur: sigma in voxels, 0 to 2; 0 gives exact partial volumes with slightly ribbed faces, "
           "1 is the blur of a good scanner")
      .type("SIGMA");
  options.add("--shear", a->shear, "Gantry tilt, degrees").type("D");
  options
      .add("--seed", a->seed,
           "Seed of the noise and of the anatomy of head and spine; 1 is the standard anatomy")
      .type("K");
  options
      .add(
          "--approach", a->approach,
          "A head whose tumour needs this approach: vault, frontotemporal, suboccipital or keyhole. Its case "
          "has the procedure of a craniotomy")
      .type("NAME");
  options.add("--set", a->settings, "A parameter of the shape, such as radius=40")
      .type("KEY=VALUE")
      .means("parameter");
  options.add("-o,--output", a->output, data_tools::extensions_of(data_tools::OutputKind::volume));
  options
      .add("--case", a->case_output,
           "A new case folder of head or spine, with its plan and forbidden structures")
      .type("CASE");
  options
      .add("--write-labels", a->labels_output,
           "Also write the labels to this file, .seg.nrrd with their names (head, spine)")
      .type("FILE");
  return run_with(a, run_phantom);
}

Run build_mesh(Options& options) {
  auto a = std::make_shared<MeshArguments>();
  add_source(options, a->source).required();
  add_shape(options, a->shape);
  options.add("-o,--output", a->output, data_tools::extensions_of(data_tools::OutputKind::mesh)).required();
  options.add("--open", a->is_open, "Leave holes where the shape reaches the border of the scan");
  options
      .add("--printed-wall", a->printed_wall,
           "Also report size, separate surfaces, and walls thinner than this, mm, for 3-D printing")
      .type("MM");
  return run_with(a, run_mesh);
}

Run build_convert(Options& options) {
  auto a = std::make_shared<ConvertArguments>();
  add_source(options, a->source).required();
  options
      .add("-o,--output", a->output,
           data_tools::extensions_of(data_tools::OutputKind::volume) + "; with --as a new folder of slices")
      .required();
  options.add("--as", a->as, "A DICOM series (derived, anonymous), or pictures of 16 bits with stack.json")
      .one_of({"dicom", "png", "tiff"});
  options
      .add("--write-labels", a->labels_output,
           "Also write the labels to this file; .seg.nrrd keeps their names")
      .type("FILE");
  return run_with(a, run_convert);
}

}  // namespace

const Command k_convert{"convert", "Write a scan in another format",
                        "  trephine convert SCANS/HEAD -o head.nrrd\n"
                        "  trephine convert head-case -o head-series --as dicom --write-labels head.seg.nrrd",
                        build_convert};
const Command k_phantom{
    "phantom", "Make a volume whose shape is known exactly",
    "  trephine phantom sphere --size 256 --psf 1.5 -o sphere.mha\n"
    "  trephine phantom plate --set thickness=2 --set angle=30 -o plate.nrrd\n"
    "  trephine phantom head --spacing 0.6 -o head.nii.gz --write-labels head-labels.nii.gz\n"
    "  trephine phantom spine --seed 3 --case other-spine",
    build_phantom};
const Command k_mesh{"mesh", "Write the surface of a shape as a mesh",
                     "  trephine mesh SCANS/HEAD -o skull.stl\n  trephine mesh head --label dura -o dura.ply",
                     build_mesh};

}  // namespace trephine::cli
