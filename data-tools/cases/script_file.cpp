#include "data-tools/cases/script_file.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "data-tools/cases/toml_reader_impl.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::data_tools {

namespace {

constexpr double k_longest_seconds = 7200;
constexpr std::size_t k_max_parameter_characters = 20000;

/// Reads [[t, x, y, z, button, share], ...]. `button` and `share` are optional, and `share` requires a place.
std::vector<std::array<double, 6>> read_points(TomlReader& reader, const toml::table& t, bool has_place) {
  std::vector<std::array<double, 6>> result;
  const auto it = t.find("points");
  if (it == t.end()) return result;
  const char* const expected =
      has_place
          ? "points = [[t, right, up, above, button, share], ...]: s, mm, 0 or 1, share of the thickness"
          : "points = [[t, x, y, z, button], ...]: s, mm (LPS), 0 or 1";
  const std::size_t max_columns = has_place ? 6 : 5;
  if (!it->second.is_array())
    return reader.fail(it->second, "the points are not a list", "", expected), result;
  for (const toml::value& row : it->second.as_array()) {
    std::array<double, 6> point{};
    bool is_valid = row.is_array() && row.as_array().size() >= 4 && row.as_array().size() <= max_columns;
    for (std::size_t i = 0; is_valid && i < row.as_array().size(); ++i) {
      const toml::value& v = row.as_array()[i];
      is_valid = v.is_integer() || v.is_floating();
      if (is_valid) point[i] = v.is_integer() ? static_cast<double>(v.as_integer()) : v.as_floating();
      is_valid = is_valid && std::abs(point[i]) < 1e6;
    }
    if (!is_valid || (point[4] != 0 && point[4] != 1))
      reader.fail(row, "invalid point of a path", "", expected);
    result.push_back(point);
  }
  return result;
}

/// Returns the direction `stated`, or `fallback` if it is not stated. Error if `stated` has almost no
/// length.
glm::dvec3 read_direction(TomlReader& reader, const toml::value& v, std::optional<glm::dvec3> stated,
                          const glm::dvec3& fallback) {
  if (stated && !(glm::length(*stated) >= 1e-3))
    reader.fail(v, "invalid direction", "a length near 0", "[x, y, z], not all 0");
  return stated.value_or(fallback);
}

ScriptHand read_hand(TomlReader& reader, const toml::value& value) {
  const toml::table& t =
      reader.table(value, {"instrument", "parameters", "method", "radius", "tool", "tool_spacing", "effects",
                           "path", "points", "place", "shaft", "stiffness"});
  ScriptHand hand;
  hand.line = TomlReader::line_of(value);
  hand.instrument = reader.text(t, "instrument").value_or("");
  hand.parameters = reader.text(t, "parameters").value_or("");
  hand.method = reader.text(t, "method").value_or("");
  hand.radius = reader.number(t, "radius", 0, 6).value_or(0);
  hand.tool = reader.text(t, "tool").value_or("");
  hand.tool_spacing = reader.number(t, "tool_spacing", 0.02, 10);
  if (hand.tool.empty() && hand.tool_spacing)
    reader.fail(value, "a spacing without a tool", "tool_spacing", "also the key tool, or no spacing");
  if (!hand.tool.empty() && hand.radius > 0)
    reader.fail(value, "a hand has one tool", "tool and radius", "tool or radius");
  hand.effects = reader.texts(t, "effects");
  hand.path = reader.text(t, "path").value_or("");
  hand.place = reader.text(t, "place").value_or("");
  hand.points = read_points(reader, t, !hand.place.empty());
  if (const auto shaft = reader.point(t, "shaft"))
    hand.shaft = read_direction(reader, value, shaft, {0, 0, 1});
  hand.stiffness = reader.number(t, "stiffness", 0.01, 10);
  if (!hand.place.empty() && hand.points.empty())
    reader.fail(value, "a path file cannot be relative to a place", hand.place, "points, or no place");
  if (hand.shaft && hand.points.empty())
    reader.fail(value, "a path file already contains the orientation of the tool", "shaft",
                "points, or no shaft");
  if (hand.path.empty() == hand.points.empty())
    reader.fail(value, "a hand requires exactly one path",
                hand.path.empty() ? "no path" : "both path and points", "path = \"FILE.csv\", or points");
  if (hand.instrument.empty() && !hand.parameters.empty())
    reader.fail(value, "parameters without an instrument", hand.parameters,
                "also the key instrument, for example instrument = \"burr\"");
  return hand;
}

ScriptPlace read_place(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"name", "trajectory", "body", "from", "up", "thickness"});
  ScriptPlace place;
  place.line = TomlReader::line_of(value);
  place.name = reader.text(t, "name").value_or("");
  place.trajectory = reader.text(t, "trajectory").value_or("");
  const double body = reader.number(t, "body", 1, 1e6).value_or(0);
  if (body != std::floor(body))
    reader.fail(t.at("body"), "body is not a whole number", text_of(body), "1, 2, ...");
  place.body = static_cast<std::int64_t>(body);
  place.up = read_direction(reader, value, reader.point(t, "up"), place.up);
  place.min_thickness = reader.number(t, "thickness", 0, 20).value_or(0);
  const auto from = t.find("from");
  if (from != t.end() && from->second.is_array())
    for (const toml::value& item : from->second.as_array()) {
      if (item.is_array())
        place.from.push_back(read_direction(reader, item, reader.point_of(item, "from"), {0, 0, 1}));
      else
        reader.fail(item, "from is not a list of directions", "", "from = [[x, y, z], ...]");
    }
  if (place.name.empty() || !place.from.empty() + !place.trajectory.empty() + (place.body > 0) != 1)
    reader.fail(value, "a place is not complete", "",
                "name = \"text\", and one of: from = [[x, y, z], ...] (directions from the middle of the "
                "scan), trajectory = \"text\", or body = number");
  return place;
}

