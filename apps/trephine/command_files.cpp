// phantom, info and mesh.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "apps/trephine/commands.h"
#include "apps/trephine/text.h"
#include "data-tools/atomic_file.h"
#include "data-tools/mesh_files.h"
#include "data-tools/open_volume.h"
#include "data-tools/phantoms.h"
#include "volume/surface_nets.h"

namespace trephine::app {

using volume::Error;
using volume::Result;

namespace {

/// "N" or "X,Y,Z".
Result<glm::dvec3> parse_triple(const std::string& text, const char* option) {
  const Error bad{"this is neither one number nor three", option, text, "N or X,Y,Z", ""};
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

Json vector_json(const glm::dvec3& v) { return Json::array({v.x, v.y, v.z}); }

Json frame_json(const volume::Volume& v) {
  return {{"size", Json::array({v.size.x, v.size.y, v.size.z})},
          {"spacing_mm", vector_json(v.frame.spacing())},
          {"origin_mm", vector_json(v.frame.origin())},
          {"axis_x", vector_json(v.frame.axes()[0])},
          {"axis_y", vector_json(v.frame.axes()[1])},
          {"axis_z", vector_json(v.frame.axes()[2])}};
}

std::string size_text(const volume::Volume& v) {
  const glm::dvec3 s = v.frame.spacing();
  return format_text("%d x %d x %d voxels of %.4g x %.4g x %.4g mm", v.size.x, v.size.y, v.size.z, s.x, s.y,
                     s.z);
}

}  // namespace

Result<Outcome> run_phantom(const PhantomArguments& arguments) {
  if (!data_tools::is_writable_volume_file(arguments.output))
    return Error{"this is no volume format that trephine writes", data_tools::file_name(arguments.output), "",
                 ".mha, .nrrd, .nii or .nii.gz", "choose one of these extensions"};
  if (volume::Status error = data_tools::check_writable(arguments.output)) return *error;
  if (volume::Status error = check_apart(arguments.labels_output, {arguments.output})) return *error;
  data_tools::PhantomOptions options;
  if (!arguments.size.empty()) {
    auto size = parse_triple(arguments.size, "--size");
    if (!size) return size.error();
    for (int i = 0; i < 3; ++i)
      if (size.value()[i] != std::floor(size.value()[i]) || std::abs(size.value()[i]) > 1e9)
        return Error{"the size is no whole number of voxels", "--size", arguments.size, "N or X,Y,Z", ""};
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
    if (equals == std::string::npos || std::from_chars(setting.data() + equals + 1, end, value).ptr != end)
      return Error{"this is no key=value with a number", "--set", setting, "for example --set radius=40", ""};
    options.parameters[setting.substr(0, equals)] = value;
  }
  auto made = data_tools::make_phantom(arguments.name, options);
  if (!made) return made.error();
  const volume::Volume& v = made.value();
  if (volume::Status error = data_tools::write_volume(arguments.output, v)) return *error;
  if (!arguments.labels_output.empty())
    if (volume::Status error = data_tools::write_labels(arguments.labels_output, v)) return *error;
  Outcome outcome{new_report("phantom"), "", exit_done};
  outcome.json["name"] = arguments.name;
  outcome.json["file"] = data_tools::file_name(arguments.output);
  outcome.json.update(frame_json(v));
  outcome.json["labels"] = v.label_names;
  outcome.text = arguments.name + ": " + size_text(v) + ", written to " + arguments.output + "\n";
  return outcome;
}

Result<Outcome> run_info(const InfoArguments& arguments) {
  if (is_session_file(arguments.source)) return describe_session_file(arguments.source);
  auto opened = open_source(arguments.source);
  if (!opened) return opened.error();
  const Source& source = opened.value();
  const volume::Volume& v = *source.volume;
  const auto [low, high] = std::minmax_element(v.voxels.span().begin(), v.voxels.span().end());
  double sum = 0;
  for (const std::int16_t i : v.voxels.span()) sum += i;
  const double mean = sum / static_cast<double>(v.voxels.size());
  Outcome outcome{new_report("info"), "", exit_done};
  Json& json = outcome.json;
  json["source"] = source.name;
  json["format"] = source.format;
  json["modality"] = source.modality;
  json.update(frame_json(v));
  json["is_orthogonal"] = v.frame.is_orthogonal();
  json["is_hounsfield"] = v.is_hounsfield;
  json["min"] = *low;
  json["max"] = *high;
  json["mean"] = mean;
  json["labels"] = v.label_names;
  if (source.plan) {
    Json structures = Json::array();
    for (const data_tools::CaseStructure& s : source.plan->structures)
      structures.push_back({{"name", s.shape.name},
                            {"shape", describe(s.shape, v.is_hounsfield)},
                            {"touchable", s.is_touchable},
                            {"forbidden", s.is_forbidden}});
    json["structures"] = structures;
    Json trajectories = Json::array();
    for (const data_tools::CaseTrajectory& t : source.plan->trajectories)
      trajectories.push_back({{"name", t.name},
                              {"entry", {t.entry_world.x, t.entry_world.y, t.entry_world.z}},
                              {"target", {t.target_world.x, t.target_world.y, t.target_world.z}},
                              {"diameter", t.diameter}});
    json["trajectories"] = trajectories;
  }
  json["notices"] = source.notices;
  json["read_seconds"] = source.read_seconds;
  const glm::dvec3 near = v.frame.origin(), far = v.frame.world_from_volume(glm::dvec3(v.size - 1));
  outcome.text =
      source.name + ": " + source.format + (source.modality.empty() ? "" : ", " + source.modality) + "\n  " +
      size_text(v) + "\n" +
      format_text("  from (%.1f, %.1f, %.1f) to (%.1f, %.1f, %.1f) mm, patient frame LPS%s\n", near.x, near.y,
                  near.z, far.x, far.y, far.z, v.frame.is_orthogonal() ? "" : ", sheared") +
      format_text("  values %d to %d%s, mean %.1f\n", *low, *high, v.is_hounsfield ? " HU" : "", mean);
  if (source.plan)
    for (const data_tools::CaseStructure& s : source.plan->structures)
      outcome.text += "  structure " + s.shape.name + ": " + describe(s.shape, v.is_hounsfield) +
                      (s.is_touchable ? "" : ", not touched") + (s.is_forbidden ? ", forbidden" : "") + "\n";
  if (source.plan)
    for (const data_tools::CaseTrajectory& t : source.plan->trajectories)
      outcome.text += format_text("  trajectory %s: %.1f mm long\n", t.name.c_str(),
                                  glm::length(t.target_world - t.entry_world));
  if (!v.label_names.empty()) {
    outcome.text += "  labels:";
    for (const std::string& name : v.label_names) outcome.text += " " + name;
    outcome.text += "\n";
  }
  return outcome;
}

Result<Outcome> run_mesh(const MeshArguments& arguments) {
  if (!data_tools::is_mesh_file(arguments.output))
    return Error{"this is no mesh format that trephine writes", data_tools::file_name(arguments.output), "",
                 ".stl, .ply, .obj or .vtp", "choose one of these extensions"};
  if (volume::Status error = data_tools::check_writable(arguments.output)) return *error;
  if (volume::Status error = check_apart(arguments.output, {arguments.source})) return *error;
  auto opened = open_touch(arguments.source, arguments.shape);
  if (!opened) return opened.error();
  const Source& source = opened.value().source;
  const haptics::TouchItem& shape = opened.value().scene.items[0];
  const auto start = Clock::now();
  const volume::Mesh mesh = volume::surface_net({&shape.field, nullptr, shape.bits.get(), arguments.is_open});
  const double seconds = seconds_since(start);
  if (volume::Status error = data_tools::write_mesh(arguments.output, mesh, source.volume->frame))
    return *error;
  Outcome outcome{new_report("mesh"), "", exit_done};
  outcome.json["source"] = source.name;
  outcome.json["shape"] = describe(shape.field.shape(), source.volume->is_hounsfield);
  outcome.json["file"] = data_tools::file_name(arguments.output);
  outcome.json["vertices"] = mesh.vertices.size();
  outcome.json["triangles"] = mesh.triangle_count();
  outcome.json["mesh_seconds"] = seconds;
  outcome.text = format_text("%zu triangles, %zu vertices in %.0f ms, written to %s\n", mesh.triangle_count(),
                             mesh.vertices.size(), 1e3 * seconds, arguments.output.c_str());
  return outcome;
}

}  // namespace trephine::app
