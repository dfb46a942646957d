// Scripts that find their positions on a scan, follow its surface, have hands that yield to forces, run live
// and take pictures.
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

/// A hand that comes down on the left of an object, slides 10 mm and lifts.
std::string slide(const std::string& scan, const std::string& of_hand, const std::string& more) {
  return "schema = 1\nscan = \"" + scan + R"("
rate = 500
[[places]]
name = "left"
from = [[1, 0, 0], [0, 0, 1]]
[[hands]]
place = "left"
)" + of_hand +
         R"(
points = [[0, 0, 0, 20, 0], [0.3, 0, 0, -1, 0], [0.6, 0, 0, -1, 0], [1.2, 10, 0, -1, 0], [1.5, 10, 0, -1, 0], [2, 10, 0, 20, 0]]
)" + more;
}

std::string expect(const std::string& what, double at, double least, double most) {
  return "[[expect]]\nwhat = \"" + what + "\"\nat = " + std::to_string(at) +
         "\nleast = " + std::to_string(least) + "\nmost = " + std::to_string(most) + "\n";
}

TEST_F(Command, AScriptsPlaceIsOnTheSurfaceOfAnyScan) {
  // A ball with a radius of 40 mm around the origin, on cubic voxels and on thick slices.
  ASSERT_EQ(run("phantom sphere --size 64 --spacing 1.5 --psf 1 --set radius=40 -o cubes.mha").exit_code, 0);
  ASSERT_EQ(
      run("phantom sphere --size 96,96,24 --spacing 1,1,4 --psf 1 --set radius=40 -o slices.mha").exit_code,
      0);
  for (const std::string scan : {"cubes.mha", "slices.mha"}) {
    // Viewed from the left of the ball with z up, the slide is to the back (y), so the expected x, y and z on
    // the ball are known.
    const double x = std::sqrt(1600.0 - 100);
    write("a.toml", slide(scan, "",
                          expect("contact", 0.5, 1, 1) + expect("proxy_x", 0.5, 39.7, 40.2) +
                              expect("proxy_y", 0.5, -0.7, 0.7) + expect("contact", 1.4, 1, 1) +
                              expect("proxy_x", 1.4, x - 0.7, x + 0.7) + expect("proxy_y", 1.4, 9.3, 10.7) +
                              expect("proxy_z", 1.4, -1.5, 1.5) + expect("thickness_mm left", 0, 0, 0) +
                              expect("open left", 2, 0, 0)));
    const Json report = json("run a.toml");
    EXPECT_EQ(report["is_met"], true) << scan << report["checks"].dump(1);
  }
  // The script is valid for any direction `up`, also along the ray to the place. A picture straight from
  // above is not empty.
  for (const char* up : {"[1, 0, 0]", "[1, 1, 1]", "[0, 0, -3]"}) {
    std::string text = slide("cubes.mha", "", "[[pictures]]\nfile = \"p.png\"\nfrom = [0, 0, 1]\n");
    text.insert(text.find("name = "), std::string("up = ").append(up).append("\n"));
    if (std::string(up) == "[1, 1, 1]") text.replace(text.find("[[1, 0, 0]"), 10, "[[1, 1, 1]");
    write("up.toml", text);
    EXPECT_EQ(run("run up.toml --pictures shots").exit_code, 0) << up;
    EXPECT_GT(fs::file_size(folder_ / "shots" / "p.png"), 20000u) << up;
  }
  // Walls that are thinner than `thickness` are skipped. If all walls are thinner, the script is refused, as
  // below for the shell.
  write("thin.toml",
        "schema = 1\nscan = \"cubes.mha\"\n[[places]]\nname = \"left\"\nthickness = 5\n"
        "from = [[1, 0, 0]]\n[[hands]]\nplace = \"left\"\npoints = [[0, 0, 0, 9]]\n");
  EXPECT_EQ(run("run thin.toml").exit_code, 0);  // a ball is solid: thicker than any limit
  // The shell has its known thickness. It is open at the place after it was drilled through.
  ASSERT_EQ(run("phantom shell --size 72 -o shell.mha").exit_code, 0);
  constexpr double thickness = 7.2;  // 0.06 of its box of 120 mm
  write("b.toml",
        "schema = 1\nscan = \"shell.mha\"\n[[places]]\nname = \"left\"\nfrom = [[1, 0, 0]]\n"
        "[[hands]]\nplace = \"left\"\ninstrument = \"burr\"\n"
        "parameters = \"diameter=5 removal_rate=500\"\n"
        "points = [[0, 0, 0, 5, 1], [3, 0, 0, -3, 1, 1], [4, 0, 0, -3, 1, 1]]\n" +
            expect("open left", 0.1, 0, 0) + expect("open left", 4, 1, 1) +
            expect("thickness_mm left", 0, thickness - 1, thickness + 1));
  EXPECT_EQ(json("run b.toml")["is_met"], true) << run("run b.toml").out;
  write("thick.toml",
        "schema = 1\nscan = \"shell.mha\"\n[[places]]\nname = \"left\"\nthickness = 12\n"
        "from = [[1, 0, 0]]\n[[hands]]\nplace = \"left\"\npoints = [[0, 0, 0, 9]]\n");
  EXPECT_NE(run("run thick.toml").err.find("with the required thickness"), std::string::npos);
}

