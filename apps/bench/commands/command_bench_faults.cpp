// faults: plants errors into scripts of the shipped procedures, and reports which findings lose points.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <glm/geometric.hpp>
#include <map>

#include "apps/bench/commands/bench_commands.h"
#include "apps/bench/commands/scored_play.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::bench {

using namespace cli;
using data_tools::Script;
using data_tools::ScriptCommand;
using glm::dvec3;

namespace {

constexpr double k_least_loss = 0.05;  // points; smaller changes are those of the cut lattice

/// Moves the points of a hand along its line: by `at_entry` mm (to the right) at the surface, and by
/// `at_depth` mm at a depth. The shaft follows the line.
void move_line(data_tools::ScriptHand& hand, double at_entry, double at_depth, double depth) {
  const double slope = (at_entry - at_depth) / depth;
  for (auto& point : hand.points) point[1] += at_entry + slope * point[3];
  hand.shaft = glm::normalize(dvec3(slope, 0, 1));
}

/// Lowers all points of a hand that are below a height.
void lower(data_tools::ScriptHand& hand, double below, double by) {
  for (auto& point : hand.points)
    if (point[3] < below) point[3] -= by;
}

void replace(std::string& text, const std::string& from, const std::string& to) {
  if (const std::size_t at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
}

/// Moves a position in the words of a command, "{NAME X,Y,Z}", to the right.
void move_position(std::string& words, double by) {
  const std::size_t end = words.rfind('}'), begin = words.rfind(' ', end);
  double x = 0, y = 0, z = 0;
  if (begin != std::string::npos && std::sscanf(words.c_str() + begin, "%lf,%lf,%lf", &x, &y, &z) == 3)
    words.replace(begin, end - begin, format_text(" %g,%g,%g", x + by, y, z));
}

/// Removes the last command of a name.
void remove_last(Script& script, const std::string& name) {
  for (std::size_t i = script.commands.size(); i-- > 0;)
    if (script.commands[i].name == name && !script.commands[i].refusal)
      return void(script.commands.erase(script.commands.begin() + static_cast<std::ptrdiff_t>(i)));
}

struct PlantedError {
  const char* procedure;
  const char* name;
  void (*plant)(Script& script, workbench::Skill& skill);
  /// Ends of the names of the findings that this error is expected to change.
  std::vector<std::string> own;
};

const std::vector<PlantedError>& planted_errors() {
  static const std::vector<PlantedError> all{
      {"ventriculostomy",
       "entry 5 mm aside, aimed at the target",
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
      {"ventriculostomy",
       "not completed",
       [](Script& s, workbench::Skill&) { remove_last(s, "go-to-step"); },
       {"procedure: complete"}},
      {"ventriculostomy",
       "tremor of 0.03 mm",
       [](Script&, workbench::Skill& skill) { skill.tremor = 0.03; },
       {"log dimensionless jerk"}},
      {"craniotomy",
       "outline 6 mm aside",
       [](Script& s, workbench::Skill&) {
         for (ScriptCommand& command : s.commands)
           if (command.name == "add-anchor") move_position(command.words, -6);
       },
       {"distance from plan", "margin", "exposed"}},
      {"craniotomy",
       "not completed",
       [](Script& s, workbench::Skill&) { remove_last(s, "go-to-step"); },
       {"procedure: complete"}},
      {"craniotomy",
       "tremor of 0.3 mm",
       [](Script&, workbench::Skill& skill) { skill.tremor = 0.3; },
       {"log dimensionless jerk"}},
      {"laminectomy-screws",
       "probe 5 mm aside",
       [](Script& s, workbench::Skill&) { move_line(s.hands[1], 5, 5, 1); },
       {"breach", "beyond bone", "canal gained", "entry to plan", "target to plan", "in front"}},
      {"laminectomy-screws",
       "screw 10 mm too long",
       [](Script& s, workbench::Skill&) {
         for (ScriptCommand& command : s.commands) replace(command.words, "length=45", "length=55");
       },
       {"in front", "length to track", "target to plan"}},
      {"laminectomy-screws",
       "burr 20 mm too deep",
       [](Script& s, workbench::Skill&) {
         for (auto& point : s.hands[0].points)
           if (point[4] != 0) point[2] -= 20;
       },
       {": torn", "deepest plunge", "facet", "pars", "canal"}},
      {"laminectomy-screws",
       "not completed",
       [](Script& s, workbench::Skill&) { remove_last(s, "go-to-step"); },
       {"procedure: complete"}},
      {"laminectomy-screws",
       "tremor of 0.3 mm",
       [](Script&, workbench::Skill& skill) { skill.tremor = 0.3; },
       {"log dimensionless jerk"}},
  };
  return all;
}

bool is_own(const PlantedError& error, const std::string& finding) {
  return std::any_of(error.own.begin(), error.own.end(),
                     [&](const std::string& end) { return finding.find(end) != std::string::npos; });
}

struct FaultsArguments {
  std::vector<std::string> scripts;
  std::string output;
};

/// Plays a script without and with each of its errors; adds a row per error.
Status plant_all(const std::string& path, Json& rows, std::string& csv) {
  auto read = data_tools::read_script(path);
  if (!read) return read.error();
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const Script& script = read.value();
  workbench::Skill exact;
  exact.name = "exact";
  const auto right = play_and_score(script, folder, {exact, 1});
  if (!right) return right.error();
  for (const PlantedError& error : planted_errors()) {
    if (script.procedure != error.procedure) continue;
    if (is_interrupted()) return interrupted("the comparison");
    notice(std::string(error.procedure) + ": " + error.name);
    Script wrong = script;
    workbench::Skill skill = exact;
    error.plant(wrong, skill);
    const auto played = play_and_score(wrong, folder, {skill, 1});
    if (!played) return played.error();
    const std::map<std::string, double> before = points_of(right.value().score),
                                        after = points_of(played.value().score);
    Json lost = Json::object();
    double own = 0, others = 0;
    for (const auto& [finding, points] : before) {
      const auto found = after.find(finding);
      const double loss = points - (found == after.end() ? 0 : found->second);
      if (std::abs(loss) < k_least_loss) continue;
      lost[finding] = loss;
      (is_own(error, finding) ? own : others) += std::abs(loss);
      csv += format_text("%s,\"%s\",\"%s\",%.3f,%s\n", error.procedure, error.name, finding.c_str(), loss,
                         is_own(error, finding) ? "own" : "other");
    }
    std::string text;
    for (const auto& [finding, loss] : lost.items())
      text += (text.empty() ? "" : ", ") + finding + format_text(" %.1f", loss.get<double>());
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
  for (const std::string& script : arguments.scripts) outputs.add_input(script);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::table);
  if (Status error = outputs.check()) return *error;
  Json rows = Json::array();
  std::string csv = "procedure,error,finding,points_lost,kind\n";
  for (const std::string& script : arguments.scripts)
    if (Status error = plant_all(script, rows, csv)) return *error;
  outputs.write(arguments.output, [&] { return data_tools::write_file_atomically(arguments.output, csv); });
  Outcome outcome("bench.faults");
  outcome.json["rows"] = rows;
  bool is_met = true;
  for (const Json& row : rows) is_met = is_met && row["own"] > 0 && row["others"] == 0;
  outcome.json["is_met"] = is_met;
  if (!is_met) outcome.exit_code = exit_check_failed;
  outcome.print_table(rows,
                      "procedure = {procedure} | planted error = {error} | points lost by its findings = "
                      "{own:.1f} | by others = {others:.1f} | findings = {lost_text}");
  return finished(outputs, std::move(outcome));
}

Run build(Options& options) {
  auto a = std::make_shared<FaultsArguments>();
  options.add("SCRIPT", a->scripts, "Scripts that perform a shipped procedure").required();
  options.add("-o,--output", a->output, "CSV file with a line for each finding that lost points").type("CSV");
  return run_with(a, run_faults);
}

}  // namespace

const Command k_faults{"faults", "Plant errors into operations, and report which findings lose points",
                       "  trephine-bench faults docs/examples/procedure-ventriculostomy.toml -o faults.csv",
                       build};

}  // namespace trephine::bench
