#include "data-tools/cases/case_folder.h"

#include <cmath>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <sstream>
#include <unistd.h>

#include "data-tools/cases/procedure_file.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/meshes/mesh_files.h"
#include "volume/base/text.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;

namespace {

constexpr const char* k_plan_file = "case.toml";
constexpr const char* k_volume_file = "volume.mha";
constexpr const char* k_labels_file = "labels.mha";
constexpr const char* k_shape_file = "shape.mha";
constexpr const char* k_procedure_file = "procedure.toml";  // unless the plan states another name

/// Reads `file`, a volume of the case in addition to the scan; error if its grid is not that of the scan.
/// `what` and `key` describe it in errors: "labels", "[labels]".
Result<volume::Volume> read_companion(const std::string& path, const char* file, const std::string& what,
                                      const std::string& key, const volume::Volume& scan,
                                      const Progress& progress) {
  const std::string where = file_name(path) + "/" + file;
  if (std::error_code error; !fs::exists(fs::path(path) / file, error))
    return Error{.what = "the case lacks its " + what,
                 .where = where,
                 .found = "no such file",
                 .expected = what + ", as described in case.toml",
                 .remedy = "copy the whole case again, or remove " + key + " from case.toml"};
  OpenOptions companion_options;
  companion_options.progress = progress;
  Result<OpenedVolume> opened = open_volume((fs::path(path) / file).string(), companion_options);
  if (!opened) return opened.error();
  volume::Volume& companion = opened.value().volume;
  if (companion.size != scan.size)
    return Error{.what = "the " + what + " and the scan have different sizes",
                 .where = where,
                 .expected = "the same size",
                 .remedy = "resample the " + what + " to the grid of the scan"};
  if (const double distance = max_corner_distance(companion.frame, scan.frame, scan.size);
      distance > k_same_position_mm)
    return Error{.what = "the " + what + " and the scan have different positions",
                 .where = where,
                 .found = "a corner is " + text_of(std::floor(100 * distance) / 100) + " mm off",
                 .expected = "the same position",
                 .remedy = "resample the " + what + " to the grid of the scan"};
  return std::move(companion);
}

/// Sets `scan.shape_voxels` to the intensities that shape.mha and the plan define.
Status read_shape(const std::string& path, const CasePlan& plan, volume::Volume& scan,
                  const Progress& progress) {
  Result<volume::Volume> mask = read_companion(path, k_shape_file, "shape", "[shape]", scan, progress);
  if (!mask) return mask.error();
  scan.shape_voxels = std::move(mask.value().voxels);
  for (std::size_t i = 0; i < scan.voxels.size(); ++i) {
    std::int16_t& value = scan.shape_voxels[i];
    if (value < 0 || static_cast<std::size_t>(value) > plan.shape_values.size())
      return Error{.what = "the shape contains a value that case.toml does not describe",
                   .where = file_name(path) + "/" + k_shape_file,
                   .found = std::to_string(value),
                   .expected = "0 to " + std::to_string(plan.shape_values.size()),
                   .remedy = "add its intensity to values under [shape] in case.toml"};
    value = value == 0 ? scan.voxels[i] : plan.shape_values[static_cast<std::size_t>(value) - 1];
  }
  return std::nullopt;
}

/// Returns a label map of the voxels whose intensity in `scan.shape_voxels` differs from the scanned
/// intensity. Label k stands for the intensity values[k - 1]; new intensities are appended to `values`. Error
/// if there are more than 255 intensities.
Result<volume::Volume> shape_mask(const volume::Volume& scan, std::vector<std::int16_t>& values) {
  volume::Volume mask;
  mask.size = scan.size;
  mask.frame = scan.frame;
  mask.voxels = Buffer<std::int16_t>::borrow(scan.voxels.data(), scan.voxels.size());
  mask.labels = Buffer<std::uint8_t>(scan.voxels.size());
  for (std::size_t i = 0; i < scan.voxels.size(); ++i) {
    const std::int16_t value = scan.shape_voxels[i];
    mask.labels[i] = 0;
    if (value == scan.voxels[i]) continue;
    const auto at = std::find(values.begin(), values.end(), value);
    if (at == values.end() && values.size() == 255)
      return Error{
          .what = "the shape has too many values", .found = "more than 255", .expected = "at most 255"};
    mask.labels[i] = static_cast<std::uint8_t>(at - values.begin() + 1);
    if (at == values.end()) values.push_back(value);
  }
  mask.label_names.emplace_back("as scanned");
  for (const std::int16_t value : values) mask.label_names.push_back("reads as " + std::to_string(value));
  return mask;
}

/// Error if a file of the case is a link to a target outside the folder.
Status check_inside(const fs::path& folder, const char* file) {
  std::error_code error;
  const fs::path folder_path = fs::weakly_canonical(folder, error),
                 file_path = fs::weakly_canonical(folder / file, error);
  const fs::path inside = file_path.lexically_relative(folder_path);
  if (!error && !inside.empty() && *inside.begin() != "..") return std::nullopt;
  return Error{.what = "a file of the case is outside its folder",
               .where = file_name(folder.string()) + "/" + file,
               .found = "a link that leaves the folder",
               .expected = "a file in the folder",
               .remedy = "copy the file into the case"};
}

/// Reads the file of the procedure into the plan.
Status read_procedure_into(const std::string& path, CasePlan& plan) {
  if (Status error = check_inside(path, plan.procedure_file.c_str())) return error;
  Result<ProcedureFile> file = read_procedure((fs::path(path) / plan.procedure_file).string());
  if (!file) {
    Error error = file.error();
    error.where = file_name(path) + "/" + error.where;
    return error;
  }
  plan.procedure = std::move(file).value().procedure;
  return std::nullopt;
}

/// Returns true if this procedure equals the shipped one of its name.
bool is_shipped(const volume::SurgicalProcedure& procedure) {
  const Result<ProcedureFile> shipped = shipped_procedure(procedure.name);
  return shipped && shipped.value().procedure == procedure;
}

/// Copies the files of models and of further volumes, and writes the models in `surfaces`.
Status write_further_files(const std::string& folder, const CasePlan& plan,
                           std::span<const CaseSurface> surfaces) {
  const auto copy = [&](const std::string& from, const std::string& file) -> Status {
    std::error_code error;
    if (from.empty() ||
        fs::copy_file(from, fs::path(folder) / file, fs::copy_options::overwrite_existing, error))
      return std::nullopt;
    return cannot_write(file, error.value());
  };
  for (const CaseModel& model : plan.models)
    if (Status error = copy(model.path, model.file)) return error;
  for (const CaseSurface& surface : surfaces)
    if (Status error = write_mesh((fs::path(folder) / surface.file).string(), surface.mesh, surface.frame))
      return error;
  for (const CaseVolume& volume : plan.volumes)
    if (Status error = copy(volume.path, volume.file)) return error;
  return std::nullopt;
}

/// Error if a position of the plan is far outside the scan: the unit or frame of the position is probably
/// wrong.
Status check_positions(const CasePlan& plan, const volume::Volume& scan, const std::string& where) {
  constexpr double k_farthest = 300;  // mm
  Status error;
  const auto check = [&](const char* kind, const std::string& name, const glm::dvec3& p) {
    const glm::dvec3 nearest =
        glm::clamp(scan.frame.volume_from_world(p), glm::dvec3(0), glm::dvec3(scan.size - 1));
    const double distance = glm::length(p - scan.frame.world_from_volume(nearest));
    if (error || distance <= k_farthest) return;
    error = Error{
        .what = "a position of the plan is far outside the scan",
        .where = where,
        .found = std::string(kind) + " " + name + ": " + text_of(std::round(distance)) + " mm from the scan",
        .expected = "at most " + text_of(k_farthest) + " mm",
        .remedy = "state positions in mm, in the frame of the scan (LPS)"};
  };
  for (const volume::PlannedTrajectory& t : plan.trajectories)
    check("trajectory", t.name, t.entry_world), check("trajectory", t.name, t.target_world);
  for (const volume::PlannedLandmark& l : plan.landmarks) check("landmark", l.name, l.position_world);
  for (const volume::PlannedOutline& o : plan.outlines)
    for (const glm::dvec3& p : o.points_world) check("outline", o.name, p);
  for (const volume::PlannedPlane& p : plan.planes) check("plane", p.name, p.point_world);
  return error;
}

}  // namespace