TEST_F(Command, AScriptWorksAlongATrajectory) {
  // The hand begins 10 mm outside the entry of a screw and moves 3 mm to the side.
  write("t.toml",
        "schema = 1\nscan = \"spine\"\nrate = 250\n[[places]]\nname = \"screw\"\n"
        "trajectory = \"L4 left pedicle\"\n[[hands]]\nplace = \"screw\"\nshaft = [0, 0, 1]\n"
        "points = [[0, 0, 0, 10], [0.5, 0, 0, 10], [1, 3, 0, 10]]\n" +
            expect("thickness_mm screw", 0, 3, 60));
  const Json run_report = json("run t.toml --record t.session");
  EXPECT_EQ(run_report["is_met"], true) << run_report.dump(1);
  ASSERT_EQ(run("phantom spine --case c").exit_code, 0);
  const Json info = json("info c");
  glm::dvec3 entry(0), target(0);
  for (const Json& t : info["trajectories"])
    if (t["name"] == "L4 left pedicle")
      for (int a = 0; a < 3; ++a)
        entry[a] = t["entry"][static_cast<std::size_t>(a)],
        target[a] = t["target"][static_cast<std::size_t>(a)];
  ASSERT_EQ(run("replay t.session --table t.csv").exit_code, 0);
  std::istringstream rows(read(file("t.csv")));
  std::string row;
  std::getline(rows, row);
  std::getline(rows, row);
  double t = 0;
  glm::dvec3 hip(0);
  ASSERT_EQ(std::sscanf(row.c_str(), "%lf,%lf,%lf,%lf", &t, &hip.x, &hip.y, &hip.z), 4) << row;
  EXPECT_LT(glm::length(hip - (entry + 10.0 * glm::normalize(entry - target))), 1e-3);
  write("no.toml",
        "schema = 1\nscan = \"spine\"\n[[places]]\nname = \"screw\"\ntrajectory = \"L9\"\n[[hands]]\n"
        "place = \"screw\"\npoints = [[0, 0, 0, 10]]\n");
  const ProcessResult unknown = run("run no.toml");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("L4 left pedicle"), std::string::npos) << unknown.err;
  write("both.toml",
        "schema = 1\nscan = \"spine\"\n[[places]]\nname = \"screw\"\ntrajectory = \"L9\"\n"
        "from = [[0, 0, 1]]\n[[hands]]\nplace = \"screw\"\npoints = [[0, 0, 0, 10]]\n");
  EXPECT_EQ(run("run both.toml").exit_code, 2);
}

