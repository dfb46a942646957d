#include "data-tools/cases/case_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <tuple>

#include "data-tools/cases/procedure_file.h"
#include "data-tools/cases/score_toml.h"
#include "data-tools/cases/toml_reader_impl.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;

namespace {

/// Reads ["#RRGGBB", ...] for labels 1, 2, ...; the background is black.
std::vector<glm::u8vec3> read_colours(TomlReader& reader, const toml::value& list, std::size_t label_count) {
  std::vector<glm::u8vec3> colours{glm::u8vec3(0)};
  if (!list.is_array() || list.as_array().size() + 1 != label_count) {
    reader.fail(list, "the number of colours differs from the number of labels", "",
                "as many colours as names, or no key \"colours\"");
    return {};
  }
  for (const toml::value& v : list.as_array()) {
    const std::string text = v.is_string() ? v.as_string().str : "";
    if (text.size() != 7 || text[0] != '#' ||
        text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos) {
      reader.fail(v, "a label's colour is invalid", text, "\"#RRGGBB\", for example \"#d8b48c\"");
      return {};
    }
    const unsigned long rgb = std::strtoul(text.c_str() + 1, nullptr, 16);
    colours.emplace_back(rgb >> 16, rgb >> 8 & 255, rgb & 255);
  }
  return colours;
}

/// Keys of a material, with their largest values.
constexpr std::tuple<std::string_view, std::optional<double> CaseMaterial::*, double> k_material_keys[] = {
    {"stiffness", &CaseMaterial::stiffness, 100},
    {"damping", &CaseMaterial::damping, 1},
    {"static_friction", &CaseMaterial::static_friction, 2},
    {"dynamic_friction", &CaseMaterial::dynamic_friction, 2},
    {"viscosity", &CaseMaterial::viscosity, 0.05},
    {"pop_force", &CaseMaterial::pop_force, 100},
    {"pop_rearm", &CaseMaterial::pop_rearm, 100}};
constexpr const char* k_back = "back_";  // prefix of the keys for the back of a surface

CaseMaterial read_material(TomlReader& reader, const toml::table& t, const std::string& prefix) {
  CaseMaterial material;
  for (const auto& [key, number, high] : k_material_keys)
    material.*number = reader.number(t, prefix + std::string(key), 0, high);
  if (material.static_friction && material.dynamic_friction > material.static_friction)
    reader.fail(t.at(prefix + "dynamic_friction"), "the dynamic friction is larger than the static friction",
                text_of(*material.dynamic_friction) + " and " + text_of(*material.static_friction),
                "dynamic_friction <= static_friction", "swap the two values");
  return material;
}

/// Refuses names that reports and sessions could not show in one line.
void check_name(TomlReader& reader, const toml::value& value, const std::string& name) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  if (std::any_of(name.begin(), name.end(), is_control))
    reader.fail(value, "a name has line ends or control characters", "", "a name in one line");
}

