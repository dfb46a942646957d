#include "data-tools/plan_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "data-tools/atomic_file.h"
#include "data-tools/words.h"

namespace trephine::data_tools {

using nlohmann::json;
using volume::Error;
using volume::Result;

namespace {

constexpr std::uintmax_t k_most_bytes = 64u << 20;

/// "LPS", "RAS", Slicer's numbers; nothing: another frame, or none.
std::optional<glm::dvec3> signs_of(const std::string& frame) {
  if (frame == "LPS" || frame == "1") return glm::dvec3(1);
  if (frame == "RAS" || frame == "0") return glm::dvec3(-1, -1, 1);
  return std::nullopt;
}

Error unknown_frame(const std::string& where, const std::string& found) {
  return {"the file does not say in which frame its points are", where, found.empty() ? "nothing" : found,
          "LPS or RAS", "export it again with its coordinate system"};
}

/// Slicer's names are "L3-1", "L3-2": of a line, what they have in common.
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
  const Error broken{"the markups cannot be understood", where, "",
                     "markups with controlPoints, as 3D Slicer writes them", "save them again as .mrk.json"};
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object() || !root.contains("markups") || !root["markups"].is_array()) return broken;
  PlanFile plan;
  std::size_t unplaced = 0, line_count = 0;
  for (const json& markup : root["markups"]) {
    if (!markup.is_object()) return broken;
    const std::string type = text_of(markup, "type"), frame = text_of(markup, "coordinateSystem"),
                      unit = text_of(markup, "coordinateUnits");
    const auto signs = signs_of(frame);
    if (!signs) return unknown_frame(where, frame);
    if (!unit.empty() && unit != "mm")
      return Error{"the file's points are not in mm", where, unit, "mm", "export it again in mm"};
    std::vector<CaseLandmark> points;
    const auto listed = markup.find("controlPoints");
    if (listed == markup.end() || !listed->is_array()) continue;
    for (const json& point : *listed) {
      if (!point.is_object()) return broken;
      const std::string status = text_of(point, "positionStatus");
      const auto position = point.find("position");
      if ((!status.empty() && status != "defined") || position == point.end()) {
        ++unplaced;
        continue;
      }
      if (!position->is_array() || position->size() != 3) return broken;
      CaseLandmark landmark;
      landmark.name = text_of(point, "label");
      for (std::size_t a = 0; a < 3; ++a) {
        if (!(*position)[a].is_number()) return broken;
        landmark.place_world[static_cast<int>(a)] =
            (*signs)[static_cast<int>(a)] * (*position)[a].get<double>();
      }
      points.push_back(std::move(landmark));
    }
    if (type == "Line") {
      ++line_count;
      if (points.size() != 2) {
        plan.notices.push_back("line " + std::to_string(line_count) + " has " +
                               counted(points.size(), "point") + " and was passed over");
        continue;
      }
      std::string name = text_of(markup, "name");
      if (name.empty()) name = common_name(points[0].name, points[1].name);
      if (name.empty()) name = "line-" + std::to_string(line_count);
      plan.trajectories.push_back({name, points[0].place_world, points[1].place_world, 0});
    } else {
      for (CaseLandmark& point : points) {
        if (point.name.empty()) point.name = "point-" + std::to_string(plan.landmarks.size() + 1);
        plan.landmarks.push_back(std::move(point));
      }
    }
  }
  if (unplaced > 0) plan.notices.push_back(counted(unplaced, "point") + " without a place passed over");
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

Result<PlanFile> read_table(const std::string& text, const std::string& where, bool is_slicers) {
  std::istringstream lines(text);
  std::map<std::string, std::size_t> column;
  std::optional<glm::dvec3> signs;
  PlanFile plan;
  std::string header_at, header;
  const auto name_columns = [&](const std::string& at, const std::string& list) {
    header_at = at;
    header = list.substr(0, 80);
    const auto cells = cells_of(list);
    for (std::size_t i = 0; i < cells.size(); ++i) column[cells[i]] = i;
  };
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
    if (line.find_first_not_of(" \t\r,") == std::string::npos) continue;
    std::string here = where;
    here.append(":").append(std::to_string(number));
    if (line[0] == '#') {  // .fcsv says its frame and its columns so
      const std::size_t equals = line.find('=');
      if (equals == std::string::npos) continue;
      const auto value = cells_of(line.substr(equals + 1));
      if (line.find("CoordinateSystem") != std::string::npos && !(signs = signs_of(value[0])))
        return unknown_frame(here, value[0]);
      if (line.find("columns") != std::string::npos) name_columns(here, line.substr(equals + 1));
      continue;
    }
    if (column.empty()) {
      name_columns(here, line);
      continue;
    }
    const auto cells = cells_of(line);
    const auto cell = [&](const std::string& name) -> std::string {
      const auto at = column.find(name);
      return at != column.end() && at->second < cells.size() ? cells[at->second] : "";
    };
    bool is_good = true;
    const auto number_of = [&](const std::string& name) {
      double v = 0;
      const std::string value = cell(name);
      const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), v);
      is_good = is_good && error == std::errc() && end == value.data() + value.size() && std::isfinite(v);
      return v;
    };
    const auto point_of = [&](const std::string& before) {
      return glm::dvec3(number_of(before + "x"), number_of(before + "y"), number_of(before + "z")) *
             signs.value_or(glm::dvec3(1));
    };
    std::string name = cell("name").empty() ? cell("label") : cell("name");
    const bool is_line = column.contains("entry_x") && column.contains("target_x");
    if (!is_line && !column.contains("x"))
      return Error{
          "the table's columns are not known", header_at, header,
          "name,x,y,z for landmarks; name,entry_x,entry_y,entry_z,target_x,target_y,target_z[,diameter] "
          "for trajectories",
          header.find(';') != std::string::npos ? "part them by commas, not semicolons"
                                                : "name them in the first line"};
    if (is_line) {
      if (name.empty()) name = "line-" + std::to_string(plan.trajectories.size() + 1);
      CaseTrajectory line_of{name, point_of("entry_"), point_of("target_"), 0};
      if (!cell("diameter").empty()) line_of.diameter = number_of("diameter");
      if (line_of.diameter < 0 || line_of.diameter > 100)
        return Error{"a diameter is out of range", here, cell("diameter"), "0 to 100 mm", ""};
      plan.trajectories.push_back(line_of);
    } else {
      if (name.empty()) name = "point-" + std::to_string(plan.landmarks.size() + 1);
      plan.landmarks.push_back({name, point_of("")});
    }
    if (!is_good)
      return Error{"a number of the table cannot be read", here, line.substr(0, 80),
                   "numbers with a point, in mm", "no unit and no comma in a number"};
  }
  if (!signs && is_slicers) return unknown_frame(where, "");  // old ones are RAS, newer ones LPS
  if (!signs && plan.trajectories.size() + plan.landmarks.size() > 0)
    plan.notices.emplace_back(
        "the table does not say its frame: its points were taken as LPS (x left, y back, z up); a first line "
        "\"# CoordinateSystem = RAS\" says otherwise");
  return plan;
}

}  // namespace

Result<PlanFile> read_plan(const std::string& path) {
  const std::string where = file_name(path);
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);  // fails of what is no plain file
  std::ifstream file;
  if (!error) file.open(path, std::ios::binary);
  if (error || !file || bytes > k_most_bytes)
    return Error{"the plan cannot be read", where, error ? "" : std::to_string(bytes) + " bytes",
                 "a file .mrk.json, .csv or .fcsv", "check the spelling"};
  std::ostringstream text;
  text << file.rdbuf();
  Result<PlanFile> plan = has_extension(path, ".json")
                              ? read_markups(text.str(), where)
                              : read_table(text.str(), where, has_extension(path, ".fcsv"));
  if (plan)
    for (const CaseTrajectory& t : plan.value().trajectories)
      if (glm::length(t.target_world - t.entry_world) < 0.1)
        return Error{"a trajectory has no direction", where, t.name + ": entry and target are in one place",
                     "two places", "place them again"};
  if (plan && plan.value().trajectories.empty() && plan.value().landmarks.empty())
    return Error{"there is neither a trajectory nor a landmark in the plan", where, "", "some",
                 "is it the right file?"};
  return plan;
}

}  // namespace trephine::data_tools