/// A trajectory of 40 mm passes 7.2 mm of a shell; its length is not the thickness of the shell.
TEST_F(Command, AScriptMeasuresTheSolidAlongATrajectory) {
  ASSERT_EQ(run("phantom shell --size 72 -o shell.mha").exit_code, 0);
  ASSERT_EQ(run("import shell.mha -o c --iso 0").exit_code, 0);
  write("c/case.toml", read(file("c/case.toml")) +
                           "[[trajectories]]\nname = \"through\"\nentry = [58, 0, 0]\ntarget = [18, 0, 0]\n"
                           "[[trajectories]]\nname = \"in air\"\nentry = [20, 0, 0]\ntarget = [0, 0, 0]\n");
  std::string places;
  for (const char* name : {"through", "in air"})
    places += std::string("[[places]]\nname = \"") + name + "\"\ntrajectory = \"" + name + "\"\n";
  write("t.toml", "schema = 1\nscan = \"c\"\nrate = 250\n" + places +
                      "[[hands]]\nplace = \"through\"\npoints = [[0, 0, 0, 30], [0.1, 0, 0, 30]]\n" +
                      expect("thickness_mm through", 0, 6.2, 8.2) + expect("thickness_mm in air", 0, 0, 0));
  const Json outcome = json("run t.toml");
  EXPECT_EQ(outcome["is_met"], true) << outcome.dump(1);
}

/// A place on a body moves with the body, in commands and pictures.
TEST_F(Command, AScriptsPlaceOnABodyMovesWithIt) {
  const std::string cut =
      "schema = 1\nscan = \"head\"\nplan = true\nrate = 250\n[[places]]\nname = \"flap\"\nbody = 1\n"
      "[[hands]]\npoints = [[0, 0, 0, 200], [1, 0, 0, 200]]\n"
      "[[do]]\nat = 0.1\ncommand = \"measure\"\nwith = \"kind=ruler at={flap};0,0,0\"\n"
      "refused = \"does not exist\"\n"
      "[[do]]\nat = 0.2\ncommand = \"cut-flap\"\nwith = \"outline=craniotomy\"\n";
  const std::string moved =
      "[[do]]\nat = 0.4\ncommand = \"place-body\"\nwith = \"body=1 position=30,0,0 rotation=0,0,0,1\"\n"
      "[[do]]\nat = 0.5\ncommand = \"measure\"\nwith = \"kind=ruler at={flap};{flap 0,0,12}\"\n" +
      expect("measured length", 0.6, 11.999, 12.001) +
      // A half turn about z: the body's x axis is opposite to that of the world.
      "[[do]]\nat = 0.7\ncommand = \"measure\"\nwith = \"kind=ruler at={flap};{flap 10,0,0}\"\n" +
      "[[pictures]]\nfile = \"flap.png\"\nplace = \"flap\"\ndistance = 150\n";
  write("f.toml", cut + moved);
  for (const std::string how : {"", " --live --record live.session"}) {
    const Json outcome = json("run f.toml --pictures . " + how);
    EXPECT_EQ(outcome["is_met"], true) << outcome["checks"].dump(1);
    EXPECT_TRUE(fs::exists(file("flap.png")));
    fs::remove(file("flap.png"));
  }
  write("none.toml", cut +
                         "[[do]]\nat = 0.3\ncommand = \"undo\"\n[[pictures]]\nfile = \"flap.png\"\n"
                         "place = \"flap\"\ndistance = 150\n");
  const ProcessResult none = run("run none.toml --pictures .");
  EXPECT_EQ(none.exit_code, 1) << none.err;
  EXPECT_NE(none.out.find("does not exist at this time"), std::string::npos) << none.out << none.err;
  write("hand.toml",
        "schema = 1\nscan = \"head\"\n[[places]]\nname = \"flap\"\nbody = 1\n[[hands]]\n"
        "place = \"flap\"\npoints = [[0, 0, 0, 10]]\n");
  EXPECT_NE(run("run hand.toml").err.find("cannot be relative to a body"), std::string::npos);
}