CaseStructure read_structure(TomlReader& reader, const toml::value& value, std::size_t label_count) {
  static const std::set<std::string> k_keys = [] {
    std::set<std::string> keys{"name", "volume", "low", "high", "label", "touchable", "forbidden", "sides"};
    for (const auto& [key, number, high] : k_material_keys)
      keys.insert({std::string(key), k_back + std::string(key)});
    return keys;
  }();
  const toml::table& t = reader.table(value, k_keys);
  CaseStructure s;
  const auto name = reader.text(t, "name");
  if (!name) reader.fail(value, "a structure has no name", "", "name = \"bone\"");
  s.shape.name = name.value_or("");
  check_name(reader, value, s.shape.name);
  s.volume = reader.text(t, "volume").value_or("");
  const auto low = reader.number(t, "low", -1e6, 1e6), high = reader.number(t, "high", -1e6, 1e6);
  const auto label = reader.number(t, "label", 1, 255);
  s.shape.low = low.value_or(-std::numeric_limits<double>::infinity());
  s.shape.high = high.value_or(std::numeric_limits<double>::infinity());
  if (label) {
    s.shape.label = static_cast<int>(*label);
    if (*label != s.shape.label)
      reader.fail(value, "the label is not a whole number", std::to_string(*label), "1 to 255");
    if (low || high)
      reader.fail(value, "a structure is either a window or a label", "both", "low and high, or label");
    if (s.volume.empty() && static_cast<std::size_t>(s.shape.label) >= std::max<std::size_t>(label_count, 1))
      reader.fail(value, "unknown label", std::to_string(s.shape.label),
                  "a label that the case has: see names under [labels]");
  } else if (!low && !high) {
    reader.fail(value, "a structure has neither a window nor a label", s.shape.name, "low, high or label");
  } else if (s.shape.low > s.shape.high) {
    reader.fail(value, "the lower limit of the window is above its upper limit", "", "low <= high",
                "swap the two values");
  }
  s.is_touchable = reader.boolean(t, "touchable").value_or(true);
  s.is_forbidden = reader.boolean(t, "forbidden").value_or(false);
  s.material = read_material(reader, t, "");
  if (const CaseMaterial back = read_material(reader, t, k_back); back != CaseMaterial())
    s.back_material = back;
  const std::string sides = reader.text(t, "sides").value_or("front");
  if (sides != "front" && sides != "back" && sides != "both")
    reader.fail(value, "invalid sides of a structure", sides, "front, back or both");
  s.blocks_front = sides != "back", s.blocks_back = sides != "front";
  return s;
}

/// Reads the name and the file of a further volume or a model. `what`: "a volume" or "a model", for errors.
template <class Part>
void read_name_and_file(TomlReader& reader, const toml::value& value, const toml::table& t, const char* what,
                        Part& part) {
  part.line = TomlReader::line_of(value);
  part.name = reader.text(t, "name").value_or("");
  part.file = reader.text(t, "file").value_or("");
  check_name(reader, value, part.name);
  if (part.name.empty() || part.file.empty() || fs::path(part.file).filename() != part.file)
    reader.fail(value, std::string(what) + " is not complete", part.file,
                "name, and file = the name of a file in the case's folder");
}

CaseVolume read_volume(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"name", "file", "matter"});
  CaseVolume volume;
  read_name_and_file(reader, value, t, "a volume", volume);
  if (t.contains("matter")) volume.matter = read_matter(reader, value, t);
  return volume;
}

CaseModel read_model(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"name", "file", "matter", "forbidden", "touchable"});
  CaseModel model;
  read_name_and_file(reader, value, t, "a model", model);
  model.matter = read_matter(reader, value, t);
  model.is_forbidden = reader.boolean(t, "forbidden").value_or(false);
  model.is_touchable = reader.boolean(t, "touchable").value_or(true);
  return model;
}

/// Returns true if a label has this name. `labels`: names, the background first.
bool is_label(const std::string& name, const std::vector<std::string>& labels) {
  return !labels.empty() && std::find(labels.begin() + 1, labels.end(), name) != labels.end();
}

volume::PlannedTrajectory read_trajectory(TomlReader& reader, const toml::value& value,
                                          const std::vector<std::string>& labels) {
  const toml::table& t =
      reader.table(value, {"name", "entry", "target", "diameter", "group", "side", "vertebra"});
  volume::PlannedTrajectory result;
  const auto name = reader.text(t, "name");
  const auto entry = reader.point(t, "entry"), target = reader.point(t, "target");
  if (!name || !entry || !target)
    reader.fail(value, "a trajectory is not complete", "", "name, entry = [x, y, z] and target = [x, y, z]");
  result.name = name.value_or("");
  result.entry_world = entry.value_or(glm::dvec3(0));
  result.target_world = target.value_or(glm::dvec3(0));
  result.diameter = reader.number(t, "diameter", 0, 100).value_or(0);
  result.group = reader.text(t, "group").value_or("");
  result.side = reader.text(t, "side").value_or("");
  result.vertebra = reader.text(t, "vertebra").value_or("");
  if (!result.vertebra.empty() && !labels.empty() && !is_label(result.vertebra, labels))
    reader.fail(t.at("vertebra"), "unknown vertebra", result.vertebra, "a name under [labels]");
  return result;
}