ScriptModel read_script_model(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"file", "at", "screw", "matter", "forbidden", "depth",
                                              "depth_beat", "depth_repeats", "depth_rate"});
  ScriptModel model;
  model.line = TomlReader::line_of(value);
  model.file = reader.text(t, "file").value_or("");
  model.at = reader.point(t, "at").value_or(model.at);
  model.matter = read_matter(reader, value, t);
  model.is_forbidden = reader.boolean(t, "forbidden").value_or(false);
  model.is_depth = reader.boolean(t, "depth").value_or(false);
  model.beat = reader.number(t, "depth_beat", 1e-3, 1000).value_or(model.beat);
  model.rate = reader.number(t, "depth_rate", 10, 1000).value_or(model.rate);
  model.is_repeating = reader.boolean(t, "depth_repeats").value_or(false);
  if (const auto screw = reader.text(t, "screw")) {
    const auto place = parse_screw(*screw);
    if (place)
      model.screw = place.value();
    else
      reader.fail(value, place.error().what, place.error().found, place.error().expected);
  } else if (model.file.empty()) {
    reader.fail(value, "a model has neither file nor screw", "",
                "file = \"FILE\", or screw = \"X,Y,Z:X,Y,Z:D\"");
  }
  return model;
}

ScriptVolume read_script_volume(TomlReader& reader, const toml::value& value) {
  const toml::table& t = reader.table(value, {"file", "shape", "name", "matter"});
  ScriptVolume volume;
  volume.line = TomlReader::line_of(value);
  volume.file = reader.text(t, "file").value_or("");
  volume.shape = reader.text(t, "shape").value_or("");
  volume.name = reader.text(t, "name").value_or("");
  if (t.contains("matter")) volume.matter = read_matter(reader, value, t);
  if (volume.file.empty()) reader.fail(value, "a volume has no file", "", "file = \"FILE\"");
  return volume;
}

/// Returns the index of a hand; 0 if the key is absent.
int read_hand_index(TomlReader& reader, const toml::value& value, const toml::table& t, std::size_t hands) {
  const double hand = reader.number(t, "hand", 0, static_cast<double>(hands) - 1).value_or(0);
  if (hand != std::floor(hand)) reader.fail(value, "hand is not a whole number", text_of(hand), "0, 1, ...");
  return static_cast<int>(hand);
}

/// Returns the opacities (0 to 1) of structures, from a table of percentages; empty if the key is absent.
std::vector<std::pair<std::string, double>> read_opacities(TomlReader& reader, const toml::table& t) {
  std::vector<std::pair<std::string, double>> opacities;
  const auto it = t.find("opacity");
  if (it == t.end()) return opacities;
  if (!it->second.is_table()) {
    reader.fail(it->second, "opacity is not a table", "", "opacity = { bone = 25 }, from 0 hidden to 100");
    return opacities;
  }
  const toml::table& percentages = it->second.as_table();
  for (const auto& [name, value] : percentages)
    opacities.emplace_back(name, 0.01 * reader.number(percentages, name, 0, 100).value_or(100));
  std::sort(opacities.begin(), opacities.end());
  return opacities;
}