TEST_F(Command, AScriptsHandYieldsLiveAndWithoutThreadsAlike) {
  ASSERT_EQ(run("phantom sphere --size 64 --spacing 1.5 --psf 1 --set radius=40 -o s.mha").exit_code, 0);
  // A hand with a stiffness of 0.3 N/mm that is aimed 1 mm into bone presses with less than 0.3 N. A hand
  // without a stiffness follows its path exactly and is 1 mm deep.
  const std::string tail = R"([[do]]
at = 1.0
command = "note"
with = 'text="half way"'
[[do]]
at = 1.1
command = "hold-body"
with = "body=3"
refused = true
)";
  write("soft.toml", slide("s.mha", "stiffness = 0.3",
                           expect("force_n", 0.55, 0.05, 0.3) + expect("contact", 1.4, 1, 1) + tail));
  write("stiff.toml", slide("s.mha", "", expect("force_n", 0.55, 0.4, 8) + tail));
  for (const std::string how : {"", " --live"}) {
    const Json soft =
        json("run soft.toml --record " + std::string(how.empty() ? "" : "live-") + "soft.session" + how);
    EXPECT_EQ(soft["is_met"], true) << how << soft["checks"].dump(1);
    EXPECT_EQ(soft["checks"].size(), 3u);
    EXPECT_EQ(soft.contains("servo"), !how.empty());
  }
  EXPECT_EQ(json("run stiff.toml")["is_met"], true);
  for (const char* session : {"soft", "live-soft"})
    EXPECT_EQ(json(std::string("replay ") + session + ".session --scan s.mha --verify")["is_same"], true);
  // Planted faults: an unmet expectation gives exit code 1, also live. An expected refusal that does not
  // occur gives exit code 1, too.
  write("wrong.toml", slide("s.mha", "stiffness = 0.3", expect("force_n", 0.55, 2, 3)));
  EXPECT_EQ(run("run wrong.toml --live").exit_code, 1);
  write("done.toml",
        slide("s.mha", "", "[[do]]\nat = 1\ncommand = \"note\"\nwith = 'text=\"x\"'\nrefused = true\n"));
  EXPECT_EQ(run("run done.toml").exit_code, 1);
  EXPECT_TRUE(fs::is_empty(folder_ / ".state" / "trephine" / "sessions")) << "a temporary session stayed";
}

/// A job is finished before the next command is executed, also live. Expectations for the time of a command
/// are checked after the command.
TEST_F(Command, AScriptDoesTheSameLiveInTheSameOrder) {
  ASSERT_EQ(run("phantom plate --size 64 --spacing 0.6 --psf 1 --set thickness=4 -o plate.mha").exit_code, 0);
  std::ostringstream circle;
  for (int level = 0; level < 5; ++level)
    for (int i = 0; i <= 24; ++i) {
      const double a = 2 * 3.14159265358979 * i / 24, t = 0.2 + 0.5 * level + 0.02 * i;
      circle << "[" << t << ", " << 6 * std::cos(a) << ", " << 6 * std::sin(a) << ", " << 1.0 - 1.5 * level
             << ", 1],\n";
    }
  write("disk.toml",
        "schema = 1\nscan = \"plate.mha\"\nrate = 500\n[[places]]\nname = \"top\"\nfrom = [[0, 0, 1]]\n"
        "[[hands]]\nplace = \"top\"\ninstrument = \"burr\"\n"
        "parameters = \"diameter=3 kinematic=yes\"\npoints = [[0, 6, 0, 9, 0],\n" +
            circle.str() + "[2.8, 6, 0, -5, 0], [3, 0, 0, 9, 0], [4, 0, 0, 9, 0]]\n" +
            "[[do]]\nat = 3.1\ncommand = \"free-pieces\"\n"
            "[[do]]\nat = 3.1\ncommand = \"hold-body\"\nwith = \"body=1\"\n" +
            expect("bodies", 3.1, 1, 1) +
            "[[do]]\nat = 3.3\ncommand = \"release-body\"\n"
            "[[do]]\nat = 3.4\ncommand = \"undo\"\n[[do]]\nat = 3.5\ncommand = \"undo\"\n" +
            expect("bodies", 3.5, 0, 0) + expect("removed_mm3", 3.5, 20, 1000) +
            "[[do]]\nat = 3.6\ncommand = \"undo\"\n" + expect("removed_mm3", 3.6, 0, 0));
  for (const char* how : {"", " --live"}) {
    const Json report = json(std::string("run disk.toml") + how);
    EXPECT_EQ(report["is_met"], true) << how << report["checks"].dump(1);
  }
}