volume::PlannedLandmark read_landmark(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"name", "at"});
  const auto name = reader.text(t, "name");
  const auto at = reader.point(t, "at");
  if (!name || !at) reader.fail(value, "a landmark is not complete", "", "name and at = [x, y, z]");
  return {name.value_or(""), at.value_or(glm::dvec3(0))};
}

volume::PlannedOutline read_outline(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"name", "points"});
  volume::PlannedOutline outline{reader.text(t, "name").value_or(""), {}};
  const auto points = t.find("points");
  if (outline.name.empty() || points == t.end() || !points->second.is_array())
    return reader.fail(value, "an outline is not complete", "", "name and points = [[x, y, z], ...]"),
           outline;
  for (const toml::value& point : points->second.as_array())
    outline.points_world.push_back(reader.point_of(point, "points").value_or(glm::dvec3(0)));
  return outline;
}

volume::PlannedPlane read_plane(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"name", "at", "normal"});
  const auto name = reader.text(t, "name");
  const auto at = reader.point(t, "at"), normal = reader.point(t, "normal");
  if (!name || !at || !normal || !(glm::length(*normal) > 1e-9))
    return reader.fail(value, "a plane is not complete", "",
                       "name, at = [x, y, z] and a normal = [x, y, z] that is not 0"),
           volume::PlannedPlane();
  return {*name, *at, glm::normalize(*normal)};
}

volume::PlannedTarget read_target(TomlReader& reader, const toml::value& value,
                                  const std::vector<std::string>& labels) {
  const toml::table& t = reader.table(value, {"name", "label"});
  const volume::PlannedTarget target{reader.text(t, "name").value_or(""),
                                     reader.text(t, "label").value_or("")};
  if (!is_label(target.label, labels))
    reader.fail(value, "a target has an unknown label", target.label, "a name under [labels]");
  return target;
}

/// Reads the name of a shipped procedure, or that of a file of the case.
void read_procedure_of(TomlReader& reader, const toml::value& value, CasePlan& plan) {
  const toml::table& t = reader.table(value, {"name", "file"});
  const auto name = reader.text(t, "name"), file = reader.text(t, "file");
  if (name.has_value() == file.has_value())
    return reader.fail(value, "a procedure has either a name or a file", name ? "both" : "",
                       "name = \"craniotomy\", or file = the name of a file in the case's folder");
  plan.procedure_file = file.value_or("");
  if (file && (fs::path(*file).filename() != *file || !file->ends_with(".toml") || *file == "case.toml"))
    return reader.fail(value, "invalid file name of a procedure", *file,
                       "\"NAME.toml\", a file in the case's folder");
  if (!name) return;
  Result<ProcedureFile> shipped = shipped_procedure(*name);
  if (shipped)
    plan.procedure = std::move(shipped).value().procedure;
  else
    reader.fail(value, shipped.error().what, shipped.error().found, shipped.error().expected);
}

/// Calls use(key, value) for each optional value of a scan's quality.
template <class Quality, class Use>
void for_each_quality(Quality& q, const Use& use) {
  use("blur_in_plane", q.blur_in_plane);
  use("blur_across", q.blur_across);
  use("noise", q.noise);
  use("thinnest", q.thinnest);
  use("least_wall", q.min_wall);
  use("least_gap", q.min_gap);
}

ScanQuality read_quality(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"blur_in_plane", "blur_across", "edges", "rough", "noise",
                                              "slice_step", "thinnest", "least_wall", "least_gap"});
  ScanQuality quality;
  for_each_quality(quality, [&](const char* key, std::optional<double>& measure) {
    measure = reader.number(t, key, 0, 1e6);
  });
  quality.slice_step = reader.number(t, "slice_step", 0, 1e6).value_or(0);
  quality.edge_count = static_cast<int>(reader.number(t, "edges", 0, 1e6).value_or(0));
  quality.is_rough = reader.boolean(t, "rough").value_or(false);
  return quality;
}

std::string name_of(const toml::value& value) {
  const auto name = value.is_table() ? value.as_table().find("name") : toml::table::const_iterator();
  return value.is_table() && name != value.as_table().end() && name->second.is_string()
             ? name->second.as_string().str
             : "";
}

