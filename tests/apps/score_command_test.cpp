// score: findings of recorded operations equal the results of the commands that judge these operations, and
// have the same bytes each time.
#include <algorithm>
#include <cmath>

#include "apps/cli/report.h"
#include "apps/cli/score_rows.h"
#include "apps/workbench/findings.h"
#include "tests/apps/command_fixture.h"
#include "tests/data-tools/file_helpers.h"
#include "tests/sim/session_fixture.h"
#include "tests/whole.h"

namespace trephine::command_tests {
namespace {

/// Returns a finding by its name; null if it is missing.
Json find(const Json& score, const std::string& name) {
  for (const Json& finding : score["findings"])
    if (finding["name"] == name) return finding;
  ADD_FAILURE() << name << "\n" << score.dump(1);
  return {};
}
double value(const Json& score, const std::string& name) {
  const Json finding = find(score, name);
  return finding.is_object() && finding["value"].is_number() ? finding["value"].get<double>() : std::nan("");
}

TEST_F(Command, AScoreEqualsTheJudgementsOfScrews) {
  write("s.toml", read(TREPHINE_SOURCE_DIR "/docs/examples/pedicle-screw.toml"));
  ASSERT_EQ(run("run s.toml --record s.session").exit_code, 0);
  const ProcessResult first = run("score s.session --json --csv a.csv");
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const Json score = Json::parse(first.out), screws = json("screw s.session --vertebra L4")["screws"];
  EXPECT_EQ(score["schema"], "trephine.score/1");
  ASSERT_EQ(screws.size(), 2u);
  for (const Json& screw : screws) {
    const std::string name = "L4 " + screw["side"].get<std::string>();
    EXPECT_DOUBLE_EQ(value(score, name + ": breach"), screw["breach_mm"]);
    EXPECT_DOUBLE_EQ(value(score, name + ": body breach"), screw["body_breach_mm"]);
    EXPECT_EQ(value(score, name + ": grade"), screw["grade"].get<std::string>()[0] - 'A');
    EXPECT_DOUBLE_EQ(value(score, name + ": entry to plan"), screw["plan"]["entry_error_mm"]);
    EXPECT_DOUBLE_EQ(value(score, name + ": tip to plan"), screw["plan"]["target_error_mm"]);
  }
  // The left screw follows the plan, and the right screw is too far medial.
  EXPECT_EQ(find(score, "L4 left: breach")["verdict"], "good");
  EXPECT_EQ(find(score, "L4 right: breach")["verdict"], "bad");
  EXPECT_EQ(find(score, "L4 right: breach")["points"], 0);
  EXPECT_GT(score["points"], 0);
  EXPECT_LT(score["points"], score["possible"]);
  double points = 0, possible = 0;
  for (const Json& finding : score["findings"]) {
    points += finding["points"].get<double>();
    const std::string verdict = finding["verdict"];
    if (verdict != "not judged" && verdict != "reported") possible += finding["weight"].get<double>();
  }
  EXPECT_DOUBLE_EQ(points, score["points"]);
  EXPECT_DOUBLE_EQ(possible, score["possible"]);
  EXPECT_GT(value(score, "motion: path"), 50);
  EXPECT_EQ(score["motion"].size(), 2u);
  EXPECT_EQ(score["is_complete"], true);
  EXPECT_EQ(score["is_same"], true);
  const std::string session = read(file("s.session"));
  write("cut.session", session.substr(0, session.size() / 2));
  EXPECT_EQ(json("score cut.session --until 0.1")["is_complete"], false);
  for (const Json& finding : score["findings"])
    EXPECT_EQ(finding["name"].get<std::string>().find("pars"), std::string::npos)
        << "bone that was removed for screws is not judged as a laminectomy";
  EXPECT_GT(read(file("a.csv")).size(), 500u);

  // The score of a folder has the same findings to the byte, and does not name the file. At 12.15 s, before
  // the second screw was placed, one screw is scored.
  fs::create_directory(folder_ / "course");
  fs::rename(folder_ / "s.session", folder_ / "course" / "Jane Doe.session");
  const ProcessResult folder = run("score course --json --csv course.csv");
  ASSERT_EQ(folder.exit_code, 0) << folder.err;
  const Json course = Json::parse(folder.out);
  ASSERT_EQ(course["sessions"].size(), 1u);
  EXPECT_EQ(course["sessions"][0]["findings"].dump(), score["findings"].dump());
  EXPECT_EQ(course["sessions"][0]["motion"].dump(), score["motion"].dump());
  const std::string csv = read(file("course.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2);
  EXPECT_NE(csv.find("L4 left: breach"), std::string::npos);
  for (const std::string& text : {folder.out, folder.err, csv})
    EXPECT_EQ(text.find("Jane"), std::string::npos) << text;
  const Json earlier = json("score 'course/Jane Doe.session' --until 12.15");
  const auto breaches = std::count_if(
      earlier["findings"].begin(), earlier["findings"].end(),
      [](const Json& finding) { return finding["name"].get<std::string>().ends_with(": breach"); });
  EXPECT_EQ(breaches, 1);
  EXPECT_NEAR(value(earlier, "time"), 12.15, 0.01);
  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"'course/Jane Doe.session' --until 500", "does not contain this time"},
           {"course --until 1", "cannot be applied to a folder"},
           {".state-of-nothing", ""},
           {"'course/Jane Doe.session' --csv a.txt", ".csv"}}) {
    const ProcessResult bad = run("score " + arguments);
    EXPECT_EQ(bad.exit_code, 2) << arguments << bad.out;
    EXPECT_NE(bad.err.find(words), std::string::npos) << arguments << "\n" << bad.err;
  }
}

/// The complete run of tests plants all errors in all procedures. Other runs plant one error in the fastest
/// procedure.
TEST_F(Command, PlantedErrorsChangeOnlyTheirFindings) {
  std::string scripts;
  for (const char* name : {"laminectomy-screws", "ventriculostomy", "craniotomy"})
    if (runs_all_cases() || scripts.empty())
      scripts += std::string(" " TREPHINE_SOURCE_DIR "/docs/examples/procedure-") + name + ".toml";
  const Json faults = json("bench faults" + scripts + (runs_all_cases() ? "" : " --only 'too long'"));
  EXPECT_EQ(faults["rows"].size(), runs_all_cases() ? 15u : 1u);
  for (const Json& row : faults["rows"]) {
    EXPECT_GT(row["own"], 0) << row.dump();
    EXPECT_EQ(row["others"], 0) << row.dump();
  }
}

TEST_F(Command, AFolderWithoutSessionsIsRefused) {
  fs::create_directory(folder_ / "empty");
  const ProcessResult bad = run("score empty");
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_NE(bad.err.find("no sessions"), std::string::npos) << bad.err;
}

// The following tests use the library without the command.

/// Records a drilling stroke on a small plate, and returns the motion of the hand.
workbench::HandMotion record_stroke(const std::string& path, double depth) {
  sim::Bench bench;
  sim::WriterOptions embedding;
  embedding.is_embedding = true;
  workbench::MotionStats motion(1, 1e-3);
  auto writer = bench.writer(path, 1000, embedding);
  sim::Lockstep run(
      sim::Engine(bench.scene, bench.method, drilling::burr(bench.burr), 1e-3, sim::drilling_catalogue()),
      haptics::ForceOptions{}, 1000, writer.get());
  for (int i = 0; i < 900; ++i) {
    haptics::Pose pose;
    pose.position_world = {0.01 * i, 0, 8 - depth * std::min(1.0, i / 600.0)};
    pose.press(i > 200 && i < 700);
    motion.add(run.step(pose), sim::Forbidden::k_reach);
  }
  run.apply({sim::Undo{}, 0});
  EXPECT_FALSE(writer->finish(run.engine()).has_value());
  return motion.hand(0);
}

TEST(SessionScore, AReplayGivesTheMotionOfTheRecording) {
  const sim::Folder folder;
  const std::string path = folder.file("a.session");
  const workbench::HandMotion recorded = record_stroke(path, 8);
  auto session = workbench::open_session(path, {});
  ASSERT_TRUE(session) << session.error().message();
  const auto score = workbench::score_session(*session.value());
  ASSERT_TRUE(score) << score.error().message();
  ASSERT_EQ(score.value().motion.size(), 1u);
  const workbench::HandMotion& motion = score.value().motion[0];
  EXPECT_EQ(motion.path, recorded.path);
  EXPECT_EQ(motion.jerk, recorded.jerk);
  EXPECT_EQ(motion.log_jerk, recorded.log_jerk);
  EXPECT_EQ(motion.peak_force, recorded.peak_force);
  EXPECT_GT(motion.peak_force, 0) << "the burr cuts";
  EXPECT_EQ(motion.strokes, 1);
  EXPECT_NEAR(motion.working_seconds, 0.499, 1e-9);
  const auto& findings = score.value().score.findings;
  const auto undos = std::find_if(findings.begin(), findings.end(),
                                  [](const sim::Finding& one) { return one.name == "undos"; });
  ASSERT_NE(undos, findings.end());
  EXPECT_EQ(undos->value, 1);
  // The session is scored again after its replay is at the end, and then only up to 0.3 s.
  const auto again = workbench::score_session(*session.value());
  ASSERT_TRUE(again);
  EXPECT_EQ(cli::json_of_score(again.value(), 1e-3).dump(), cli::json_of_score(score.value(), 1e-3).dump());
  const auto half = workbench::score_session(*session.value(), 0.3);
  ASSERT_TRUE(half);
  EXPECT_NEAR(half.value().seconds, 0.3, 1e-9);
  EXPECT_NEAR(half.value().motion[0].seconds, 0.3, 1e-9);
  EXPECT_LT(half.value().motion[0].path, motion.path);
  EXPECT_FALSE(workbench::score_session(*session.value(), 2.0));
  // A listener stops the scoring.
  workbench::Listener stop;
  stop.progress = [](const char*) { return [](double) { return false; }; };
  const auto stopped = workbench::score_session(*session.value(), {}, stop);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, ErrorKind::interrupted);
}

