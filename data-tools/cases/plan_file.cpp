#include "data-tools/cases/plan_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"

namespace trephine::data_tools {

using nlohmann::json;

namespace {

constexpr std::uintmax_t k_max_bytes = 64u << 20;

/// Returns the factors that convert coordinates of a frame to LPS; empty for an unknown frame. The frame is
/// "LPS" or "RAS", or Slicer's number for it: 1 or 0.
std::optional<glm::dvec3> signs_of(const std::string& frame) {
  if (frame == "LPS" || frame == "1") return glm::dvec3(1);
  if (frame == "RAS" || frame == "0") return glm::dvec3(-1, -1, 1);
  return std::nullopt;
}

Error frame_error(const std::string& where, const std::string& found) {
  return Error{.what = "the frame of the points is missing or unknown",
               .where = where,
               .found = found.empty() ? "no frame" : found,
               .expected = "LPS or RAS",
               .remedy = "export the points again with their coordinate system"};
}

/// Returns the common prefix of the names of a line's two points. Slicer names the points of the line
/// "L3" as "L3-1" and "L3-2".
std::string common_name(std::string a, const std::string& b) {
  a.resize(static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin()));
  while (!a.empty() && std::string_view(" -_.").find(a.back()) != std::string_view::npos) a.pop_back();
  return a;
}

std::string text_of(const json& value, const char* key) {
  const auto found = value.find(key);
  return found != value.end() && found->is_string() ? found->get<std::string>() : "";
}

Result<PlanFile> read_markups(const std::string& text, const std::string& where) {
  const Error format_error{"the markups cannot be read", where, "",
                           "markups with controlPoints, as 3D Slicer writes them",
                           "save them again as .mrk.json"};
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object() || !root.contains("markups") || !root["markups"].is_array()) return format_error;
  PlanFile plan;
  std::size_t undefined_count = 0, line_count = 0;
  for (const json& markup : root["markups"]) {
    if (!markup.is_object()) return format_error;
    const std::string type = text_of(markup, "type"), frame = text_of(markup, "coordinateSystem"),
                      unit = text_of(markup, "coordinateUnits");
    const auto signs = signs_of(frame);
    if (!signs) return frame_error(where, frame);
    if (!unit.empty() && unit != "mm")
      return Error{.what = "the file's points are not in mm",
                   .where = where,
                   .found = unit,
                   .expected = "mm",
                   .remedy = "export the points again in mm"};
    std::vector<volume::PlannedLandmark> points;
    const auto control_points = markup.find("controlPoints");
    if (control_points == markup.end() || !control_points->is_array()) continue;
    for (const json& point : *control_points) {
      if (!point.is_object()) return format_error;
      const std::string status = text_of(point, "positionStatus");
      const auto position = point.find("position");
      if ((!status.empty() && status != "defined") || position == point.end()) {
        ++undefined_count;
        continue;
      }
      if (!position->is_array() || position->size() != 3) return format_error;
      volume::PlannedLandmark landmark;
      landmark.name = text_of(point, "label");
      for (std::size_t a = 0; a < 3; ++a) {
        if (!(*position)[a].is_number()) return format_error;
        landmark.position_world[static_cast<int>(a)] =
            (*signs)[static_cast<int>(a)] * (*position)[a].get<double>();
      }
      points.push_back(std::move(landmark));
    }
    if (type == "Line") {
      ++line_count;
      if (points.size() != 2) {
        plan.notices.push_back("line " + std::to_string(line_count) + " has " +
                               counted(points.size(), "point") + " and was skipped");
        continue;
      }
      std::string name = text_of(markup, "name");
      if (name.empty()) name = common_name(points[0].name, points[1].name);
      if (name.empty()) name = "line-" + std::to_string(line_count);
      plan.trajectories.push_back({name, points[0].position_world, points[1].position_world, 0});
    } else {
      for (volume::PlannedLandmark& point : points) {
        if (point.name.empty()) point.name = "point-" + std::to_string(plan.landmarks.size() + 1);
        plan.landmarks.push_back(std::move(point));
      }
    }
  }
  if (undefined_count > 0)
    plan.notices.push_back("skipped " + counted(undefined_count, "point") + " without a position");
  return plan;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::string cell;
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == ',' && !is_quoted) {
      cells.push_back(cell);
      cell.clear();
    } else if (c != '"' && c != '\r') {
      cell += c;
    }
  }
  cells.push_back(cell);
  for (std::string& text : cells) {
    text.erase(0, std::min(text.size(), text.find_first_not_of(" \t")));
    text.erase(text.find_last_not_of(" \t") + 1);
  }
  return cells;
}

