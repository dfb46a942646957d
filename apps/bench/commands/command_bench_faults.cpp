// faults: plants errors into scripts of the shipped procedures, and reports which findings lose points.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <map>

#include "apps/bench/commands/bench_commands.h"
#include "apps/bench/commands/scored_play.h"

namespace trephine::bench {

using namespace cli;
using data_tools::Script;
using data_tools::ScriptCommand;
using glm::dvec3;

namespace {

constexpr double k_least_loss = 0.05;  // points; smaller changes come from the resolution of the cut lattice

/// Tilts and shifts the path of a hand toward +x (right) of its script position: by `at_entry` mm at the
/// surface and by `at_depth` mm at the depth `depth` (mm). The shaft is tilted with the path.
void move_line(data_tools::ScriptHand& hand, double at_entry, double at_depth, double depth) {
  const double slope = (at_entry - at_depth) / depth;
  for (auto& point : hand.points) point[1] += at_entry + slope * point[3];
  hand.shaft = glm::normalize(dvec3(slope, 0, 1));
}

/// Lowers all points of a hand that are below a height (mm), by `by` mm.
void lower(data_tools::ScriptHand& hand, double below, double by) {
  for (auto& point : hand.points)
    if (point[3] < below) point[3] -= by;
}

void replace(std::string& text, const std::string& from, const std::string& to) {
  if (const std::size_t at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
}

/// Adds `by` (mm) to the first coordinate of a position in the words of a command, "{NAME X,Y,Z}".
void move_position(std::string& words, double by) {
  const std::size_t end = words.rfind('}'), begin = words.rfind(' ', end);
  double x = 0, y = 0, z = 0;
  if (begin != std::string::npos && std::sscanf(words.c_str() + begin, "%lf,%lf,%lf", &x, &y, &z) == 3)
    words.replace(begin, end - begin, format_text(" %g,%g,%g", x + by, y, z));
}

/// Removes the last command with this name that is not expected to be refused.
void remove_last(Script& script, const std::string& name) {
  for (std::size_t i = script.commands.size(); i-- > 0;)
    if (script.commands[i].name == name && !script.commands[i].refusal)
      return void(script.commands.erase(script.commands.begin() + static_cast<std::ptrdiff_t>(i)));
}

void leave_before_the_end(Script& script, workbench::Skill&) { remove_last(script, "go-to-step"); }
void tremble(Script&, workbench::Skill& skill) { skill.tremor = 0.3; }
void tremble_slightly(Script&, workbench::Skill& skill) { skill.tremor = 0.03; }
void tremble_strongly(Script&, workbench::Skill& skill) { skill.tremor = 1.5; }

struct PlantedError {
  const char* procedure;
  const char* name;
  void (*plant)(Script& script, workbench::Skill& skill);
  /// Parts of the names of the findings that this error is expected to change.
  std::vector<std::string> own;
};

const std::vector<PlantedError>& planted_errors() {
  static const std::vector<PlantedError> all{
      {"ventriculostomy",
       "entry shifted by 5 mm, aimed at the target",
       [](Script& s, workbench::Skill&) {
         move_line(s.hands[0], 5, 5, 1);
         lower(s.hands[0], -6, -0.5);  // the dura is nearer there
         move_line(s.hands[1], 5, 0, 59);
       },
       {"entry to plan"}},
      {"ventriculostomy",
       "aimed 5 mm off the target",
       [](Script& s, workbench::Skill&) { move_line(s.hands[1], 0, 5, 59); },
       {"tip to target", "grade of the tip"}},
      {"ventriculostomy",
       "8 mm too deep",
       [](Script& s, workbench::Skill&) { lower(s.hands[1], -50, 8); },
       {"tip to target", "grade of the tip"}},
      {"ventriculostomy",
       "two passages",
       [](Script& s, workbench::Skill&) {
         s.hands[1].points = {{0, 0, 0, 80, 0},    {5.3, 0, 0, 40, 0},  {5.9, 0, 0, 2, 0},
                              {7.2, 0, 0, -59, 0}, {7.9, 0, 0, 40, 0},  {8.3, 0, 0, 2, 0},
                              {9.6, 0, 0, -59, 0}, {10.4, 0, 0, -59, 0}};
       },
       {"passages"}},
      {"ventriculostomy",
       "burr 10 mm beyond the dura",
       [](Script& s, workbench::Skill&) { lower(s.hands[0], -6, 10); },
       {"deepest plunge", ": torn"}},
      {"ventriculostomy", "not completed", leave_before_the_end, {"procedure: complete"}},
      {"ventriculostomy", "tremor of 0.03 mm", tremble_slightly, {"log dimensionless jerk"}},
      {"craniotomy",
       "outline shifted by 6 mm",
       [](Script& s, workbench::Skill&) {
         for (ScriptCommand& command : s.commands)
           if (command.name == "add-anchor") move_position(command.words, -6);
       },
       {"distance from plan", "margin", "exposed"}},
      {"craniotomy", "not completed", leave_before_the_end, {"procedure: complete"}},
      {"craniotomy", "tremor of 1.5 mm", tremble_strongly, {"log dimensionless jerk"}},
      {"laminectomy-screws",
       "probe shifted by 5 mm",
       [](Script& s, workbench::Skill&) { move_line(s.hands[1], 5, 5, 1); },
       {"breach", "beyond bone", "canal gained", "entry to plan", "tip to plan", "body breach"}},
      {"laminectomy-screws",
       "screw 10 mm too long",
       [](Script& s, workbench::Skill&) {
         for (ScriptCommand& command : s.commands) replace(command.words, "length=45", "length=55");
       },
       {"body breach", "length to track", "tip to plan"}},
      {"laminectomy-screws",
       "burr 20 mm too deep",
       [](Script& s, workbench::Skill&) {
         for (auto& point : s.hands[0].points)
           if (point[4] != 0) point[2] -= 20;
       },
       {": torn", "deepest plunge", "facet", "pars", "canal"}},
      {"laminectomy-screws", "not completed", leave_before_the_end, {"procedure: complete"}},
      {"laminectomy-screws", "tremor of 0.3 mm", tremble, {"log dimensionless jerk"}},
  };
  return all;
}

bool is_own(const PlantedError& error, const std::string& finding) {
  return std::any_of(error.own.begin(), error.own.end(),
                     [&](const std::string& part) { return finding.find(part) != std::string::npos; });
}

/// Weight and points of each finding with limits, by name.
using Points = std::map<std::string, std::pair<double, double>>;

Points points_of(const sim::Score& score) {
  Points points;
  for (const sim::Finding& finding : score.findings)
    if (finding.full_at != finding.zero_at) points[finding.name] = {finding.weight, finding.points};
  return points;
}

/// Returns the points that each finding lost through an error. A finding that is missing after the error lost
/// all its points. A finding that exists only after the error lost its weight minus its points.
std::map<std::string, double> lost_points(const Points& before, const Points& after) {
  std::map<std::string, double> lost;
  for (const auto& [name, points] : before) {
    const auto found = after.find(name);
    lost[name] = points.second - (found == after.end() ? 0 : found->second.second);
  }
  for (const auto& [name, points] : after)
    if (!before.contains(name)) lost[name] = points.first - points.second;
  std::erase_if(lost, [](const auto& one) { return std::abs(one.second) < k_least_loss; });
  return lost;
}

struct FaultsArguments {
  std::vector<std::string> scripts;
  std::string only, output;
};

/// Plays a script without and with each of its errors whose name contains `only`; adds a row per error.
Status plant(const Script& script, const std::string& folder, const std::string& only, Json& rows,
             std::string& csv) {
  if (std::none_of(planted_errors().begin(), planted_errors().end(),
                   [&](const PlantedError& error) { return script.procedure == error.procedure; }))
    return Error{.what = "no error is planted for this procedure",
                 .where = "procedure of the script",
                 .found = script.procedure,
                 .expected = "craniotomy, laminectomy-screws or ventriculostomy",
                 .remedy = "choose one of the scripts docs/examples/procedure-*.toml"};
  workbench::Skill exact;
  exact.name = "exact";
  const auto right = play_and_score(script, folder, {exact, 1});
  if (!right) return right.error();
  for (const PlantedError& error : planted_errors()) {
    if (script.procedure != error.procedure || std::string(error.name).find(only) == std::string::npos)
      continue;
    if (is_interrupted()) return interrupted("the comparison");
    notice(std::string(error.procedure) + ": " + error.name);
    Script wrong = script;
    workbench::Skill skill = exact;
    error.plant(wrong, skill);
    const auto played = play_and_score(wrong, folder, {skill, 1});
    if (!played) return played.error();
    double own = 0, others = 0;
    std::string text;
    Json lost = Json::object();
    for (const auto& [finding, loss] :
         lost_points(points_of(right.value().score), points_of(played.value().score))) {
      const bool is_expected = is_own(error, finding);
      (is_expected ? own : others) += std::abs(loss);
      lost[finding] = loss;
      text += (text.empty() ? "" : ", ") + finding + format_text(" %.1f", loss);
      csv += format_text("%s,\"%s\",\"%s\",%.3f,%s\n", error.procedure, error.name, finding.c_str(), loss,
                         is_expected ? "own" : "other");
    }
    rows.push_back({{"procedure", error.procedure},
                    {"error", error.name},
                    {"own", own},
                    {"others", others},
                    {"lost", lost},
                    {"lost_text", text}});
  }
  return std::nullopt;
}

Result<Outcome> run_faults(const FaultsArguments& arguments) {
  data_tools::OutputSet outputs;
  const auto plant_some = [&](const Script& script, const std::string& folder, Json& rows, std::string& csv) {
    return plant(script, folder, arguments.only, rows, csv);
  };
  const auto rows = run_on_scripts(arguments.scripts, plant_some,
                                   "procedure,error,finding,points_lost,kind\n", arguments.output, outputs);
  if (!rows) return rows.error();
  Outcome outcome("bench.faults");
  outcome.json["rows"] = rows.value();
  bool is_met = true;
  for (const Json& row : rows.value()) is_met = is_met && row["own"] > 0 && row["others"] == 0;
  outcome.json["is_met"] = is_met;
  if (!is_met) outcome.exit_code = exit_check_failed;
  outcome.print_table(
      rows.value(),
      "procedure = {procedure} | planted error = {error} | change of points of its findings = "
      "{own:.1f} | of others = {others:.1f} | findings = {lost_text}");
  return finished(outputs, std::move(outcome));
}

Run build(Options& options) {
  auto a = std::make_shared<FaultsArguments>();
  options.add("SCRIPT", a->scripts, "Scripts that perform a shipped procedure").required();
  options.add("--only", a->only, "Only errors with this text in their name").type("TEXT");
  options.add("-o,--output", a->output, "CSV file with a line for each finding whose points changed")
      .type("CSV");
  return run_with(a, run_faults);
}

}  // namespace

const Command k_faults{"faults", "Plant errors into operations, and report which findings lose points",
                       "  trephine-bench faults docs/examples/procedure-ventriculostomy.toml -o faults.csv",
                       build};

}  // namespace trephine::bench