/// Error if two of these tables have the same name.
void check_unique(TomlReader& reader, const toml::table& top, std::initializer_list<const char*> lists) {
  std::set<std::string> names;
  for (const char* list : lists)
    for (const toml::value* v : reader.tables(top, list))
      if (const std::string name = name_of(*v); !names.insert(name).second && !name.empty())
        reader.fail(*v, "two objects have the same name", name, "a different name for each object",
                    "rename one of them");
}

/// Returns the line of the last object named `name` in the list `list`; 0 if there is no such object.
int line_of_object(TomlReader& reader, const toml::table& top, const std::string& list,
                   const std::string& name) {
  int line = 0;
  if (const auto at = top.find(list); at == top.end() || !at->second.is_array()) return 0;
  for (const toml::value* v : reader.tables(top, list))
    if (name_of(*v) == name) line = TomlReader::line_of(*v);
  return line;
}

}  // namespace

Result<CasePlan> parse_case(const std::string& text, const std::string& where) {
  Result<toml::value> parsed = parse_toml(text, where, "case");
  if (!parsed) return parsed.error();
  const toml::value& root = parsed.value();
  TomlReader reader(where);
  const toml::table& top =
      reader.table(root, {"schema", "name", "modality", "hounsfield", "labels", "structures", "volumes",
                          "models", "trajectories", "landmarks", "outlines", "planes", "targets", "quality",
                          "shape", "procedure", "score"});
  if (Status error = reader.check_schema(top, CasePlan::k_schema, "case")) return *error;
  CasePlan plan;
  const auto name = reader.text(top, "name");
  if (!name) reader.fail(root, "the case has no name", "", "name = \"...\"");
  plan.name = name.value_or("");
  plan.modality = reader.text(top, "modality").value_or("");
  plan.is_hounsfield = reader.boolean(top, "hounsfield").value_or(false);
  if (const auto labels = top.find("labels"); labels != top.end()) {
    const toml::table& t = reader.table(labels->second, {"names", "colours"});
    plan.label_names.emplace_back("background");
    const auto names = t.find("names");
    if (names == t.end() || !names->second.is_array() || names->second.as_array().size() > 255) {
      reader.fail(labels->second, "the labels have no names, or more than 255", "",
                  "names = [\"skull\", ...] for labels 1, 2, ...");
    } else {
      for (const toml::value& v : names->second.as_array()) {
        if (!v.is_string()) reader.fail(v, "a label's name is not text", "", "\"text\"");
        plan.label_names.push_back(v.is_string() ? v.as_string().str : "");
      }
    }
    if (const auto colours = t.find("colours"); colours != t.end())
      plan.label_colours = read_colours(reader, colours->second, plan.label_names.size());
  }
  if (const auto shape = top.find("shape"); shape != top.end()) {
    const toml::table& t = reader.table(shape->second, {"values"});
    const auto values = t.find("values");
    if (values == t.end() || !values->second.is_array() || values->second.as_array().empty() ||
        values->second.as_array().size() > 255) {
      reader.fail(shape->second, "the shape has no values, or more than 255", "",
                  "values = [-1000, ...]: intensities for 1, 2, ... of shape.mha");
    } else {
      for (const toml::value& v : values->second.as_array()) {
        const std::int64_t value = v.is_integer() ? v.as_integer() : INT64_MAX;
        if (value < INT16_MIN || value > INT16_MAX)
          reader.fail(v, "a value of the shape is not an intensity", "",
                      "a whole number from -32768 to 32767");
        plan.shape_values.push_back(static_cast<std::int16_t>(value));
      }
    }
  }
  for (const toml::value* v : reader.tables(top, "volumes")) plan.volumes.push_back(read_volume(reader, *v));
  for (const toml::value* v : reader.tables(top, "structures")) {
    const CaseStructure& s =
        plan.structures.emplace_back(read_structure(reader, *v, plan.label_names.size()));
    if (!s.volume.empty() && std::none_of(plan.volumes.begin(), plan.volumes.end(),
                                          [&](const CaseVolume& volume) { return volume.name == s.volume; }))
      reader.fail(*v, "a structure names an unknown volume", s.volume, "the name of one of [[volumes]]");
  }
  for (const toml::value* v : reader.tables(top, "models")) plan.models.push_back(read_model(reader, *v));
  for (const toml::value* v : reader.tables(top, "trajectories"))
    plan.trajectories.push_back(read_trajectory(reader, *v, plan.label_names));
  for (const toml::value* v : reader.tables(top, "landmarks"))
    plan.landmarks.push_back(read_landmark(reader, *v));
  for (const toml::value* v : reader.tables(top, "outlines"))
    plan.outlines.push_back(read_outline(reader, *v));
  for (const toml::value* v : reader.tables(top, "planes")) plan.planes.push_back(read_plane(reader, *v));
  for (const toml::value* v : reader.tables(top, "targets"))
    plan.targets.push_back(read_target(reader, *v, plan.label_names));
  if (const auto procedure = top.find("procedure"); procedure != top.end())
    read_procedure_of(reader, procedure->second, plan);
  plan.score = read_score(reader, top);
  if (const auto quality = top.find("quality"); quality != top.end())
    plan.quality = read_quality(reader, quality->second);
  if (plan.structures.empty())
    reader.fail(root, "the case has no structure", "", "at least one [[structures]]");
  // Commands and events refer to a structure or a model by its name alone.
  check_unique(reader, top, {"structures", "models"});
  check_unique(reader, top, {"volumes"});
  if (reader.error()) return *reader.error();
  if (Status error = volume::check(plan)) {
    const int line = line_of_object(reader, top, error->where, error->found);
    error->where = where + ", " + (line > 0 ? "line " + std::to_string(line) : error->where);
    return *error;
  }
  return plan;
}

