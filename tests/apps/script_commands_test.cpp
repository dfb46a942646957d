// Scripts and the list of modules, as users run them.
#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

/// Returns a script on a ball of bone. The first hand drills the ball from above for a while; the second hand
/// rests on the ball.
std::string script(const std::string& more) {
  return R"(schema = 1
title = "A ball"
scan = "s.mha"
rate = 500

[[hands]]
instrument = "burr"
parameters = "diameter=4 removal_rate=60"
points = [[0, 0, 0, 60, 0], [0.5, 0, 0, 46, 1], [1.5, 0, 0, 44, 1], [1.6, 0, 0, 60, 0], [2, 0, 0, 60, 0]]

[[hands]]
path = "rest.csv"
)" + more;
}

class Script : public Command {
 protected:
  Script() {
    EXPECT_EQ(run("phantom sphere --size 64 --spacing 2 --psf 1 --set radius=48 -o s.mha").exit_code, 0);
    write("rest.csv", "t,x,y,z\n0,0,30,60\n0.5,0,30,36\n2,0,30,36\n");
  }
};

TEST_F(Script, IsPlayedCheckedRecordedAndReplayed) {
  write("a.toml", script(R"(
[[expect]]
at = 0.8
hand = 1
what = "contact"
least = 1
[[expect]]
what = "removed_mm3"
least = 20
most = 200
[[expect]]
hand = 1
what = "proxy_y"
least = 29
most = 31
[[do]]
at = 1.7
command = "undo"
[[expect]]
at = 1.75
what = "removed_mm3"
most = 0
[[do]]
at = 1.8
command = "redo"
[[do]]
at = 1.9
command = "burr"
with = "diameter=1"
refused = true
[[do]]
at = 1.95
command = "free-pieces"
refused = "no part is disconnected"
[[do]]
at = 1.96
hand = 1
command = "set-effect"
with = 'effect=1 words="constant force=0,0,1"'
[[expect]]
at = 2.5
hand = 1
what = "strongest_force_n"
least = 0.9
[[expect]]
what = "strongest_force_n"
most = 8
)"));
  const Json report = json("run a.toml --record a.session -o left.mha");
  EXPECT_TRUE(report["is_met"]);
  EXPECT_EQ(report["ticks"], 1251);  // up to the last expectation
  ASSERT_EQ(report["checks"].size(), 8u);
  EXPECT_EQ(report["checks"][0]["line"], 14);
  const Json again = json("replay a.session --scan s.mha --verify");
  EXPECT_TRUE(again["is_same"]);
  EXPECT_EQ(again["content_hash"], report["content_hash"]);
  // The path of the script may contain its folder. Paths in the script are relative to that folder.
  const ProcessResult by_path = run("run ./a.toml --json");
  EXPECT_EQ(Json::parse(by_path.out)["content_hash"], report["content_hash"]);
}

TEST_F(Script, UnmetExpectationsAreReportedWithTheirLineAndExitCodeOne) {
  write("a.toml", script(R"(
[[expect]]
what = "removed_mm3"
least = 1e6
[[do]]
at = 1
command = "undo"
refused = true
[[do]]
at = 1.2
command = "switch-item"
with = "item=9 touchable=no"
)"));
  const ProcessResult r = run("run a.toml");
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_NE(r.out.find("FAILED  line 14"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("FAILED  line 17"), std::string::npos)
      << r.out;  // executed, but a refusal was expected
  EXPECT_NE(r.out.find("FAILED  line 21"), std::string::npos)
      << r.out;  // refused, but no refusal was expected
  EXPECT_NE(r.out.find("unknown item"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("3 of 3 checks FAILED"), std::string::npos) << r.out;
}

/// A refusal for an unexpected reason does not meet the expectation. A value that was never measured does not
/// meet its limits.
TEST_F(Script, RefusalsHaveTheirReasonAndValuesTheirMeasurement) {
  write("a.toml", script(R"(
[[do]]
at = 1
command = "burr"
with = "diameter=1"
refused = "smallest"
[[do]]
at = 1.2
command = "burr"
with = "diameter=1"
refused = "no such reason"
[[expect]]
what = "canal"
most = 1e6
)"));
  const ProcessResult r = run("run a.toml");
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_EQ(r.out.find("FAILED  line 14"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("FAILED  line 19"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("FAILED  line 24"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("it was not measured"), std::string::npos) << r.out;
}

TEST_F(Script, ErrorsAreReportedWithTheirLineBeforePlaying) {
  const struct {
    std::string more;
    const char* words;
  } bad[] = {
      {"[[expect]]\nwhat = \"removed\"", "line 14: an expectation is not complete"},
      {"[[expect]]\nwhat = \"removed_mm\"\nmost = 1", "line 14: unknown measurement"},
      {"[[expect]]\nwhat = \"events nothing\"\nmost = 1", "line 14: unknown measurement"},
      {"[[expect]]\nwhat = \"strokes\"\nleast = 2\nmost = 1", "swap the two values"},
      {"[[do]]\nat = 1\ncommand = \"frobnicate\"", "line 14: unknown command"},
      {"[[do]]\nat = 1\ncommand = \"fault\"", "unknown command"},
      {"[[do]]\nat = 1\ncommand = \"adopt-job\"", "unknown command"},
      {"[[do]]\nat = 1\ncommand = \"burr\"\nwith = \"diameter=99\"", "line 14: burr diameter"},
      {"[[do]]\nat = 1\ncommand = \"burr\"\nwith = \"size=2\"", "unknown field"},
      {"[[do]]\nat = -1\ncommand = \"undo\"", "line 15: the value of at is out of range"},
      {"[[do]]\nat = 1\nhand = 2\ncommand = \"undo\"", "the value of hand is out of range"},
      {"[[hands]]\npath = \"none.csv\"", "does not exist"},
      {"[[hands]]\npoints = [[0, 1, 2]]", "invalid point of a path"},
      {"[[hands]]\npoints = [[1, 0, 0, 0], [0, 0, 0, 0]]", "line 14"},
      {"[[hands]]\ninstrument = \"saw\"\npath = \"rest.csv\"", "line 14: instrument: unknown instrument"},
      {"[[hands]]\ninstrument = \"burr\"\nparameters = \"diameter=-1\"\npath = \"rest.csv\"",
       "burr diameter"},
      {"[[hands]]\nmethod = \"gost\"\npath = \"rest.csv\"", "unknown method"},
      {"[[hands]]\neffects = [\"hum\"]\npath = \"rest.csv\"", "unknown effect"},
      {"[[do]]\nat = 1\ncommand = \"set-effect\"\nwith = 'effect=1 words=viscous damping=1'",
       "unknown field"},
      {"[[do]]\nat = 1\nhand = 0.5\ncommand = \"undo\"", "hand is not a whole number"},
      {"speed = 2", "unknown key"},
      {"smallest_burr = 1", "unknown key"},
      // All mistakes are reported together. Errors that only follow from them, such as an expectation that is
      // not complete, are not reported.
      {"[[expect]]\nthat = \"changes\"\nleast = \"1\"\n[[do]]\nat = -1\ncommand = \"undo\"",
       "correct the spelling; line 16: the value of least is not a number (\"1\"); line 18: the value of at is "
       "out of range (-1)\n"},
      {"\n[[expect", "the script is not TOML"},
  };
  for (const auto& [more, words] : bad) {
    write("bad.toml", script("\n" + more));
    const ProcessResult r = run("run bad.toml -o left.mha --record bad.session");
    EXPECT_EQ(r.exit_code, 2) << more;
    EXPECT_NE(r.err.find(words), std::string::npos) << more << "\n" << r.err;
    EXPECT_FALSE(fs::exists(file("left.mha")) || fs::exists(file("bad.session"))) << more;
  }
  EXPECT_EQ(run("run nothing.toml").exit_code, 2);
  write("old.toml", "scan = \"head\"\n");
  EXPECT_NE(run("run old.toml").err.find("has no schema"), std::string::npos);
  write("new.toml", "schema = 2\nwhatever = 1\n");
  EXPECT_NE(run("run new.toml").err.find("newer trephine"), std::string::npos);
  write("a.toml", script(""));
  EXPECT_EQ(run("run a.toml -o a.toml").exit_code, 2);
  for (const char* given : {"s.mha", "rest.csv"}) {  // inputs of the script are kept
    const std::string before = read(file(given));
    EXPECT_EQ(run(std::string("run a.toml -o ") + given).exit_code, 2);
    EXPECT_EQ(read(file(given)), before);
  }
  std::string many;
  for (int i = 0; i < 3; ++i) many += "[[hands]]\npath = \"rest.csv\"\n";
  write("many.toml", script(many));
  EXPECT_NE(run("run many.toml").err.find("one to four"), std::string::npos);
  write("deep.toml", "a = " + std::string(100000, '['));
  EXPECT_NE(run("run deep.toml").err.find("not TOML"), std::string::npos);
  EXPECT_EQ(run("run a.toml --show").exit_code, 3);  // no display: refused before the script is played
  EXPECT_EQ(run("run a.toml --record nowhere/a.session").exit_code, 2);
  EXPECT_EQ(run("run a.toml --record s.mha").exit_code, 2);
}

TEST_F(Command, ModulesAreListedWithTheirTables) {
  const Json all = json("modules");
  ASSERT_EQ(all["modules"].size(), 12u);
  EXPECT_EQ(all["modules"][0]["name"], "engine");
  EXPECT_GT(all["modules"][0]["parts"].size(), 15u);
  EXPECT_EQ(all["modules"][1]["name"], "drilling");
  const Json& burr = all["modules"][1]["parts"][0];
  EXPECT_EQ(burr["kind"], "instrument");
  EXPECT_EQ(burr["fields"][0]["name"], "diameter");
  EXPECT_EQ(burr["fields"][0]["unit"], "mm");
  EXPECT_EQ(burr["fields"][0]["high"], 30);
  EXPECT_EQ(burr["fields"][0]["default"], "4");
  EXPECT_NE(run("modules drilling").out.find("diameter=4"), std::string::npos);
  EXPECT_EQ(run("modules dancing").exit_code, 2);
}

}  // namespace
}  // namespace trephine::command_tests
