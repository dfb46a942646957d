// screw: the pedicle screws of docs/ are played by a script, judged by the command, and replayed.
#include "tests/apps/command_fixture.h"
#include "tests/data-tools/file_helpers.h"

namespace trephine::command_tests {
namespace {

TEST_F(Command, PedicleScrewsArePlayedJudgedAndReplayed) {
  write("s.toml", read(TREPHINE_SOURCE_DIR "/docs/examples/pedicle-screw.toml"));
  const Json played = json("run s.toml --record s.session");
  EXPECT_EQ(played["is_met"], true) << played.dump(1);
  const Json outcome = json("screw s.session --vertebra L4 --slices o.png");
  EXPECT_GT(fs::file_size(folder_ / "o.png"), 50000u);
  ASSERT_EQ(outcome["screws"].size(), 2u);
  const Json &planned = outcome["screws"][0], &medial = outcome["screws"][1];
  EXPECT_EQ(planned["side"], "left");
  EXPECT_EQ(planned["grade"], "A");
  EXPECT_GT(planned["bone_around_mm"], 0.3);
  EXPECT_EQ(planned["plan"]["trajectory"], "L4 left pedicle");
  EXPECT_LT(planned["plan"]["angle_error_degrees"], 0.1);
  EXPECT_EQ(medial["side"], "right");
  EXPECT_EQ(medial["wall"], "medial");
  EXPECT_NEAR(medial["breach_mm"].get<double>(), 4.9, 0.5);
  EXPECT_LT(medial["score"], planned["score"]);
  // In a section the screws fill their tracks. Only the part of the right screw in the canal is outside bone.
  const Json section = json("section s.session --trajectory \"L4 left pedicle\" --width 90");
  EXPECT_GT(section["models_outside_bone_mm2"], 15);
  EXPECT_LT(section["models_outside_bone_mm2"], 45);
  EXPECT_NE(run("timeline s.session").out.find("toward the canal"), std::string::npos);
  EXPECT_EQ(json("replay s.session --verify")["is_same"], true);
  // At 12.15 s, before the second screw was placed, there was one screw.
  EXPECT_EQ(json("screw s.session --vertebra L4 --until 12.15")["screws"].size(), 1u);
  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"", "no vertebra selected"},
           {"--canal 1,2", "X,Y,Z"},
           {"--vertebra L9", "unknown label"},
           {"--vertebra L3", "no screw passes"},
           {"--vertebra L4 --until 5", "no screws at this time"},
           {"--vertebra L4 --until 500", "does not contain this time"}}) {
    const ProcessResult bad = run("screw s.session " + arguments);
    EXPECT_EQ(bad.exit_code, 2) << arguments;
    EXPECT_NE(bad.err.find(words), std::string::npos) << arguments << "\n" << bad.err;
  }
}

/// A job that fails adds no change, so a later undo in the script would revert the change before it. The
/// script therefore reports the failure.
TEST_F(Command, AScriptReportsAJobThatFails) {
  const std::string head =
      "schema = 1\nscan = \"spine\"\nrate = 250\n[[hands]]\npoints = [[0, 0, 0, 90], [1, 0, 0, 90]]\n"
      "[[do]]\nat = 0.2\ncommand = \"place-screw\"\n"
      "with = \"diameter=6 length=35 entry=60,-50,60 target=60,-40,60\"\n";
  write("failed.toml", head);
  write("refused.toml", head + "refused = \"no bone along\"\n");
  for (const std::string how : {"", " --live --record live.session"}) {
    const ProcessResult failed = run("run failed.toml --json" + how);
    EXPECT_EQ(failed.exit_code, 1) << failed.err;
    EXPECT_NE(failed.out.find("there is no bone along the screw"), std::string::npos) << failed.out;
    fs::remove(file("live.session"));
    EXPECT_EQ(json("run refused.toml" + how)["is_met"], true) << how;
    fs::remove(file("live.session"));
  }
}

/// On slices of 3 mm, a grade near its limit is uncertain, and the judgement marks it as uncertain.
TEST_F(Command, APedicleScrewOnARealScanIsMarkedUncertain) {
  if (data_tools::real_data().empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  import_real_spine(data_tools::real_data());
  write("real/case.toml", read(file("real/case.toml")) + k_real_pedicle);
  write("r.toml",
        "schema = 1\nscan = \"./real\"\nlabel = \"vertebrae_L4\"\nrate = 250\n"
        "static_friction = 0.1\ndynamic_friction = 0.08\n"
        "[[places]]\nname = \"left\"\ntrajectory = \"L4 left pedicle\"\n"
        "[[hands]]\ninstrument = \"probe\"\nplace = \"left\"\nshaft = [0, 0, 1]\n"
        "points = [[0, 0, 0, 30, 0], [0.6, 0, 0, 6, 0], [4, 0, 0, -40, 0], [6, 0, 0, 30, 0]]\n"
        "[[expect]]\nwhat = \"events probe-out\"\nmost = 0\n"
        "[[do]]\nat = 6.1\ncommand = \"place-screw\"\nwith = \"diameter=6 length=35 seconds=1\"\n"
        "[[do]]\nat = 7.3\ncommand = \"judge-screw\"\n"
        "[[expect]]\nwhat = \"screws judged\"\nleast = 1\n");
  const Json played = json("run r.toml --record r.session");
  EXPECT_EQ(played["is_met"], true) << played.dump(1);
  const Json outcome = json("screw r.session --scan real --vertebra vertebrae_L4");
  ASSERT_EQ(outcome["screws"].size(), 1u);
  const Json& screw = outcome["screws"][0];
  EXPECT_EQ(screw["side"], "left");
  EXPECT_LT(screw["breach_mm"], 2);
  EXPECT_EQ(screw["is_uncertain"], true) << screw.dump(1);
  EXPECT_EQ(screw["plan"]["trajectory"], "L4 left pedicle");
  EXPECT_EQ(json("replay r.session --scan real --verify")["is_same"], true);
}

}  // namespace
}  // namespace trephine::command_tests
