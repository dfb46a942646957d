// skills: plays scripts as persons of several skills, and compares their scores.
#include <algorithm>
#include <array>

#include "apps/bench/commands/bench_commands.h"
#include "apps/bench/commands/scored_play.h"

namespace trephine::bench {

using namespace cli;

namespace {

struct SkillsArguments {
  std::vector<std::string> scripts;
  std::string output;
  std::uint64_t seeds = 20;
};

/// Result of one play.
struct Play {
  double points = 0, log_jerk = 0, path = 0, seconds = 0;
};

Result<Play> play(const data_tools::Script& script, const std::string& folder,
                  const workbench::Performance& performance) {
  const auto played = play_and_score(script, folder, performance);
  if (!played) return played.error();
  const workbench::SessionScore& found = played.value();
  return Play{found.score.points, found.total_motion.log_jerk, found.total_motion.path, found.seconds};
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

template <class Member>
std::vector<double> values_of(const std::vector<Play>& plays, Member Play::*member) {
  std::vector<double> values;
  for (const Play& one : plays) values.push_back(one.*member);
  return values;
}

/// Returns the share of pairs in which the less skilled person has more points, 0 to 1. A pair with equal
/// points counts half.
double wrong_pairs(const std::vector<Play>& lower, const std::vector<Play>& higher) {
  double wrong = 0;
  for (const Play& a : lower)
    for (const Play& b : higher) wrong += a.points > b.points ? 1 : a.points == b.points ? 0.5 : 0;
  return wrong / static_cast<double>(lower.size() * higher.size());
}

/// Plays a script with all skills; adds its rows.
Status compare_skills(std::uint64_t seeds, const data_tools::Script& script, const std::string& folder,
                      Json& rows, std::string& csv) {
  const std::string& title = script.title;
  ProgressLine progress("playing");
  std::vector<std::vector<Play>> all;
  for (const workbench::Skill& skill : workbench::skills()) {
    std::vector<Play>& plays = all.emplace_back();
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      if (!progress(static_cast<double>(seed) / static_cast<double>(seeds)))
        return Error{.what = "the comparison was interrupted", .kind = ErrorKind::interrupted};
      auto played = play(script, folder, {skill, seed});
      if (!played) return played.error();
      plays.push_back(played.value());
      csv += '"' + title + "\"," + std::string(skill.name) + ',' + std::to_string(seed) +
             format_text(",%.3f,%.4f,%.2f,%.3f\n", plays.back().points, plays.back().log_jerk,
                         plays.back().path, plays.back().seconds);
    }
    const std::vector<double> points = values_of(plays, &Play::points);
    Json row = {{"script", title},
                {"skill", skill.name},
                {"median_points", median(points)},
                {"least_points", *std::min_element(points.begin(), points.end())},
                {"most_points", *std::max_element(points.begin(), points.end())},
                {"log_jerk", median(values_of(plays, &Play::log_jerk))},
                {"seconds", median(values_of(plays, &Play::seconds))},
                {"wrong_pairs", nullptr}};
    if (all.size() > 1) row["wrong_pairs"] = wrong_pairs(all[all.size() - 2], plays);
    rows.push_back(std::move(row));
  }
  return std::nullopt;
}

Result<Outcome> run_skills(const SkillsArguments& arguments) {
  if (arguments.seeds < 1 || arguments.seeds > 1000)
    return Error{.what = "the number of seeds is out of range",
                 .where = "--seeds",
                 .found = std::to_string(arguments.seeds),
                 .expected = "1 to 1000"};
  data_tools::OutputSet outputs;
  const auto rows = run_on_scripts(
      arguments.scripts,
      [seeds = arguments.seeds](const data_tools::Script& script, const std::string& folder, Json& all,
                                std::string& csv) { return compare_skills(seeds, script, folder, all, csv); },
      "script,skill,seed,points,log_jerk,path_mm,seconds\n", arguments.output, outputs);
  if (!rows) return rows.error();
  Outcome outcome("bench.skills");
  outcome.json["seeds"] = arguments.seeds;
  outcome.json["rows"] = rows.value();
  outcome.print_table(rows.value(),
                      "script = {script} | skill = {skill} | median points = {median_points:.1f} | least = "
                      "{least_points:.1f} | most = {most_points:.1f} | log jerk = {log_jerk:.2f} | time, s = "
                      "{seconds:.0f} | pairs in wrong order = {wrong_pairs:.1%}");
  return finished(outputs, std::move(outcome));
}

Run build(Options& options) {
  auto a = std::make_shared<SkillsArguments>();
  options.add("SCRIPT", a->scripts, "Scripts of operations").required();
  options.add("--seeds", a->seeds, "Number of plays of each skill (default: 20)").type("N");
  options.add("-o,--output", a->output, "CSV file with a line for each play").type("CSV");
  return run_with(a, run_skills);
}

}  // namespace

const Command k_skills{
    "skills", "Play scripts as novice, trained and expert persons, and compare their scores",
    "  trephine-bench skills docs/examples/ventriculostomy.toml --seeds 20 -o skills.csv", build};

}  // namespace trephine::bench
