// Further volumes: scans that are touched in addition to the scan that is cut. They are given by options, by
// a case or by a script.
#include <cmath>

#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

/// An NRRD file with a ball of radius `radius` (mm) around the middle of a cube of `size` voxels of 1 mm,
/// whose first voxel lies at `origin`: "(x,y,z)".
std::string ball(int size, double radius, const std::string& origin) {
  std::string text = nrrd(size, [&](int x, int y, int z) {
    const double middle = size / 2;
    const double r =
        std::sqrt((x - middle) * (x - middle) + (y - middle) * (y - middle) + (z - middle) * (z - middle));
    return static_cast<int>(std::lround(std::clamp(300 + 100 * (radius - r), -1000.0, 2000.0)));
  });
  const std::string zero = "space origin: (0,0,0)";
  return text.replace(text.find(zero), zero.size(), "space origin: " + origin);
}

class FurtherVolumes : public Command {
 protected:
  /// Writes a ball with a radius of 10 mm around (20, 20, 20), and a ball with a radius of 6 mm around (20,
  /// 20, 40). The path presses 2 mm into the top of the second ball, then 2 mm into the side of the first.
  void SetUp() override {
    write("a.nrrd", ball(40, 10, "(0,0,0)"));
    write("b.nrrd", ball(24, 6, "(8,8,28)"));
    write("p.csv",
          "t,x,y,z\n0,20.1,20.2,60\n0.2,20.1,20.2,47\n0.5,20.1,20.2,44\n0.7,20.1,20.2,60\n"
          "0.8,45,20.2,60\n0.9,45,20.2,20.1\n1.1,32,20.2,20.1\n1.4,28,20.2,20.1\n");
  }
  /// Reads the proxy in contact from a table of steps: its last z from 0.45 to 0.5 s, and its last x after
  /// 1.3 s; 0 without contact.
  void read_contacts(const std::string& table, double& top, double& side) const {
    std::istringstream rows(read(file(table)));
    std::string row;
    std::getline(rows, row);
    top = side = 0;
    while (std::getline(rows, row)) {
      std::vector<std::string> cells;
      std::istringstream line(row);
      for (std::string cell; std::getline(line, cell, ',');) cells.push_back(cell);
      if (cells[13] != "1") continue;
      const double x = std::stod(cells[4]), z = std::stod(cells[6]), t = std::stod(cells[0]);
      if (t > 0.45 && t < 0.5) top = z;
      if (t > 1.3) side = x;
    }
  }
};

TEST_F(FurtherVolumes, AreTouchedWhereTheirFilesStateAndReplayedFromTheSession) {
  const Json touch = json(
      "touch a.nrrd --iso 300 --more-scan b.nrrd --more-shape 300 --path p.csv -o t.csv "
      "--friction 0,0 --record s.session");
  EXPECT_EQ(touch["method"], "scene");
  EXPECT_EQ(touch["fall_throughs"], 0);
  double top = 0, side = 0;
  read_contacts("t.csv", top, side);
  EXPECT_NEAR(top, 46, 0.05);
  EXPECT_NEAR(side, 30, 0.05);
  // The session contains both scans.
  fs::remove(folder_ / "a.nrrd"), fs::remove(folder_ / "b.nrrd");
  EXPECT_EQ(json("replay s.session --verify")["is_same"], true);
  EXPECT_NE(run("info s.session").out.find("volume 2"), std::string::npos) << run("info s.session").out;
}

/// Without the second scan, nothing stops the hand at the position of that scan. The previous test can fail.
TEST_F(FurtherVolumes, AreNotTouchedWithoutTheirFile) {
  ASSERT_EQ(run("touch a.nrrd --iso 300 --path p.csv -o t.csv --friction 0,0").exit_code, 0);
  double top = 0, side = 0;
  read_contacts("t.csv", top, side);
  EXPECT_EQ(top, 0);
  EXPECT_NEAR(side, 30, 0.05);
}

TEST_F(FurtherVolumes, ComeFromACase) {
  ASSERT_EQ(run("import a.nrrd --hounsfield --iso 300 -o case").exit_code, 0);
  const std::string plan = read(file("case/case.toml"));
  fs::copy_file(file("b.nrrd"), file("case/b.nrrd"));
  write("case/case.toml", plan +
                              "\n[[volumes]]\nname = \"donor\"\nfile = \"b.nrrd\"\nmatter = \"titanium\"\n"
                              "\n[[structures]]\nname = \"graft\"\nvolume = \"donor\"\nlow = 300\n"
                              "stiffness = 0.5\n");
  const Json touch = json("touch case --path p.csv -o t.csv --friction 0,0");
  EXPECT_EQ(touch["method"], "scene");
  double top = 0, side = 0;
  read_contacts("t.csv", top, side);
  EXPECT_NEAR(top, 46, 0.05);
  EXPECT_NEAR(side, 30, 0.05);
  // Errors name the key or the file.
  write("case/case.toml", plan + "\n[[structures]]\nname = \"graft\"\nvolume = \"donor\"\nlow = 300\n");
  ProcessResult ended = run("touch case --path p.csv -o u.csv");
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_NE(ended.err.find("unknown volume"), std::string::npos) << ended.err;
  write("case/case.toml", plan + "\n[[volumes]]\nname = \"donor\"\nfile = \"c.nrrd\"\n");
  ended = run("touch case --path p.csv -o u.csv");
  EXPECT_NE(ended.err.find("lacks a volume"), std::string::npos) << ended.err;
}

TEST_F(FurtherVolumes, ComeFromAScript) {
  write("r.toml", R"(schema = 1
title = "Two balls"
scan = "a.nrrd"
iso = 300
[[volumes]]
file = "b.nrrd"
shape = "300"
name = "graft"
[[hands]]
method = "scene"
path = "p.csv"
)");
  const ProcessResult ended = run("run r.toml --record s.session --json");
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(run("info s.session").out.find("graft"), std::string::npos) << run("info s.session").out;
}

TEST_F(FurtherVolumes, InvalidShapesAreRefused) {
  const ProcessResult two = run(
      "touch a.nrrd --iso 300 --more-scan b.nrrd --more-shape 300 --more-shape 400 --path p.csv -o t.csv");
  EXPECT_EQ(two.exit_code, 2);
  EXPECT_NE(two.err.find("--more-shape"), std::string::npos) << two.err;
  const ProcessResult label =
      run("touch a.nrrd --iso 300 --more-scan b.nrrd --more-shape graft --path p.csv -o t.csv");
  EXPECT_EQ(label.exit_code, 2);
  EXPECT_NE(label.err.find("the scan has no labels"), std::string::npos) << label.err;
  EXPECT_EQ(leftovers({"a.nrrd", "b.nrrd", "p.csv"}), "");
}

}  // namespace
}  // namespace trephine::command_tests