Result<PlanFile> read_table(const std::string& text, const std::string& where, bool is_fcsv) {
  std::istringstream lines(text);
  std::map<std::string, std::size_t> column;
  std::optional<glm::dvec3> signs;
  PlanFile plan;
  std::string header_location, header;
  const auto set_columns = [&](const std::string& list_location, const std::string& list) {
    header_location = list_location;
    header = list.substr(0, 80);
    const auto cells = cells_of(list);
    for (std::size_t i = 0; i < cells.size(); ++i) column[cells[i]] = i;
  };
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
    if (line.find_first_not_of(" \t\r,") == std::string::npos) continue;
    std::string location = where;
    location.append(":").append(std::to_string(number));
    if (line[0] == '#') {  // .fcsv states its frame and columns in comments
      const std::size_t equals = line.find('=');
      if (equals == std::string::npos) continue;
      const auto value = cells_of(line.substr(equals + 1));
      if (line.find("CoordinateSystem") != std::string::npos && !(signs = signs_of(value[0])))
        return frame_error(location, value[0]);
      if (line.find("columns") != std::string::npos) set_columns(location, line.substr(equals + 1));
      continue;
    }
    if (column.empty()) {
      set_columns(location, line);
      continue;
    }
    const auto cells = cells_of(line);
    const auto cell = [&](const std::string& name) -> std::string {
      const auto at = column.find(name);
      return at != column.end() && at->second < cells.size() ? cells[at->second] : "";
    };
    bool is_valid = true;
    const auto number_of = [&](const std::string& name) {
      double v = 0;
      const std::string value = cell(name);
      const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), v);
      is_valid = is_valid && error == std::errc() && end == value.data() + value.size() && std::isfinite(v);
      return v;
    };
    const auto point_of = [&](const std::string& prefix) {
      return glm::dvec3(number_of(prefix + "x"), number_of(prefix + "y"), number_of(prefix + "z")) *
             signs.value_or(glm::dvec3(1));
    };
    std::string name = cell("name").empty() ? cell("label") : cell("name");
    const bool is_line = column.contains("entry_x") && column.contains("target_x");
    if (!is_line && !column.contains("x"))
      return Error{
          .what = "the table lacks the columns of positions",
          .where = header_location,
          .found = header,
          .expected =
              "name,x,y,z for landmarks; name,entry_x,entry_y,entry_z,target_x,target_y,target_z[,diameter] "
              "for trajectories",
          .remedy = header.find(';') != std::string::npos
                        ? "separate the columns by commas instead of semicolons"
                        : "name the columns in the first line"};
    if (is_line) {
      if (name.empty()) name = "line-" + std::to_string(plan.trajectories.size() + 1);
      volume::PlannedTrajectory trajectory{name, point_of("entry_"), point_of("target_"), 0};
      if (!cell("diameter").empty()) trajectory.diameter = number_of("diameter");
      if (trajectory.diameter < 0 || trajectory.diameter > 100)
        return Error{.what = "a diameter is out of range",
                     .where = location,
                     .found = cell("diameter"),
                     .expected = "0 to 100 mm",
                     .remedy = "state diameters in mm"};
      plan.trajectories.push_back(trajectory);
    } else {
      if (name.empty()) name = "point-" + std::to_string(plan.landmarks.size() + 1);
      plan.landmarks.push_back({name, point_of("")});
    }
    if (!is_valid)
      return Error{.what = "invalid number in the table",
                   .where = location,
                   .found = line.substr(0, 80),
                   .expected = "numbers with a decimal point, in mm",
                   .remedy = "write numbers without units and with a decimal point"};
  }
  if (!signs && is_fcsv)
    return frame_error(where, "");  // no default: old .fcsv files are RAS, newer ones LPS
  if (!signs && plan.trajectories.size() + plan.landmarks.size() > 0)
    plan.notices.emplace_back(
        "the table does not state its frame: LPS was assumed (x left, y back, z up); state another frame in the "
        "first line: \"# CoordinateSystem = RAS\"");
  return plan;
}

}  // namespace

Result<PlanFile> read_plan(const std::string& path) {
  const std::string where = file_name(path);
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);  // fails unless `path` is a regular file
  std::ifstream file;
  if (!error) file.open(path, std::ios::binary);
  if (error || !file || bytes > k_max_bytes)
    return Error{.what = "the plan cannot be read",
                 .where = where,
                 .found = error ? "" : std::to_string(bytes) + " bytes",
                 .expected = "a file .mrk.json, .csv or .fcsv of at most 64 MiB",
                 .remedy = "check the spelling, and that you may read the file"};
  std::ostringstream text;
  text << file.rdbuf();
  Result<PlanFile> plan = has_extension(path, ".json")
                              ? read_markups(text.str(), where)
                              : read_table(text.str(), where, has_extension(path, ".fcsv"));
  if (plan)
    for (const volume::PlannedTrajectory& t : plan.value().trajectories)
      if (glm::length(t.target_world - t.entry_world) < 0.1)
        return Error{.what = "a trajectory has no direction",
                     .where = where,
                     .found = t.name + ": entry and target have the same position",
                     .expected = "two positions at least 0.1 mm apart",
                     .remedy = "set its points again"};
  if (plan && plan.value().trajectories.empty() && plan.value().landmarks.empty())
    return Error{.what = "the plan contains no trajectory and no landmark",
                 .where = where,
                 .expected = "at least one",
                 .remedy = "check that it is the right file"};
  return plan;
}

}  // namespace trephine::data_tools