std::string case_text(const CasePlan& plan, bool has_labels) {
  std::string out = "# A case of trephine. Every key is described in docs/file-formats.md.\n";
  const auto line = [&out](const char* key, const std::string& value) {
    out += std::string(key) + " = " + value + "\n";
  };
  const auto number = [&line](const char* key, double value) {
    const std::string text = text_of(value);
    line(key, text.find_first_of(".e") == std::string::npos ? text + ".0" : text);
  };
  const auto rounded = [](double v) { return std::floor(1000 * v + 0.5) / 1000; };  // to 1 um
  const auto vector_text = [](const glm::dvec3& p) {
    std::string text = "[";
    text.append(text_of(p.x)).append(", ").append(text_of(p.y)).append(", ").append(text_of(p.z));
    return text.append("]");
  };
  const auto point_text = [&](const glm::dvec3& p) {
    return vector_text({rounded(p.x), rounded(p.y), rounded(p.z)});
  };
  const auto point = [&](const char* key, const glm::dvec3& p) { line(key, point_text(p)); };
  line("schema", std::to_string(CasePlan::k_schema));
  line("name", toml_text(plan.name) + "  # chosen for the case, never a patient's");
  if (!plan.modality.empty()) line("modality", toml_text(plan.modality));
  line("hounsfield", plan.is_hounsfield ? "true" : "false");
  if (has_labels) {
    out += "\n[labels]  # names of the values of labels.mha, from 1 up\nnames = [";
    for (std::size_t i = 1; i < plan.label_names.size(); ++i)
      out += (i > 1 ? ", " : "") + toml_text(plan.label_names[i]);
    out += "]\n";
    if (plan.label_colours.size() > 1) out += "colours = [";
    for (std::size_t i = 1; i < plan.label_colours.size(); ++i) {
      char colour[12];
      const glm::u8vec3& c = plan.label_colours[i];
      std::snprintf(colour, sizeof colour, "\"#%02x%02x%02x\"", c.x, c.y, c.z);
      out.append(i > 1 ? ", " : "").append(colour).append(i + 1 == plan.label_colours.size() ? "]\n" : "");
    }
  }
  if (!plan.shape_values.empty()) {
    out += "\n[shape]  # intensities used where shape.mha has 1, 2, ...; 0: as scanned\nvalues = [";
    for (std::size_t i = 0; i < plan.shape_values.size(); ++i)
      out += (i > 0 ? ", " : "") + std::to_string(plan.shape_values[i]);
    out += "]\n";
  }
  if (plan.quality) {
    out += "\n[quality]  # of the scan, measured at import: lengths in mm, noise in the scan's units\n";
    for_each_quality(*plan.quality, [&](const char* key, const std::optional<double>& value) {
      if (value) number(key, rounded(*value));
    });
    number("slice_step", rounded(plan.quality->slice_step));
    line("edges", std::to_string(plan.quality->edge_count));
    if (plan.quality->is_rough) line("rough", "true");
  }
  for (const CaseStructure& s : plan.structures) {
    out += "\n[[structures]]\n";
    line("name", toml_text(s.shape.name));
    if (!s.volume.empty()) line("volume", toml_text(s.volume));
    if (s.shape.is_label()) line("label", std::to_string(s.shape.label));
    if (!s.shape.is_label() && std::isfinite(s.shape.low)) number("low", s.shape.low);
    if (!s.shape.is_label() && std::isfinite(s.shape.high)) number("high", s.shape.high);
    line("touchable", s.is_touchable ? "true" : "false");
    if (s.is_forbidden) line("forbidden", "true");
    if (s.blocks_back) line("sides", toml_text(s.blocks_front ? "both" : "back"));
    const auto material = [&](const CaseMaterial& m, const std::string& prefix) {
      for (const auto& [key, value, high] : k_material_keys)
        if (m.*value) number((prefix + std::string(key)).c_str(), *(m.*value));
    };
    material(s.material, "");
    if (s.back_material) material(*s.back_material, k_back);
  }
  for (const CaseVolume& v : plan.volumes) {
    out += "\n[[volumes]]\n";
    line("name", toml_text(v.name));
    line("file", toml_text(v.file));
    if (v.matter)
      line("matter", toml_text(std::string(volume::k_matters[static_cast<std::size_t>(*v.matter)])));
  }
  for (const CaseModel& m : plan.models) {
    out += "\n[[models]]\n";
    line("name", toml_text(m.name));
    line("file", toml_text(m.file));
    line("matter", toml_text(std::string(volume::k_matters[static_cast<std::size_t>(m.matter)])));
    if (m.is_forbidden) line("forbidden", "true");
    if (!m.is_touchable) line("touchable", "false");
  }
  for (const volume::PlannedTrajectory& t : plan.trajectories) {
    out += "\n[[trajectories]]\n";
    line("name", toml_text(t.name));
    point("entry", t.entry_world);
    point("target", t.target_world);
    if (t.diameter > 0) number("diameter", t.diameter);
    if (!t.group.empty()) line("group", toml_text(t.group));
    if (!t.side.empty()) line("side", toml_text(t.side));
    if (!t.vertebra.empty()) line("vertebra", toml_text(t.vertebra));
  }
  for (const volume::PlannedLandmark& l : plan.landmarks) {
    out += "\n[[landmarks]]\n";
    line("name", toml_text(l.name));
    point("at", l.position_world);
  }
  for (const volume::PlannedOutline& o : plan.outlines) {
    out += "\n[[outlines]]\n";
    line("name", toml_text(o.name));
    std::string points;
    for (const glm::dvec3& p : o.points_world) points += (points.empty() ? "" : ", ") + point_text(p);
    line("points", "[" + points + "]");
  }
  for (const volume::PlannedPlane& p : plan.planes) {
    out += "\n[[planes]]\n";
    line("name", toml_text(p.name));
    point("at", p.point_world);
    line("normal", vector_text(p.normal_world));
  }
  for (const volume::PlannedTarget& t : plan.targets) {
    out += "\n[[targets]]\n";
    line("name", toml_text(t.name));
    line("label", toml_text(t.label));
  }
  if (!plan.procedure_file.empty() || !plan.procedure.is_empty()) {
    out += "\n[procedure]  # steps of the operation\n";
    if (plan.procedure_file.empty())
      line("name", toml_text(plan.procedure.name));
    else
      line("file", toml_text(plan.procedure_file));
  }
  return out + score_text(plan.score);
}

}  // namespace trephine::data_tools
