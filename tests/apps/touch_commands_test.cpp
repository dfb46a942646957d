// trephine touch: its report on energy and on a tool that is stuck; models as tools.
#include <cmath>

#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

/// A spring that is sampled and smoothed returns more energy than it absorbs. The surplus is at most the
/// theoretical limit.
TEST_F(Command, TheForceAloneReturnsNoMoreThanSamplingAllows) {
  ASSERT_EQ(run("phantom sphere --size 48 --psf 1 -o s.mha").exit_code, 0);
  std::ostringstream path;
  path << "t,x,y,z\n";
  for (int i = 0; i < 10 * 160; ++i)
    path << 1e-3 * i << ',' << 0.3 * std::cos(i / 160) << ",0,"
         << 41 + 8 * std::abs(2 * (i % 160) / 160.0 - 1) << '\n';
  write("p.csv", path.str());
  const auto energy = [&](const std::string& options) {
    return json("touch s.mha --path p.csv -o o" + std::to_string(std::hash<std::string>{}(options)) +
                ".csv --friction 0,0 " + options)["energy_nmm"];
  };
  for (const char* options : {"", "--stiffness 2", "--rate 5000", "--alpha 0.8"}) {
    const Json e = energy(options);
    EXPECT_LE(e["returned"].get<double>(), e["returned_at_most"].get<double>()) << options;
    EXPECT_GT(e["returned_at_most"].get<double>(), 1) << options;
  }
  const double plain = energy("")["returned"], passive = energy("--passive")["returned"];
  EXPECT_GT(plain, 1) << "the returned energy is measured";
  EXPECT_LT(passive, 0.05 * plain);
}

/// A tool that rests on a model is not reported as stuck on the scan. The model is touched by depth images or
/// by its mesh.
TEST_F(Command, ATouchOfAModelByImagesIsNotStuck) {
  ASSERT_EQ(run("phantom sphere --size 128 --psf 1 -o s.mha").exit_code, 0);
  // The path ends 4 mm in the box from above, away from the ball of the scan, and rests there for one second.
  write("box.obj",
        "v -60 -60 40\nv -40 -60 40\nv -60 -40 40\nv -40 -40 40\nv -60 -60 50\nv -40 -60 50\nv -60 -40 50\nv "
        "-40 -40 "
        "50\nf 1 3 2\nf 2 3 4\nf 5 6 7\nf 6 8 7\nf 1 2 5\nf 2 6 5\nf 3 7 4\nf 4 7 8\nf 1 5 3\nf 3 5 7\nf 2 4 "
        "6\nf 4 8 6\n");
  write("p.csv", "t,x,y,z\n0,-50,-50,55\n0.2,-50,-50,46\n1.2,-50,-50,46\n");
  for (const char* by : {"--mesh box.obj --method depth", "--mesh box.obj --method mesh"}) {
    fs::remove(file("o.csv"));
    const Json touch = json(std::string("touch s.mha --path p.csv -o o.csv --friction 0,0 ") + by);
    EXPECT_GT(touch["step_us"]["contact"]["count"], 900) << by;
    EXPECT_EQ(touch["stuck"], 0) << by;
    EXPECT_EQ(touch["fall_throughs"], 0) << by;
  }
}

const std::string k_scenes = TREPHINE_SOURCE_DIR "/docs/examples/whole-tools/";

/// The four scenes meet their expectations. A session with a model as the tool contains the model, plays to
/// the same bits, and passes the audit.
TEST_F(Command, ScenesOfWholeToolsMeetTheirExpectations) {
  const bool is_whole = std::getenv("TREPHINE_WHOLE") != nullptr;
  for (const std::string name : {"pipe-torus", "piping", "rabbit-hammer", "pipe-tube"}) {
    if (!is_whole && (name == "rabbit-hammer" || name == "pipe-tube")) continue;
    const Json played = json("run " + k_scenes + name + ".toml --record " + name + ".session");
    EXPECT_TRUE(played["is_met"].get<bool>()) << played.dump(1);
    EXPECT_TRUE(json("replay " + name + ".session --verify --scan " + k_scenes + "board.nrrd")["is_same"]
                    .get<bool>());
  }
  const ProcessResult audit = run("audit pipe-torus.session --scan " + k_scenes + "board.nrrd");
  EXPECT_EQ(audit.exit_code, 0) << audit.out << audit.err;
}

TEST_F(Command, AModelIsTheTool) {
  write("p.csv", "t,x,y,z\n0,0,0,40\n0.3,0,0,15\n0.6,0,0,15\n");
  const std::string touch = "touch " + k_scenes + "board.nrrd --iso 500 --path p.csv ";
  const Json touched =
      json(touch + "-o a.csv --tool " + k_scenes + "torus.obj --tool-spacing 1 --record t.session");
  // The ring of 17 mm about the x axis stands on the board, whose top is at 0: its centre is 2 mm above the
  // hand.
  EXPECT_NEAR(touched["max_force_n"].get<double>(), 0.5 * 2, 0.1) << touched.dump(1);
  EXPECT_TRUE(touched["fall_throughs"].is_null());
  const std::string audit = "audit t.session --scan " + k_scenes + "board.nrrd";
  EXPECT_EQ(run(audit).exit_code, 0);
  EXPECT_EQ(run(audit + " --plant tool").exit_code, 1);
  const auto refused = [&](const std::string& options, const char* what) {
    const ProcessResult r = run(touch + "-o b.csv " + options);
    EXPECT_EQ(r.exit_code, 2) << options;
    EXPECT_NE(r.err.find(what), std::string::npos) << r.err;
  };
  refused("--tool-spacing 1", "a spacing without a tool");
  refused("--tool none.obj", "the model does not exist");
  const std::string with_tool = "--tool " + k_scenes + "torus.obj ";
  refused(with_tool + "--radius 2", "a hand has one tool");
  refused(with_tool + "--method mesh", "does not touch with a model");
  refused(with_tool + "--tool-spacing 50", "0.02 to 10 mm");
  write("open.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  refused("--tool open.obj", "too few triangles");
}

}  // namespace
}  // namespace trephine::command_tests
