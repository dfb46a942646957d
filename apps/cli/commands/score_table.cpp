#include "apps/cli/commands/score_table.h"

#include <algorithm>
#include <vector>

#include "apps/cli/report.h"

namespace trephine::cli {

namespace {

/// Appends a row; `keys` of the object, empty where it lacks them.
void append_row(std::string& csv, const std::vector<Json>& cells) {
  for (std::size_t i = 0; i < cells.size(); ++i) csv += (i > 0 ? "," : "") + csv_cell(cells[i]);
  csv += "\n";
}

std::vector<Json> values_of(const Json& object, const std::vector<std::string>& keys) {
  std::vector<Json> cells;
  for (const std::string& key : keys) cells.push_back(object.contains(key) ? object[key] : Json());
  return cells;
}

}  // namespace

std::string csv_cell(const Json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return text_of_json(value, -1);
  auto text = value.get<std::string>();
  if (!text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos)
    text.insert(0, "'");
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_of_findings(const Json& findings) {
  const std::vector<std::string> keys{"name",   "value",   "unit",    "verdict",    "points",
                                      "weight", "full_at", "zero_at", "at_seconds", "reason"};
  std::string csv;
  append_row(csv, {keys.begin(), keys.end()});
  for (const Json& finding : findings) append_row(csv, values_of(finding, keys));
  return csv;
}

std::string csv_of_sessions(const Json& sessions) {
  const std::vector<std::string> keys{"session", "seconds", "points", "possible", "not_judged", "error"};
  // Names of all findings, in the order of their first session.
  std::vector<std::string> names;
  for (const Json& session : sessions)
    if (session.contains("findings"))
      for (const Json& finding : session["findings"])
        if (const auto name = finding["name"].get<std::string>();
            std::find(names.begin(), names.end(), name) == names.end())
          names.push_back(name);
  std::string csv;
  std::vector<Json> head(keys.begin(), keys.end());
  head.insert(head.end(), names.begin(), names.end());
  append_row(csv, head);
  for (const Json& session : sessions) {
    std::vector<Json> row = values_of(session, keys);
    Json values = Json::object();
    if (session.contains("findings"))
      for (const Json& finding : session["findings"])
        values[finding["name"].get<std::string>()] = finding["value"];
    for (const Json& value : values_of(values, names)) row.push_back(value);
    append_row(csv, row);
  }
  return csv;
}

}  // namespace trephine::cli