ScriptPicture read_picture(TomlReader& reader, const toml::value& value, std::size_t hands) {
  const toml::table& t = reader.table(
      value, {"at", "file", "place", "from", "aim", "distance", "caption", "tool", "hand", "opacity"});
  ScriptPicture picture;
  picture.line = TomlReader::line_of(value);
  picture.at = reader.number(t, "at", 0, k_longest_seconds);
  picture.hand = read_hand_index(reader, value, t, hands);
  picture.file = reader.text(t, "file").value_or("");
  picture.place = reader.text(t, "place").value_or("");
  picture.from = read_direction(reader, value, reader.point(t, "from"),
                                picture.place.empty() ? glm::dvec3(0.8, -0.8, 0.35) : glm::dvec3(0, 0, 1));
  picture.aim = reader.point(t, "aim").value_or(picture.aim);
  picture.distance = reader.number(t, "distance", 1, 5000);
  picture.caption = reader.text(t, "caption").value_or("");
  picture.has_tool = reader.boolean(t, "tool").value_or(true);
  picture.opacities = read_opacities(reader, t);
  if (!picture.file.ends_with(".png") || picture.file.find('/') != std::string::npos ||
      picture.file.starts_with('.'))
    reader.fail(value, "invalid file name of a picture", picture.file,
                "file = \"NAME.png\", without a folder");
  if (!picture.place.empty() && !picture.distance)
    reader.fail(value, "a picture of a place has no distance", "", "distance = mm, from the place");
  return picture;
}

/// Checks names: error if two places or two pictures have the same name, if a place is unknown, or if the
/// points of a hand are relative to a body.
void check_places(TomlReader& reader, const Script& script) {
  std::string known;
  for (std::size_t i = 0; i < script.places.size(); ++i) {
    known += (i ? ", " : "") + script.places[i].name;
    for (std::size_t j = 0; j < i; ++j)
      if (script.places[i].name == script.places[j].name)
        reader.fail(script.places[i].line, "two places have the same name", script.places[i].name,
                    "different names");
  }
  const auto check = [&](const std::string& name, int line) {
    if (name.empty()) return;
    for (const ScriptPlace& place : script.places)
      if (place.name == name) return;
    reader.fail(line, "unknown place", name, known.empty() ? "[[places]] first" : known);
  };
  for (const ScriptHand& hand : script.hands) {
    check(hand.place, hand.line);
    for (const ScriptPlace& place : script.places)
      if (place.name == hand.place && place.body > 0)
        reader.fail(hand.line, "the points of a hand cannot be relative to a body", hand.place,
                    "a place of the anatomy", "use the place of a body in commands and pictures");
  }
  for (const ScriptPicture& picture : script.pictures) check(picture.place, picture.line);
  for (std::size_t i = 0; i < script.pictures.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (script.pictures[i].file == script.pictures[j].file)
        reader.fail(script.pictures[i].line, "two pictures have the same name", script.pictures[i].file,
                    "different names");
}

ScriptCommand read_command(TomlReader& reader, const toml::value& value, std::size_t hands) {
  const toml::table& t = reader.table(value, {"at", "hand", "command", "with", "refused"});
  ScriptCommand command;
  command.line = TomlReader::line_of(value);
  const auto at = reader.number(t, "at", 0, k_longest_seconds);
  const auto name = reader.text(t, "command");
  if (!at || !name)
    reader.fail(value, "a command is not complete", "", "at = seconds and command = \"name\"");
  command.at = at.value_or(0);
  command.name = name.value_or("");
  command.hand = read_hand_index(reader, value, t, hands);
  command.words = reader.text(t, "with", k_max_parameter_characters).value_or("");
  if (const auto refused = t.find("refused"); refused == t.end())
    return command;
  else if (refused->second.is_string())
    command.refusal = reader.text(t, "refused").value_or("");
  else if (reader.boolean(t, "refused").value_or(false))
    command.refusal = "";
  return command;
}

ScriptExpectation read_expectation(TomlReader& reader, const toml::value& value, std::size_t hands) {
  const toml::table& t = reader.table(value, {"at", "hand", "what", "least", "most"});
  ScriptExpectation expectation;
  expectation.line = TomlReader::line_of(value);
  expectation.at = reader.number(t, "at", 0, k_longest_seconds);
  expectation.hand = read_hand_index(reader, value, t, hands);
  expectation.what = reader.text(t, "what").value_or("");
  expectation.minimum = reader.number(t, "least", -1e12, 1e12),
  expectation.maximum = reader.number(t, "most", -1e12, 1e12);
  if (expectation.what.empty() || (!expectation.minimum && !expectation.maximum))
    reader.fail(value, "an expectation is not complete", "", "what = \"name\", and least, most or both");
  if (expectation.minimum && expectation.maximum && *expectation.minimum > *expectation.maximum)
    reader.fail(value, "the limits of an expectation are reversed", "", "least <= most",
                "swap the two values");
  return expectation;
}

}  // namespace