bool is_case_folder(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(fs::path(path) / k_plan_file, error);
}

Result<OpenedCase> open_case(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path) + "/" + k_plan_file;
  for (const char* name : {k_plan_file, k_volume_file, k_labels_file, k_shape_file})
    if (Status error = check_inside(path, name)) return *error;
  std::ifstream file(fs::path(path) / k_plan_file, std::ios::binary);
  if (!file)
    return Error{.what = "the case cannot be read",
                 .where = where,
                 .expected = "a folder with case.toml",
                 .remedy = "check the spelling, and that you may read the file"};
  std::ostringstream text;
  text << file.rdbuf();
  Result<CasePlan> plan = parse_case(text.str(), where);
  if (!plan) return plan.error();
  if (!plan.value().procedure_file.empty())
    if (Status error = read_procedure_into(path, plan.value())) return *error;
  const auto find_file = [&](const char* what, auto& part) -> Status {
    if (Status error = check_inside(path, part.file.c_str())) return *error;
    part.path = (fs::path(path) / part.file).string();
    if (std::error_code error; fs::is_regular_file(part.path, error)) return std::nullopt;
    return Error{
        .what = std::string("the case lacks a ") + what,
        .where = where + ", line " + std::to_string(part.line),
        .found = part.file,
        .expected = "a file in the folder of the case",
        .remedy = std::string("correct the name of the file, copy the whole case again, or remove the ") +
                  what + " from case.toml"};
  };
  for (CaseVolume& volume : plan.value().volumes)
    if (Status error = find_file("volume", volume)) return *error;
  for (CaseModel& model : plan.value().models)
    if (Status error = find_file("model", model)) return *error;
  Result<OpenedVolume> scan = open_volume((fs::path(path) / k_volume_file).string(), options);
  if (!scan) return scan.error();
  OpenedCase result{std::move(plan).value(), std::move(scan).value()};
  volume::Volume& v = result.scan.volume;
  if (Status error = check_positions(result.plan, v, where)) return *error;
  v.is_hounsfield = result.plan.is_hounsfield;
  result.scan.format = "case";
  result.scan.modality = result.plan.modality;
  result.scan.notices.clear();  // they report properties that the image file lacks but the plan states
  if (!result.plan.shape_values.empty())
    if (Status error = read_shape(path, result.plan, v, options.progress)) return *error;
  if (result.plan.label_names.empty()) return result;
  const std::string labels_where = file_name(path) + "/" + k_labels_file;
  const Result<volume::Volume> labels =
      read_companion(path, k_labels_file, "labels", "[labels] and its structures", v, options.progress);
  if (!labels) return labels.error();
  const volume::Volume& l = labels.value();
  v.labels = Buffer<std::uint8_t>(v.voxels.size());
  for (std::size_t i = 0; i < v.voxels.size(); ++i) {
    if (l.voxels[i] < 0 || static_cast<std::size_t>(l.voxels[i]) >= result.plan.label_names.size())
      return Error{.what = "a label has no name",
                   .where = labels_where,
                   .found = std::to_string(l.voxels[i]),
                   .expected = "0 to " + std::to_string(result.plan.label_names.size() - 1),
                   .remedy = "name it under [labels] in case.toml"};
    v.labels[i] = static_cast<std::uint8_t>(l.voxels[i]);
  }
  v.label_names = result.plan.label_names;
  v.label_colours = result.plan.label_colours;
  return result;
}

