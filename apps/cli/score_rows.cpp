#include "apps/cli/score_rows.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/cli/report.h"
#include "apps/workbench/text.h"

namespace trephine::cli {

namespace {

Json json_of_finding(const sim::Finding& finding, double dt) {
  Json json{{"name", finding.name},     {"value", finding.value ? Json(*finding.value) : Json()},
            {"unit", finding.unit},     {"verdict", workbench::verdict_name(finding)},
            {"points", finding.points}, {"weight", finding.weight}};
  if (finding.full_at != finding.zero_at)
    json["full_at"] = finding.full_at, json["zero_at"] = finding.zero_at;
  if (!finding.reason.empty()) json["reason"] = finding.reason;
  if (finding.tick) json["at_seconds"] = static_cast<double>(*finding.tick) * dt;
  if (finding.position_world) json["position_world_mm"] = json_of(*finding.position_world);
  return json;
}

Json json_of_motion(const workbench::HandMotion& motion) {
  return {{"seconds", motion.seconds},
          {"working_seconds", motion.working_seconds},
          {"idle_seconds", motion.idle_seconds},
          {"path_mm", motion.path},
          {"mean_speed_mm_per_s", motion.mean_speed},
          {"peak_speed_mm_per_s", motion.peak_speed},
          {"jerk_mm_per_s3", motion.jerk},
          {"log_dimensionless_jerk", motion.measured_strokes > 0 ? Json(motion.log_jerk) : Json()},
          {"measured_strokes", motion.measured_strokes},
          {"strokes", motion.strokes},
          {"stroke_length_mm", motion.stroke_length},
          {"stroke_spread_mm", motion.stroke_spread},
          {"mean_force_n", motion.mean_force},
          {"peak_force_n", motion.peak_force},
          {"near_forbidden_seconds", motion.near_seconds},
          {"pressing_near_forbidden_seconds", motion.near_force_seconds}};
}

void append_row(std::string& csv, const std::vector<Json>& cells) {
  for (std::size_t i = 0; i < cells.size(); ++i) csv += (i > 0 ? "," : "") + csv_cell(cells[i]);
  csv += "\n";
}

/// Returns the values of these keys; null for a key that the object lacks.
std::vector<Json> values_of(const Json& object, const std::vector<std::string>& keys) {
  std::vector<Json> cells;
  for (const std::string& key : keys) cells.push_back(object.contains(key) ? object[key] : Json());
  return cells;
}

}  // namespace

Json json_of_score(const workbench::SessionScore& result, double dt) {
  Json json{{"seconds", result.seconds},
            {"points", result.score.points},
            {"possible", result.score.possible},
            {"not_judged", result.score.not_judged},
            {"is_complete", result.is_complete},
            {"is_same", result.is_same},
            {"critical", result.score.critical},
            {"findings", Json::array()},
            {"motion", Json::array()}};
  for (const sim::Finding& finding : result.score.findings)
    json["findings"].push_back(json_of_finding(finding, dt));
  for (std::size_t i = 0; i < result.motion.size(); ++i) {
    Json motion{{"hand", i + 1}};
    motion.update(json_of_motion(result.motion[i]));
    json["motion"].push_back(std::move(motion));
  }
  return json;
}

void print_score(const Json& score, Rows& rows) {
  Json findings = score["findings"];
  for (Json& finding : findings)  // whole numbers, such as counts, have no decimals
    if (finding["value"].is_number()) {
      const double value = finding["value"];
      finding["value"] = workbench::format_text("%.*f", value == std::floor(value) ? 0 : 2, value);
    }
  rows.print_table(findings,
                   "finding = {name} | value = {value} | unit = {unit} | verdict = {verdict} | points = "
                   "{points:.1f} | of = {weight:.1f}");
  rows.print("points: {points:.1f} of {possible:.1f}; not judged: {not_judged:.1f}", score);
  for (const Json& name : score["critical"])
    for (const Json& finding : findings)
      if (finding["name"] == name)
        rows.print("critical: {name} {value} ({limit} {full_at} for full points)",
                   {{"name", workbench::words_of(name)},
                    {"value", finding["value"]},
                    {"limit", finding["full_at"] > finding["zero_at"] ? "at least" : "at most"},
                    {"full_at", finding["full_at"]}});
  if (!score["is_complete"].get<bool>()) rows.print("The recording is not complete.");
  if (!score["is_same"].get<bool>()) rows.print("The replay differs from the recording.");
  for (const Json& finding : score["findings"])
    if (finding.contains("reason")) rows.print("{name}: {reason}", finding);
}

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
  const std::vector<std::string> keys{"session",    "seconds",     "points",  "possible",
                                      "not_judged", "is_complete", "is_same", "error"};
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