Result<Script> parse_script(const std::string& text, const std::string& where) {
  Result<toml::value> parsed = parse_toml(text, where, "script");
  if (!parsed) return parsed.error();
  const toml::value& root = parsed.value();
  TomlReader reader(where);
  const toml::table& top = reader.table(root, {"schema",
                                               "title",
                                               "scan",
                                               "iso",
                                               "window",
                                               "label",
                                               "auto",
                                               "largest",
                                               "plan",
                                               "procedure",
                                               "rate",
                                               "static_friction",
                                               "dynamic_friction",
                                               "smallest_burr",
                                               "free_pieces",
                                               "places",
                                               "volumes",
                                               "models",
                                               "hands",
                                               "do",
                                               "expect",
                                               "pictures"});
  if (Status error = reader.check_schema(top, Script::k_schema, "script")) return *error;
  Script script;
  script.title = reader.text(top, "title").value_or("");
  const auto scan = reader.text(top, "scan");
  if (!scan) reader.fail(root, "the script has no scan", "", "scan = \"head\", a file, or a folder");
  script.scan = scan.value_or("");
  script.iso = reader.number(top, "iso", -1e6, 1e6);
  script.window = reader.text(top, "window").value_or("");
  script.label = reader.text(top, "label").value_or("");
  script.is_auto = reader.boolean(top, "auto").value_or(false);
  script.is_largest = reader.boolean(top, "largest").value_or(false);
  script.uses_plan = reader.boolean(top, "plan").value_or(false);
  script.procedure = reader.text(top, "procedure").value_or("");
  script.rate_hz = reader.number(top, "rate", 10, 100000).value_or(1000);
  script.static_friction = reader.number(top, "static_friction", 0, 10);
  script.dynamic_friction = reader.number(top, "dynamic_friction", 0, 10);
  script.free_pieces = reader.number(top, "free_pieces", 0, 1e6);
  script.smallest_burr = reader.number(top, "smallest_burr", 1e-3, 30);
  for (const toml::value* v : reader.tables(top, "hands")) script.hands.push_back(read_hand(reader, *v));
  if (script.hands.empty() || script.hands.size() > Script::k_max_hands)
    reader.fail(root, "the number of hands is out of range", std::to_string(script.hands.size()),
                "one to four [[hands]]");
  for (const toml::value* v : reader.tables(top, "places")) script.places.push_back(read_place(reader, *v));
  for (const toml::value* v : reader.tables(top, "volumes"))
    script.volumes.push_back(read_script_volume(reader, *v));
  for (const toml::value* v : reader.tables(top, "models"))
    script.models.push_back(read_script_model(reader, *v));
  for (const toml::value* v : reader.tables(top, "pictures"))
    script.pictures.push_back(read_picture(reader, *v, script.hands.size()));
  check_places(reader, script);
  for (const toml::value* v : reader.tables(top, "do"))
    script.commands.push_back(read_command(reader, *v, script.hands.size()));
  for (const toml::value* v : reader.tables(top, "expect"))
    script.expectations.push_back(read_expectation(reader, *v, script.hands.size()));
  std::stable_sort(script.commands.begin(), script.commands.end(),
                   [](const ScriptCommand& a, const ScriptCommand& b) { return a.at < b.at; });
  if (reader.error()) return *reader.error();
  return script;
}

Result<Script> read_script(const std::string& path) {
  const std::string where = file_name(path);
  const Result<std::string> text = read_toml_text(path, where, "script");
  return text ? parse_script(text.value(), where) : text.error();
}

}  // namespace trephine::data_tools