TEST(SessionScore, StructuresAreJudgedByTheirTears) {
  sim::OperationState state;
  state.dt = 1e-3, state.next_tick = 2000;
  const auto ball = scenes::sampled({-3, -3, -3}, {3, 3, 3}, glm::dvec3(1),
                                    [](const glm::dvec3& p) { return glm::length(p) < 2 ? 800.0 : 0.0; });
  const auto scan = std::make_shared<const volume::Volume>(volume::copy_of(ball).value());
  std::vector<std::shared_ptr<const sim::Forbidden>> forbidden;
  for (const char* name : {"dura", "root"})
    forbidden.push_back(sim::Forbidden::build(scan, volume::Shape{name, 400}).value());
  // Two hands: the first is near the root; the second was in the dura and tore the dura.
  state.watches.resize(4);
  state.watches[1].nearest = 4;
  state.watches[2].nearest = -1, state.watches[2].entries = 3, state.watches[2].ticks_inside = 250;
  state.chronicle.add({700, 1, {1, 2, 3}, sim::StructureTorn{"dura", 1}});
  state.chronicle.undos = 2;
  const auto all = workbench::operation_findings(state, forbidden, nullptr);
  const auto find = [&](const std::string& name) {
    for (const sim::Finding& one : all)
      if (one.name == name) return one;
    ADD_FAILURE() << name;
    return sim::Finding{.name = ""};
  };
  EXPECT_EQ(find("dura: torn").value, 1);
  EXPECT_EQ(find("dura: torn").tick, std::uint64_t{700});
  EXPECT_EQ(find("dura: nearest distance").value, -1);
  EXPECT_EQ(find("dura: entries").value, 3);
  EXPECT_EQ(find("dura: time inside").value, 0.25);
  EXPECT_EQ(find("root: torn").value, 0);
  EXPECT_EQ(find("root: nearest distance").value, 4);
  EXPECT_EQ(find("undos").value, 2);
  EXPECT_EQ(find("time").value, 2);
  EXPECT_EQ(sim::score(all, {}).points, 4) << "all points for the root, none for the dura";
}