TEST_F(Command, AScriptTakesItsPictures) {
  ASSERT_EQ(run("phantom sphere --size 48 --spacing 2 --psf 1 --set radius=40 -o s.mha").exit_code, 0);
  write("a.toml", slide("s.mha", "", R"([[pictures]]
at = 1
file = "slide.png"
caption = "{force_n:2} N at {proxy_x:1}"
[[pictures]]
file = "end.png"
place = "left"
distance = 100
tool = false
)"));
  const Json report = json("run a.toml --pictures shots");
  EXPECT_EQ(report["pictures"], (Json{"slide.png", "end.png"}));
  for (const char* name : {"slide.png", "end.png"})
    EXPECT_GT(fs::file_size(folder_ / "shots" / name), 10000u) << name;
  EXPECT_EQ(json("run a.toml").contains("pictures"), false);
}

TEST_F(Command, ErrorsInPlacesAndPicturesAreReportedWithTheirLine) {
  ASSERT_EQ(run("phantom sphere --size 48 --spacing 2 -o s.mha").exit_code, 0);
  const std::pair<std::string, std::string> wrong[] = {
      {"[[pictures]]\nfile = \"a/b.png\"\n", "folder"},
      {"[[pictures]]\nfile = \"a.jpg\"\n", ".png"},
      {"[[pictures]]\nfile = \"a.png\"\nplace = \"left\"\n", "distance"},
      {"[[pictures]]\nfile = \"a.png\"\nplace = \"right\"\ndistance = 9\n", "left"},
      {"[[pictures]]\nfile = \"a.png\"\n[[pictures]]\nfile = \"a.png\"\n", "different names"},
      {"[[pictures]]\nfile = \"a.png\"\nfrom = [0, 0, 0]\n", "direction"},
      {"[[pictures]]\nfile = \"a.png\"\ncaption = \"{weight} kg\"\n", "removed_mm3"},
      {"[[places]]\nname = \"left\"\nfrom = [[0, 0, 1]]\n", "the same name"},
      {"[[places]]\nname = \"up\"\nfrom = []\n", "complete"},
      {"[[places]]\nname = \"up\"\nfrom = [[1, 2]]\n", "[x, y, z]"},
      {"[[expect]]\nwhat = \"open up\"\nleast = 1\n", "open left"},
      {"[[hands]]\npoints = [[0, 0, 0, 9, 0, 1]]\n", "points = "},
      {"[[hands]]\nplace = \"left\"\npath = \"p.csv\"\n", "points"},
      {"[[hands]]\nplace = \"nowhere\"\npoints = [[0, 0, 0, 9]]\n", "left"},
      {"[[places]]\nname = \"up\"\nfrom = [1, 0, 0]\n", "list of directions"},
      {"[[places]]\nname = \"up\"\nfrom = [[0, 0, 1]]\nup = [1e-200, 0, 0]\n", "direction"},
      {"[[pictures]]\nfile = \"a.png\"\ncaption = \"{force_n:x} N\"\n", "digits"},
      {"[[pictures]]\nfile = \"a.png\"\ncaption = \"{force_n N\"\n", "digits"},
      {"[[pictures]]\nfile = \"a.png\"\nhand = 1\n", "hand"},
      {"[[expect]]\nwhat = \"events nothing\"\nleast = 1\n", "events piece-freed"},
      {"[[hands]]\nplace = \"left\"\npoints = [[0, 0, 0, 9, 1, 900000]]\n", "out of range"},
      {"[[hands]]\nstiffness = 0\npoints = [[0, 0, 0, 9]]\n", "stiffness"}};
  for (const auto& [more, words] : wrong) {
    write("w.toml", slide("s.mha", "", more));
    const ProcessResult answer = run("run w.toml");
    EXPECT_EQ(answer.exit_code, 2) << more;
    EXPECT_NE(answer.err.find("line"), std::string::npos) << answer.err;
    EXPECT_NE(answer.err.find(words), std::string::npos) << more << answer.err;
  }
  // A place that no hand uses is allowed.
  write("none.toml", slide("s.mha", "", "[[places]]\nname = \"void\"\nfrom = [[0, 1, 0]]\n"));
  EXPECT_EQ(run("run none.toml").exit_code, 0);
}

}  // namespace
}  // namespace trephine::command_tests