Status write_case(const std::string& path, const CasePlan& plan, const volume::Volume& scan,
                  const Progress& progress, std::span<const CaseSurface> surfaces) {
  const std::string where = file_name(path);
  const bool has_labels = !scan.labels.is_empty();
  CasePlan saved_plan = plan;
  saved_plan.shape_values.clear();
  std::optional<volume::Volume> shape;
  if (!scan.shape_voxels.is_empty()) {
    Result<volume::Volume> mask = shape_mask(scan, saved_plan.shape_values);
    if (!mask) return mask.error();
    if (!saved_plan.shape_values.empty()) shape = std::move(mask).value();
  }
  if (saved_plan.procedure.is_empty())
    saved_plan.procedure_file.clear();
  else if (saved_plan.procedure_file.empty() && !is_shipped(saved_plan.procedure))
    saved_plan.procedure_file = k_procedure_file;
  const std::string& procedure_file = saved_plan.procedure_file;
  const std::string text = case_text(saved_plan, has_labels);
  // Checks that the written plan can be read.
  if (const Result<CasePlan> reparsed = parse_case(text, where + "/" + k_plan_file); !reparsed)
    return reparsed.error();
  if (Status error = check_positions(plan, scan, where)) return error;
  const auto report_progress = [&progress](double share) { return !progress || progress(share); };
  const Error interrupted_error{
      "writing the case was interrupted; nothing was written", where, "", "", "", ErrorKind::interrupted};
  std::vector<std::string> files{k_volume_file, k_labels_file, k_shape_file, k_plan_file};
  if (!procedure_file.empty()) files.push_back(procedure_file);
  for (const CaseModel& model : plan.models) files.push_back(model.file);
  for (const CaseVolume& volume : plan.volumes) files.push_back(volume.file);
  return write_folder_atomically(path, files, [&](const std::string& output) -> Status {
    const auto file = [&output](const char* name) { return (fs::path(output) / name).string(); };
    if (!report_progress(0.1)) return interrupted_error;
    if (Status error = write_volume(file(k_volume_file), scan)) return error;
    if (!report_progress(0.7)) return interrupted_error;
    if (has_labels)
      if (Status error = write_labels(file(k_labels_file), scan)) return error;
    if (shape)
      if (Status error = write_labels(file(k_shape_file), *shape)) return error;
    if (Status error = write_further_files(output, plan, surfaces)) return error;
    if (!report_progress(0.9)) return interrupted_error;
    if (!procedure_file.empty())
      if (Status error =
              write_file_atomically(file(procedure_file.c_str()), procedure_text(saved_plan.procedure)))
        return error;
    return write_file_atomically(file(k_plan_file), text);
  });
}

}  // namespace trephine::data_tools