TEST(SessionScore, HostileNamesStayText) {
  workbench::SessionScore score;
  const std::string markup = "<script>\"x\",\n{points}\x1b[2J", formula = "=1+1|cmd";
  score.score = sim::score({{.name = markup, .value = 3, .reason = markup}, {.name = formula}},
                           {{"unknown \xff", 0, 1, 2}});
  const cli::Json rows = cli::json_of_score(score, 1e-3);
  const Json read = Json::parse(cli::text_of_json(rows));
  ASSERT_EQ(read["findings"].size(), 3u);
  EXPECT_EQ(read["findings"][0]["name"], markup);
  EXPECT_EQ(read["findings"][0]["reason"], markup);
  EXPECT_EQ(read["findings"][1]["name"], formula);
  EXPECT_TRUE(read["findings"][1]["value"].is_null());
  EXPECT_EQ(read["not_judged"], 2);
  cli::Rows text;
  cli::print_score(rows, text);
  EXPECT_EQ(text.text.find('\x1b'), std::string::npos);
  EXPECT_EQ(std::count(text.text.begin(), text.text.end(), '\n'), 4 + 1 + 2);
  EXPECT_NE(text.text.find("{points}"), std::string::npos) << "a name is no format";
  EXPECT_EQ(cli::csv_cell(markup), "\"<script>\"\"x\"\",\n{points}\x1b[2J\"");
  EXPECT_EQ(cli::csv_cell(formula), "'=1+1|cmd");
  EXPECT_EQ(cli::csv_cell(-1.5), "-1.5");
  // The table of a folder has the columns of the findings of all sessions.
  const cli::Json sessions{{{"session", 1}, {"points", 2}, {"findings", {{{"name", "a"}, {"value", 4}}}}},
                           {{"session", 2}, {"error", "damaged"}},
                           {{"session", 3}, {"findings", {{{"name", "b"}, {"value", nullptr}}}}}};
  EXPECT_EQ(cli::csv_of_sessions(sessions),
            "session,seconds,points,possible,not_judged,is_complete,is_same,error,a,b\n"
            "1,,2,,,,,,4,\n2,,,,,,,damaged,,\n3,,,,,,,,,\n");
}

}  // namespace
}  // namespace trephine::command_tests
