// Objects touched by depth images, by command: touched, recorded, replayed, judged.
#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/apps/command_fixture.h"
#include "tests/whole.h"

namespace trephine::command_tests {
namespace {

/// A ball of many triangles that moves up and down, as keys of an animation.
void write_keys(const std::string& folder) {
  std::filesystem::create_directory(folder);
  constexpr int k_around = 32, k_up = 16;
  for (int key = 0; key < 6; ++key) {
    std::ofstream out(folder + "/key" + std::to_string(key) + ".obj");
    const double z = 8 + 3 * std::sin(2 * 3.14159265358979 * key / 6);
    for (int j = 0; j <= k_up; ++j)
      for (int i = 0; i < k_around; ++i) {
        const double a = 2 * 3.14159265358979 * i / k_around, b = 3.14159265358979 * j / k_up;
        if ((j == 0 || j == k_up) && i > 0) continue;
        out << "v " << 6 * std::sin(b) * std::cos(a) << ' ' << 6 * std::sin(b) * std::sin(a) << ' '
            << z + 6 * std::cos(b) << '\n';
      }
    const auto at = [](int i, int j) {
      return j == 0 ? 1 : j == k_up ? 2 + (k_up - 1) * k_around : 2 + (j - 1) * k_around + i % k_around;
    };
    for (int j = 0; j < k_up; ++j)
      for (int i = 0; i < k_around; ++i) {
        if (j > 0) out << "f " << at(i, j) << ' ' << at(i, j + 1) << ' ' << at(i + 1, j) << '\n';
        if (j + 1 < k_up)
          out << "f " << at(i + 1, j) << ' ' << at(i, j + 1) << ' ' << at(i + 1, j + 1) << '\n';
      }
  }
}

TEST_F(Command, ObjectsTouchedByDepthImagesAreRecordedReplayedAndAudited) {
  ASSERT_EQ(run("phantom plate --size 48 --psf 1 -o s.mha").exit_code, 0);
  write_keys(file("keys"));
  {
    std::ofstream path(file("p.csv"));
    path << "t,x,y,z,button\n0,20,1,15,0\n0.4,2,1,13,0\n1.6,1,1,12,0\n2,18,0,14,0\n";
  }
  const std::string beat = " --depth-beat 0.1 --depth-repeat ";
  const Json touch = json("touch s.mha --depth keys" + beat + "--path p.csv -o t.csv --record a.session");
  EXPECT_EQ(touch["method"], "scene");
  EXPECT_GT(touch["max_force_n"].get<double>(), 0.3);
  EXPECT_EQ(touch["fall_throughs"], 0);
  const Json audit = json("audit a.session --scan s.mha");
  EXPECT_TRUE(audit["is_certified"].get<bool>());
  EXPECT_GT(audit["depth_image_ticks"].get<int>(), 100);
  EXPECT_LT(audit["deepest_in_depth_object_mm"].get<double>(), 0.2);
  EXPECT_EQ(run("audit a.session --scan s.mha --plant depth-images").exit_code, 1);

  // The ball recorded by a camera above it.
  const Json result = json("depth-record keys" + beat +
                           "--camera-at 0,0,200 --aim 0,0,8 --angle 10 --pixels 200x200 -o video");
  EXPECT_EQ(result["pictures"], 18);
  EXPECT_EQ(run("depth-record keys --camera-at 0,0,200 -o video").exit_code, 2);  // it exists already
  EXPECT_NE(run("depth-record keys --camera-at 0,0,200 --aim 0,0,400 -o other").exit_code, 0);
  const Json video = json("touch s.mha --depth video --path p.csv -o t.csv --record b.session");
  EXPECT_GT(video["max_force_n"].get<double>(), 0.3);
  EXPECT_TRUE(json("audit b.session --scan s.mha")["is_certified"].get<bool>());

  // A stream in the format of TUM's RGB-D benchmark: with time stamps like those of the benchmark, depths of
  // 5000 per metre, and no intrinsics.
  std::filesystem::create_directory(file("tum"));
  std::filesystem::copy(file("video/depth-0001.png"), file("tum/first.png"));
  std::filesystem::copy(file("video/depth-0002.png"), file("tum/second.png"));
  {
    std::ofstream list(file("tum/depth.txt"));
    list << "# depth maps\n1305031102.160407 first.png\n1305031102.194330 second.png\n";
  }
  const auto lacking = run("touch s.mha --depth tum --path p.csv -o t.csv");
  EXPECT_EQ(lacking.exit_code, 2);
  EXPECT_NE(lacking.err.find("intrinsics"), std::string::npos) << lacking.err;
  EXPECT_EQ(run("touch s.mha --depth tum --camera 525,525,99.5,99.5 --path p.csv -o t.csv").exit_code, 0);
  EXPECT_EQ(run("touch s.mha --depth tum --camera 525,0,99.5,99.5 --path p.csv -o t.csv").exit_code, 2);
  std::filesystem::remove(file("tum/second.png"));
  const auto stops = run("touch s.mha --depth tum --camera 525,525,99.5,99.5 --path p.csv -o t.csv");
  EXPECT_NE(stops.err.find("second.png"), std::string::npos) << stops.err;
  // Errors: keys with different triangles, and a surface that is not closed.
  { std::ofstream(file("keys/key9.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"; }
  EXPECT_NE(run("touch s.mha --depth keys --path p.csv -o t.csv").err.find("same triangles"),
            std::string::npos);
  EXPECT_NE(run("touch s.mha --depth keys/key9.obj --path p.csv -o t.csv").err.find("not closed"),
            std::string::npos);
}

/// A hand that is pressed deeper than the images reach is released, and its ticks inside the object are
/// counted. The counter that is zero in other cases can thus become nonzero.
TEST_F(Command, AHandThatImagesDoNotHoldIsCounted) {
  ASSERT_EQ(run("phantom plate --size 48 --psf 1 -o s.mha").exit_code, 0);
  {
    std::ofstream cube(file("cube.obj"));
    for (const int z : {-500, -100})
      for (const int y : {-200, 200})
        for (const int x : {-200, 200}) cube << "v " << x << ' ' << y << ' ' << z << '\n';
    cube << "f 1 3 2\nf 2 3 4\nf 5 6 7\nf 6 8 7\nf 1 2 5\nf 2 6 5\nf 3 7 4\nf 4 7 8\nf 1 5 3\nf 3 5 7\n"
            "f 2 4 6\nf 4 8 6\n";
    std::ofstream(file("deep.csv")) << "t,x,y,z\n0,0,0,-95\n0.6,0,0,-280\n0.8,0,0,-280\n";
    std::ofstream(file("held.csv")) << "t,x,y,z\n0,0,0,-95\n0.1,0,0,-120\n0.3,0,0,-120\n";
  }
  const std::string touch = "touch s.mha --depth cube.obj --depth-pixel 1 --stiffness 0.02 -o t.csv ";
  const Json held = json(touch + "--path held.csv --record held.session");
  EXPECT_EQ(held["ticks_inside_depth_object"], 0);
  EXPECT_TRUE(json("audit held.session --scan s.mha")["is_certified"].get<bool>());
  EXPECT_EQ(run(touch + "--path deep.csv --record deep.session").exit_code, 1);
  const auto audit = run("audit deep.session --scan s.mha");
  EXPECT_EQ(audit.exit_code, 1);
  EXPECT_NE(audit.out.find("where no images held the hand"), std::string::npos) << audit.out;
  const auto fine = run("touch s.mha --depth cube.obj --depth-pixel 0.02 --path held.csv -o t.csv");
  EXPECT_EQ(fine.exit_code, 2);
  EXPECT_NE(fine.err.find("choose larger pixels"), std::string::npos) << fine.err;
}

/// The sample retractor.toml: one hand drills voxels with a burr, the other rests on a yielding blade that is
/// touched by depth images.
TEST_F(Command, ARetractorYieldsNextToABurrHole) {
  const std::string script = TREPHINE_SOURCE_DIR "/docs/examples/retractor.toml";
  EXPECT_EQ(run("run '" + script + "' --record r.session").exit_code, 0);
  if (!runs_all_cases()) return;  // takes some ten seconds
  const Json audit = json("audit r.session");
  EXPECT_TRUE(audit["is_certified"].get<bool>());
  EXPECT_GT(audit["depth_image_ticks"].get<int>(), 1000);
  EXPECT_LT(audit["deepest_in_depth_object_mm"].get<double>(), 0.1);
}

/// Three samples: a depth video, the inside of a calabash, and a scene with voxels, a mesh and depth images.
TEST_F(Command, SamplesOfMixedScenesAreCertified) {
  for (const char* name : {"depth-video", "calabash", "mixed-scene"}) {
    if (!runs_all_cases() && name == std::string("mixed-scene")) continue;  // drills for seconds
    const std::string script = std::string(TREPHINE_SOURCE_DIR "/docs/examples/") + name + ".toml";
    const std::string session = std::string(name) + ".session";
    EXPECT_EQ(run("run '" + script + "' --record " + session).exit_code, 0) << name;
    if (!runs_all_cases() && name != std::string("calabash")) continue;
    const Json audit = json("audit " + session);
    EXPECT_TRUE(audit["is_certified"].get<bool>()) << name;
    EXPECT_GT(audit["depth_image_ticks"].get<int>(), 400) << name;
    EXPECT_LT(audit["deepest_in_depth_object_mm"].get<double>(), 0.1) << name;
  }
  // An object at rest is judged during contact, and a proxy in its wall is detected.
  EXPECT_EQ(run("audit calabash.session --plant depth-images").exit_code, 1);
  if (runs_all_cases()) {
    EXPECT_EQ(run("audit calabash.session --plant fall").exit_code, 2) << "a fall cannot be planted";
  }
}

}  // namespace
}  // namespace trephine::command_tests
