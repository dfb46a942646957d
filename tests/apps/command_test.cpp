// The trephine command as users run it: exit codes, keys of its JSON, its CSV, its errors, its pictures.
// Kept in one file: the behaviour common to all commands, and commands without a test file of their own.
#include <algorithm>
#include <array>
#include <cmath>

#include "data-tools/formats/open_volume.h"
#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

std::set<std::string> keys_of(const Json& json) {
  std::set<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.insert(key);
  return keys;
}
const std::set<std::string> k_common{"schema", "version", "commit", "compiler", "cpu"};
std::set<std::string> with_common(std::set<std::string> keys) {
  keys.insert(k_common.begin(), k_common.end());
  return keys;
}

TEST_F(Command, VersionAndHelpEndWithZeroAndExamples) {
  EXPECT_EQ(run("--version").exit_code, 0);
  EXPECT_NE(run("--version").out.find("trephine 0.1.0"), std::string::npos);
  for (const char* name : {"", "phantom", "info", "mesh", "touch", "drill", "view", "demo", "bench", "audit",
                           "replay", "resume", "import", "doctor"}) {
    const ProcessResult r = run(std::string(name) + " --help");
    EXPECT_EQ(r.exit_code, 0) << name;
    EXPECT_NE(r.out.find("Examples:\n  trephine"), std::string::npos) << name;
  }
}

TEST_F(Command, PhantomInfoMeshTouchDrillHaveTheirKeys) {
  const Json phantom = json("phantom sphere --size 48 --psf 1 -o s.mha");
  EXPECT_EQ(phantom["schema"], "trephine.phantom/1");
  EXPECT_EQ(keys_of(phantom), with_common({"name", "written", "size", "spacing_mm", "origin_mm", "axis_x",
                                           "axis_y", "axis_z", "labels"}));

  const Json info = json("info s.mha");
  EXPECT_EQ(keys_of(info),
            with_common({"source", "format", "modality", "size", "spacing_mm", "origin_mm", "axis_x",
                         "axis_y", "axis_z", "is_orthogonal", "is_hounsfield", "min", "max", "mean", "labels",
                         "facts", "series", "notices", "read_seconds"}));
  EXPECT_EQ(info["size"], Json::array({48, 48, 48}));
  EXPECT_EQ(info["min"], -1000);
  EXPECT_EQ(info["max"], 1600);
  EXPECT_EQ(info["source"], "scan") << "a file's name may be a patient's";

  const Json mesh = json("mesh s.mha -o s.ply");
  EXPECT_EQ(keys_of(mesh),
            with_common({"source", "shape", "written", "vertices", "triangles", "mesh_seconds"}));
  EXPECT_EQ(mesh["triangles"].get<long>(), 2 * (mesh["vertices"].get<long>() - 2))
      << "a closed surface of genus 0";
  // A ball has no thin walls; its diameter is that of its bounding box.
  const Json walls = json("mesh s.mha -o walls.ply --printed-wall 1");
  EXPECT_EQ(walls["shells"], 1);
  EXPECT_EQ(walls["open_edges"], 0);
  EXPECT_EQ(walls["thin_wall_percent"], 0);
  EXPECT_NEAR(walls["thinnest_wall_mm"].get<double>(), walls["size_mm"][0].get<double>(), 1.5);
  EXPECT_EQ(run("mesh s.mha -o walls.ply --printed-wall 0").exit_code, 2);

  write_press("p.csv", 2);
  const Json touch = json("touch s.mha --path p.csv -o steps.csv");
  EXPECT_EQ(keys_of(touch),
            with_common({"source", "shape", "method", "steps", "step_us", "counters", "events", "energy_nmm",
                         "fall_throughs", "stuck", "max_force_n", "open_to_touch_seconds", "read_seconds",
                         "making_seconds", "memory", "written"}));
  for (const char* phase : {"contact", "free"})
    EXPECT_EQ(keys_of(touch["step_us"][phase]),
              (std::set<std::string>{"count", "p50", "p99", "p999", "max"}));
  EXPECT_EQ(touch["method"], "subvoxel");
  EXPECT_EQ(touch["fall_throughs"], 0);
  EXPECT_EQ(touch["counters"]["surfaces_made"], 0);
  EXPECT_EQ(touch["counters"]["gl_contexts_made"], 0);
  EXPECT_EQ(touch["counters"]["shapes_with_bits"], 1);
  EXPECT_LT(touch["memory"]["held_over_voxels"], 1.3);

  const Json drill = json("drill s.mha --burr-diameter 4 --path p.csv -o d.mha");
  EXPECT_EQ(keys_of(drill),
            with_common({"source", "shape", "burr", "burr_diameter_mm", "is_kinematic", "is_round", "method",
                         "steps", "removed_mm3", "removed_mm3_total", "tick_us", "content_hash", "memory",
                         "measures", "breakthroughs", "written"}));
  EXPECT_GT(drill["removed_mm3_total"], 1);
  EXPECT_GT(
      json("drill s.mha --burr-diameter 4 --removal-rate 30 --path p.csv -o e.mha")["removed_mm3_total"], 5);
  const Json match = json(
      "drill s.mha --burr-diameter 4 --burr-shape match-head --grade diamond --rpm 40000 "
      "--removal-rate 60 --path p.csv -o f.mha");
  EXPECT_NE(match["burr"].get<std::string>().find("shape=match-head grade=diamond rpm=40000"),
            std::string::npos);
  EXPECT_GT(match["removed_mm3_total"], 5);
  for (const char* bad : {"--burr-shape square", "--rpm 0", "--burr-length -1", "--grade fine", "--shaft 100",
                          "--burr-shape cylinder --burr-length 0.1", "--removal-rate -1"})
    EXPECT_EQ(run(std::string("drill s.mha --burr-diameter 4 --path p.csv -o g.mha ") + bad).exit_code, 2)
        << bad;
  EXPECT_FALSE(fs::exists(folder_ / "g.mha"));
  // A window is prepared for the narrowest part of its burr.
  EXPECT_EQ(run("view s.mha --burr-diameter 3 --burr-shape match-head --screenshot v.png").exit_code, 0);
  EXPECT_EQ(json("info d.mha")["size"], Json::array({48, 48, 48}));
}

TEST_F(Command, StepsAreExactCsv) {
  ASSERT_EQ(run("phantom sphere --size 64 --psf 1 -o s.mha").exit_code, 0);
  write_press("p.csv", 2);
  ASSERT_EQ(run("touch s.mha --path p.csv -o steps.csv --friction 0,0").exit_code, 0);
  std::istringstream rows(read(file("steps.csv")));
  std::string line;
  std::getline(rows, line);
  EXPECT_EQ(line,
            "t,hip_x,hip_y,hip_z,proxy_x,proxy_y,proxy_z,normal_x,normal_y,normal_z,force_x,force_y,force_z,"
            "contact,shape,side,hand,qx,qy,qz,qw,torque_x,torque_y,torque_z");
  int count = 0, contacts = 0;
  double deepest = 0;
  while (std::getline(rows, line)) {
    ++count;
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    ASSERT_EQ(cells.size(), 24u) << line;
    EXPECT_EQ(cells[16], "1");
    EXPECT_EQ(cells[20], "1");  // qw: the path has no rotations
    EXPECT_EQ(std::stod(cells[21]) + std::stod(cells[22]) + std::stod(cells[23]), 0);
    if (cells[13] == "1") {
      ++contacts;
      EXPECT_EQ(cells[14], "bone");
      EXPECT_EQ(cells[15], "front");
      const double proxy = std::hypot(std::stod(cells[4]), std::stod(cells[5]), std::stod(cells[6]));
      EXPECT_NEAR(proxy, 44.93, 0.04);  // 45 mm minus the effect of the blur
      deepest = std::max(deepest, std::stod(cells[6]) - std::stod(cells[3]));
    }
  }
  EXPECT_EQ(count, 1201);  // 1 kHz over 1.2 s, both ends
  EXPECT_GT(contacts, 700);
  EXPECT_NEAR(deepest, 2, 0.1);
}

// Volumes that a kinematic burr removes agree at all rates within 0.1 %, and with the exact volume at three
// voxel sizes within 1 %.
TEST_F(Command, KinematicVolumesAgreeAtAllRatesAndVoxelSizes) {
  write("line.csv", "t,x,y,z\n0,-20,-8,3\n0.5,14,6,-5\n");
  const double length = std::sqrt(34.0 * 34 + 14 * 14 + 8 * 8), r = 4.2, pi = 3.14159265358979;
  const double exact = pi * r * r * length + 4.0 / 3 * pi * r * r * r;
  std::vector<double> by_rate, by_size;
  ASSERT_EQ(run("phantom sphere --spacing 1 -o s1.mha").exit_code, 0);
  for (const char* rate : {"100", "1000", "10000"})
    by_rate.push_back(
        json(std::string("drill s1.mha --burr-diameter 8.4 --kinematic --path line.csv -o d.mha --rate ") +
             rate)["removed_mm3_total"]);
  for (const double v : by_rate) EXPECT_NEAR(v / by_rate[0], 1, 1e-3);
  for (const char* spacing : {"0.6", "0.8", "1"}) {
    ASSERT_EQ(run(std::string("phantom sphere --spacing ") + spacing + " -o s.mha").exit_code, 0);
    by_size.push_back(
        json("drill s.mha --burr-diameter 8.4 --kinematic --path line.csv -o d.mha")["removed_mm3_total"]);
  }
  for (const double v : by_size) EXPECT_NEAR(v / exact, 1, 0.01);
}

TEST_F(Command, ThroughTheProxyVolumesAgreeAtRatesAndVoxelSizes) {
  // The burr cuts 3 mm deep into flat bone, then 8 mm along its surface.
  write("path.csv", "t,x,y,z\n0,-4,0,3\n0.3,-4,0,0\n2.3,-4,0,-3\n6.3,4,0,-3\n6.8,4,0,4\n");
  std::vector<double> volumes;
  const std::pair<const char*, const char*> settings[] = {
      {"0.5", "1000"}, {"0.6", "4000"}, {"0.75", "250"}, {"0.75", "1000"}};
  for (const auto& [spacing, rate] : settings) {
    const int size = static_cast<int>(std::lround(48 / std::stod(spacing)));
    ASSERT_EQ(run("phantom plane --set angle=0 --psf 1 --spacing " + std::string(spacing) + " --size " +
                  std::to_string(size) + " -o p.mha")
                  .exit_code,
              0);
    volumes.push_back(json(
        std::string("drill p.mha --burr-diameter 7 --removal-rate 100 --path path.csv -o d.mha --rate ") +
        rate)["removed_mm3_total"]);
  }
  // A ball of radius 3.5 whose lowest point is 3 mm deep: a spherical cap and a circular segment over 8 mm.
  const double r = 3.5, h = 3, pi = 3.14159265358979;
  const double cap = pi * h * h * (3 * r - h) / 3,
               segment = r * r * std::acos((r - h) / r) - (r - h) * std::sqrt(2 * r * h - h * h);
  for (const double v : volumes) {
    EXPECT_NEAR(v / (cap + 8 * segment), 1, 0.02);
    EXPECT_NEAR(v / volumes[0], 1, 0.02);
  }
}

TEST_F(Command, BadInputIsReportedAndWritesNothing) {
  ASSERT_EQ(run("phantom sphere --size 24 -o s.mha").exit_code, 0);
  write("short.csv", "t,x,y\n0,1,2\n");
  write("nan.csv", "t,x,y,z\n0,1,2,nan\n");
  write("back.csv", "t,x,y,z\n1,1,2,3\n0,1,2,3\n");
  write("good.csv", "t,x,y,z\n0,0,0,60\n1,0,0,40\n");
  write("text.mha", "no scan\n");
  fs::create_directory(folder_ / "empty");
  const std::set<std::string> before{"s.mha",    "short.csv", "nan.csv", "back.csv",
                                     "good.csv", "text.mha",  "empty"};
  const std::tuple<const char*, int, const char*> faults[] = {
      {"info nowhere", 2, "does not exist"},
      {"info empty", 2, "no DICOM images"},
      {"info text.mha", 2, "cannot be read"},
      {"./head", 2, ""},
      {"info ./head", 2, "does not exist"},
      {"touch s.mha --path short.csv -o o.csv", 2, "no column z"},
      {"touch s.mha --path nan.csv -o o.csv", 2, "not a number"},
      {"touch s.mha --path back.csv -o o.csv", 2, "not increasing"},
      {"touch s.mha --path gone.csv -o o.csv", 2, "path file does not exist"},
      {"touch s.mha --path good.csv -o nowhere/o.csv", 2, "folder does not exist"},
      {"touch s.mha --path good.csv -o o.csv --method magic", 2, "magic"},
      {"touch s.mha --path good.csv -o o.csv --friction 1", 2, "--friction"},
      {"touch s.mha --path good.csv -o o.csv --alpha 2", 2, "alpha"},
      {"touch s.mha --path good.csv -o o.csv --rate 0", 2, "rate"},
      {"touch s.mha --path good.csv -o o.csv --stiffness nan", 2, "stiffness"},
      {"touch s.mha --path good.csv -o o.csv --iso 5000", 2, "empty"},
      {"touch s.mha --path good.csv -o o.csv --label bone", 2, "no labels"},
      {"touch s.mha --path good.csv -o o.csv --range 9", 2, "LO:HI"},
      {"touch s.mha --path good.csv -o o.csv --range 9:3", 2, "swap"},
      {"view s.mha --screenshot o.jpg", 2, ".png"},
      {"drill s.mha --path good.csv -o nowhere/o.mha --burr-diameter 3", 2, "folder does not exist"},
      {"info UPPER.NII.GZ", 2, "does not exist"},
      {"touch s.mha --path good.csv -o o.csv --iso 3 --range 1:2", 2, "one of iso, window and label"},
      {"drill s.mha --path good.csv -o o.mha --burr-diameter -3", 2, "burr"},
      {"drill s.mha --path good.csv -o o.xyz --burr-diameter 3", 2, "format"},
      {"import s.mha --iso 3 --range 1:2 -o c", 2, "one of iso, window and label"},
      {"mesh s.mha -o o.xyz", 2, "format"},
      {"phantom cube -o o.mha", 2, "unknown phantom"},
      {"phantom sphere -o o.mha --size 0", 2, "size"},
      {"phantom sphere -o o.mha --size 30000", 3, "memory"},
      {"phantom sphere -o o.mha --size 1,2", 2, "X,Y,Z"},
      {"phantom sphere -o o.mha --spacing -1", 2, "spacing"},
      {"phantom sphere -o o.mha --set radius", 2, "key=value"},
      {"view s.mha", 3, "no display"},
      {"bench nothing", 2, "trephine-bench --help"},
      {"frobnicate", 2, ""},
      {"touch --frobnicate", 2, ""},
      {"", 2, ""},
  };
  for (const auto& [arguments, code, word] : faults) {
    const ProcessResult r = run(arguments);
    EXPECT_EQ(r.exit_code, code) << arguments << "\n" << r.err;
    EXPECT_TRUE(r.out.empty()) << arguments;
    EXPECT_NE(r.err.find("error: "), std::string::npos) << arguments << r.err;
    EXPECT_NE(r.err.find(word), std::string::npos) << arguments << "\n" << r.err;
    EXPECT_EQ(r.err.find(folder_.string()), std::string::npos) << "a full path: " << r.err;
    EXPECT_EQ(leftovers(before), "") << arguments;
  }
  const ProcessResult r = run("info nowhere --json");
  EXPECT_EQ(r.exit_code, 2);
  const Json error = Json::parse(r.out);
  EXPECT_EQ(keys_of(error), with_common({"command", "error"}));
  EXPECT_EQ(error["schema"], "trephine.error/1");
  EXPECT_EQ(error["command"], "info");
  EXPECT_EQ(keys_of(error["error"]), (std::set<std::string>{"what", "where", "found", "expected", "remedy"}));
}

// Noisy bone of a real scanner: a tool enters and leaves it at random for twenty seconds, and a burr follows
// the same path.
TEST_F(Command, OnARealSkullNothingFallsThrough) {
  const char* given = std::getenv("TREPHINE_DATA");
  const std::string data = given ? given : TREPHINE_SOURCE_DIR "/../shared/data";
  if (!fs::exists(data + "/skull_phantom")) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  ASSERT_EQ(
      std::system(("tar xJf '" + data + "/skull_phantom/bone_1mm.dicom.tar.xz' -C '" + folder_.string() + "'")
                      .c_str()),
      0);
  std::ostringstream path;
  path << "t,x,y,z\n";
  std::uint32_t state = 12345;
  const auto random = [&state] {
    return static_cast<double>(state = state * 1664525u + 1013904223u) / 4294967296.0 - 0.5;
  };
  double at[3] = {0, 60, 800}, velocity[3] = {0, 0, 0};
  const double low[3] = {-70, 30, 700}, high[3] = {70, 210, 828};
  for (int i = 0; i < 20000; ++i) {
    for (int a = 0; a < 3; ++a) {
      velocity[a] = 0.98 * velocity[a] + 0.12 * random();
      at[a] += velocity[a];
      if (at[a] < low[a] || at[a] > high[a])
        at[a] = std::clamp(at[a], low[a], high[a]), velocity[a] = -velocity[a];
    }
    path << i * 1e-3 << ',' << at[0] << ',' << at[1] << ',' << at[2] << '\n';
  }
  write("walk.csv", path.str());
  const Json touch = json("touch bone_1mm --path walk.csv -o steps.csv");
  EXPECT_EQ(touch["fall_throughs"], 0);
  EXPECT_GT(touch["step_us"]["contact"]["count"], 2000);
  EXPECT_LT(touch["memory"]["held_over_voxels"], 1.3);
  const Json drill = json("drill bone_1mm --burr-diameter 4 --path walk.csv -o drilled.mha");
  EXPECT_GT(drill["removed_mm3_total"], 20);

  // The bone as clinical CT would show it: three slices in one.
  {
    const auto opened = data_tools::open_volume(file("bone_1mm"));
    ASSERT_TRUE(opened.is_ok());
    const volume::Volume& fine = opened.value().volume;
    const glm::dmat3& axes = fine.frame.axes();
    // Around the start of the walk.
    const glm::ivec3 middle(fine.frame.volume_from_world({0, 70, 765})),
        low = glm::max(middle - glm::ivec3(70, 70, 51), glm::ivec3(0)),
        high = glm::min(middle + glm::ivec3(70, 70, 51), fine.size);
    const auto frame =
        volume::Frame::from_axes(fine.frame.world_from_volume(glm::dvec3(low) + glm::dvec3(0, 0, 1)),
                                 {axes[0], axes[1], 3.0 * axes[2]});
    const glm::ivec3 size = high - low;
    volume::Volume thick = volume::make_volume({size.x, size.y, size.z / 3}, frame.value()).value();
    for (int z = 0; z < thick.size.z; ++z)
      for (int y = 0; y < thick.size.y; ++y)
        for (int x = 0; x < thick.size.x; ++x) {
          int sum = 0;
          for (int k = 0; k < 3; ++k) sum += fine.voxels[fine.index(low.x + x, low.y + y, low.z + 3 * z + k)];
          thick.voxels[thick.index(x, y, z)] = static_cast<std::int16_t>(std::lround(sum / 3.0));
        }
    ASSERT_FALSE(data_tools::write_volume(file("thick.mha"), thick).has_value());
  }
  // Three seconds of the walk: offset fields and judges of round tools take time.
  std::string part = path.str();
  for (std::size_t i = 0, at = 0; i <= 3000; ++i)
    at = part.find('\n', at) + 1, part.resize(i < 3000 ? part.size() : at);
  write("part.csv", part);
  for (const char* radius : {"0", "0.5", "2"}) {
    const Json report = json(std::string("touch thick.mha --path part.csv -o steps.csv --radius ") + radius);
    EXPECT_EQ(report["fall_throughs"], 0) << radius;
    EXPECT_GT(report["step_us"]["contact"]["count"], 200) << radius;
  }
  for (const char* burr : {"--burr-diameter 1 --kinematic", "--burr-diameter 4 --round"}) {
    fs::remove(file("thick.session"));
    const Json cut =
        json(std::string("drill thick.mha --path part.csv -o cut.mha --record thick.session ") + burr);
    EXPECT_GT(cut["removed_mm3_total"], 1) << burr;
    const Json audit = json("audit thick.session --scan thick.mha");
    EXPECT_EQ(audit["is_certified"], true) << burr << audit;
    EXPECT_GT(audit["ticks_judged"], 2500) << burr;
  }
}

TEST_F(Command, AScanWithoutHounsfieldUnitsHasNoDefaultThreshold) {
  // An MR-like volume: no value far below zero.
  std::string header =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nDimSize = 8 8 "
      "8\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
  std::string voxels(512, '\0');
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<char>(i % 100);
  write("mr.mha", header + voxels);
  EXPECT_EQ(run("mesh mr.mha -o m.stl").exit_code, 2);
  EXPECT_NE(run("mesh mr.mha -o m.stl").err.find("no shape chosen"), std::string::npos);
  EXPECT_EQ(run("mesh mr.mha --iso 50 -o m.stl").exit_code, 0);
}

TEST_F(Command, PicturesAreDrawnWithoutADisplay) {
  const Json view = json("view head --screenshot v.png");
  EXPECT_EQ(view["is_offscreen"], true);
  EXPECT_GT(view["triangles"], 100000);
  EXPECT_GT(view["counters"]["surfaces_made"], 50) << "surfaces are counted";
  EXPECT_EQ(view["counters"]["gl_contexts_made"], 1);
  const std::string png = read(file("v.png"));
  ASSERT_GT(png.size(), 20000u);
  EXPECT_EQ(png.substr(1, 3), "PNG");
}

/// No output replaces an input (a file of a case, the voxels of a detached header, a model, a scan), or
/// another output of the command.
TEST_F(Command, NoOutputReplacesAnInput) {
  ASSERT_EQ(run("phantom sphere --size 24 --spacing 1 -o a.mha").exit_code, 0);
  ASSERT_EQ(run("import a.mha --iso 300 -o case").exit_code, 0);
  ASSERT_EQ(run("mesh a.mha --iso 300 -o b.ply").exit_code, 0);
  write("p.csv", "t,x,y,z\n0,0,0,14\n0.3,0,0,5\n");
  write("d.mhd",
        "ObjectType = Image\nNDims = 3\nDimSize = 24 24 24\nElementType = MET_SHORT\nElementSpacing = 1 1 1\n"
        "ElementDataFile = voxels.csv\n");
  write("voxels.csv", std::string(2 * 24 * 24 * 24, '\1'));
  for (const char* command :
       {"touch case --path p.csv -o case/volume.mha",
        "touch a.mha --iso 300 --mesh b.ply --path p.csv -o b.ply",
        "touch d.mhd --iso 300 --path p.csv -o voxels.csv",
        "drill case --burr-diameter 4 --path p.csv -o case/volume.mha",
        "phantom head --spacing 8 -o h.mha --write-labels h.mha", "mesh a.mha --iso 300 -o a.mha"}) {
    const ProcessResult answer = run(command);
    EXPECT_EQ(answer.exit_code, 2) << command;
    EXPECT_FALSE(fs::exists(folder_ / "h.mha"));
  }
  EXPECT_EQ(run("info case").exit_code, 0);
  // A new file may be written to the folder of a case.
  EXPECT_EQ(run("touch case --path p.csv -o case/steps.csv").exit_code, 0);
  // Voxels in another folder, and voxels in many files.
  const std::string head =
      "ObjectType = Image\nNDims = 3\nDimSize = 24 24 24\nElementType = MET_SHORT\nElementSpacing = 1 1 1\n";
  fs::create_directory(folder_ / "sub");
  fs::copy_file(folder_ / "voxels.csv", folder_ / "sub" / "w.csv");
  fs::create_symlink(folder_ / "sub" / "w.csv", folder_ / "link.csv");
  write("e.mhd", head + "ElementDataFile = sub/w.csv\n");
  write("f.mhd", head + "ElementDataFile = link.csv\n");
  for (const char* header : {"e.mhd", "f.mhd"})
    EXPECT_EQ(run(std::string("touch ") + header + " --iso 200 --path p.csv -o sub/w.csv").exit_code, 2);
  EXPECT_EQ(fs::file_size(folder_ / "sub" / "w.csv"), 2u * 24 * 24 * 24);
  // An earlier output in the folder of a header is not a file of this header, so it may be replaced.
  for (int again = 0; again < 2; ++again)
    EXPECT_EQ(run("touch e.mhd --iso 200 --path p.csv -o w.csv").exit_code, 0);
  for (int again = 0; again < 2; ++again)
    EXPECT_EQ(run("touch d.mhd --iso 200 --path p.csv -o d.csv").exit_code, 0);
}

/// Names of files may contain bytes that are not UTF-8.
TEST_F(Command, NamesThatAreNotUtf8DoNotEndAReport) {
  ASSERT_EQ(run("phantom sphere --size 24 --spacing 1 -o a.mha").exit_code, 0);
  write("p.csv", "t,x,y,z\n0,0,0,14\n0.3,0,0,5\n");
  for (const char* command : {"touch a.mha --iso 300 --path p.csv -o \"$(printf 'x\\376.csv')\" --json",
                              "info \"$(printf 's\\377')\" --json"}) {
    const ProcessResult answer = run(command);
    EXPECT_LE(answer.exit_code, 3) << command << answer.err;
    EXPECT_FALSE(Json::parse(answer.out).empty()) << command;
  }
}

TEST_F(Command, DemoLeavesPicturesAndAReport) {
  // The folder of the case has the name of a person. No output contains this name.
  ASSERT_EQ(run("phantom head -o head.mha --write-labels labels.mha").exit_code, 0);
  ASSERT_EQ(run("import head.mha --labels labels.mha -o MUSTERMANN").exit_code, 0);
  const Json demo = json("demo MUSTERMANN -o out --no-window");
  for (const auto& written : fs::directory_iterator(folder_ / "out"))
    EXPECT_EQ(read(written.path().string()).find("MUSTERMANN"), std::string::npos) << written.path();
  for (const char* name : {"1-touch.png", "2-drilling.png", "3-burr-hole.png"})
    EXPECT_GT(fs::file_size(folder_ / "out" / name), 20000u) << name;
  const Json report = Json::parse(read(file("out/report.json")));
  EXPECT_EQ(report["schema"], "trephine.demo/1");
  EXPECT_EQ(keys_of(report),
            with_common({"source", "shape", "ready_seconds", "live_seconds", "drawing_seconds", "ticks",
                         "contact_ticks", "max_force_n", "bone_thickness_mm", "removed_mm3_total",
                         "removed_mm3", "is_through", "changes", "servo", "memory", "pictures", "checks"}));
  EXPECT_EQ(report["is_through"], true);
  EXPECT_GT(report["removed_mm3_total"], 100);
  EXPECT_GT(report["contact_ticks"], 5000);
  EXPECT_EQ(report["changes"], 1);
  EXPECT_GT(report["removed_mm3"]["label-2"], 30);
  EXPECT_EQ(demo["pictures"].size(), 3u);
  // A recording is refused if another file of the demo would replace it.
  fs::create_directory(folder_ / "out2");
  for (const char* file : {"1-touch.png", "report.json"})
    EXPECT_EQ(run(std::string("demo -o out2 --no-window --record out2/") + file).exit_code, 2) << file;
}

/// SIGINT (Ctrl-C) and SIGTERM close the window like its own button: the recording is complete. The signal is
/// sent twice, since timeout(1) sends it to the process, then to its group.
TEST_F(Command, AWindowEndsInOrderOnRequest) {
  if (std::system("command -v xvfb-run >/dev/null") != 0) GTEST_SKIP() << "no xvfb-run";
  ASSERT_EQ(run("phantom shell --size 48 -o s.mha").exit_code, 0);
  for (const std::string signal : {"INT", "TERM"}) {
    const std::string session = signal + ".session";
    const std::string signal_twice = "\"$@\" & p=$!; for i in $(seq 300); do [ -s " + session +
                                     " ] && break; sleep 0.1; done; sleep 1; kill -" + signal +
                                     " $p; sleep 0.02; kill -" + signal + " $p; wait $p; echo $? > code";
    const ProcessResult r = run("view s.mha --json --embed --record " + session,
                                "xvfb-run -a -s '-screen 0 1024x768x24' sh -c '" + signal_twice + "' sh");
    ASSERT_EQ(read(file("code")), "130\n") << r.err;  // xvfb-run may return the code of its own cleanup
    EXPECT_GT(Json::parse(r.out)["servo"]["ticks"], 100);
    EXPECT_EQ(json("replay " + session + " --verify")["is_same"], true);
  }
}

TEST_F(Command, WindowOpensUnderXvfbDrawsAndCloses) {
  if (std::system("command -v xvfb-run >/dev/null") != 0) GTEST_SKIP() << "no xvfb-run";
  ASSERT_EQ(run("phantom shell --size 64 -o s.mha").exit_code, 0);
  const ProcessResult r =
      run("view s.mha --seconds 3 --screenshot w.png --json", "xvfb-run -a -s '-screen 0 1280x1024x24'");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const Json view = Json::parse(r.out);
  EXPECT_EQ(view["is_offscreen"], false);
  EXPECT_TRUE(view["frames"].is_number());  // few on a busy machine; the screenshot proves one
  EXPECT_GT(view["servo"]["ticks"], 1000);
  EXPECT_EQ(view["servo"]["faults"].get<int>() & (1 | 16 | 32), 0);
  EXPECT_GT(fs::file_size(folder_ / "w.png"), 10000u);
}

// Every command of the README's tour and of the help of seven commands runs, on smaller volumes. SCANS/HEAD
// is a small head here.
TEST_F(Command, ExamplesOfReadmeAndHelpRun) {
  fs::create_directory(folder_ / "SCANS");
  ASSERT_EQ(run("phantom head --spacing 2.5 -o head.mha").exit_code, 0);
  std::string examples = read(TREPHINE_SOURCE_DIR "/README.md");
  for (const char* name : {"phantom", "info", "import", "mesh", "touch", "drill", "view"})
    examples += run(std::string(name) + " --help").out;
  write("retractor.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n");
  write("path.csv", "t,x,y,z\n0,40,-30,90\n0.3,30,-25,50\n0.5,32,-25,50\n");
  std::istringstream lines(examples);
  int count = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t start = line.find_first_not_of(' ');
    if (start == std::string::npos || start < 2) continue;
    const bool is_bench = line.compare(start, 15, "trephine-bench ") == 0;
    if (!is_bench && line.compare(start, 9, "trephine ") != 0) continue;
    std::string arguments = line.substr(start + 9, line.find('#') - start - 9);
    if (arguments.starts_with("demo")) continue;  // has its own test
    // Replaces sizes and scans by smaller ones, which take less time.
    const auto replace = [&arguments](const std::string& from, const std::string& to) {
      for (std::size_t at = arguments.find(from); at != std::string::npos;
           at = arguments.find(from, at + to.size()))
        arguments.replace(at, from.size(), to);
    };
    replace("SCANS/HEAD", "head.mha");
    replace("docs/examples/", TREPHINE_SOURCE_DIR "/docs/examples/");
    if (!arguments.starts_with("phantom") && arguments.find("--record") == std::string::npos)
      replace(" head ", arguments.find("--label") == std::string::npos ? " head.mha " : " head ");
    replace("--spacing 0.6", "--spacing 2.5");
    replace("--size 256", "--size 64");
    if (arguments.starts_with("bench feel")) replace("--quick", "--quick --only cone");
    if (arguments.starts_with("bench stability")) arguments += " --only subvoxel --steps 20000";
    const bool has_window = arguments.starts_with("view") || arguments.starts_with("simulator");
    if (has_window && arguments.find("--screenshot") == std::string::npos)
      arguments += " --screenshot window.png";
    if (arguments.find("SESSIONS") != std::string::npos && fs::create_directory(folder_ / "SESSIONS"))
      fs::copy(folder_ / "drill.session", folder_ / "SESSIONS");
    const ProcessResult r = run(arguments);
    EXPECT_EQ(r.exit_code, 0) << line << "\n" << r.err;
    ++count;
  }
  EXPECT_GE(count, 15);
}

TEST_F(Command, AuditReportsZeroMismatches) {
  const Json audit = json("audit --count 50000 --seed 99");
  EXPECT_EQ(audit["rays"], 50000);
  EXPECT_EQ(audit["mismatches"], 0);
  EXPECT_EQ(audit["reverse_mismatches"], 0);
}

TEST_F(Command, BenchmarksHaveTheirKeys) {
  const Json surface = json("bench surface --size 64");
  EXPECT_EQ(keys_of(surface),
            with_common({"surfaces", "surface_chunk_us", "drilled_chunk_us", "drilled_chunk_vertices"}));
  ASSERT_EQ(surface["surfaces"].size(), 4u);
  for (const Json& row : surface["surfaces"]) EXPECT_GT(row["peer_over_own"], 0);
  const Json rays = json("bench rays --size 64");
  ASSERT_EQ(rays["rays"].size(), 6u);
  for (const Json& row : rays["rays"]) {
    EXPECT_EQ(row["mismatches"], 0);
    EXPECT_GT(row["hits"], 1000);
  }
  const Json load = json("bench load head");
  EXPECT_EQ(keys_of(load), with_common({"source", "voxels", "seconds", "memory", "peer_over_own"}));
  EXPECT_TRUE(load["peer_over_own"].is_null());
}

TEST_F(Command, InterruptEndsWith130AndWritesNothing) {
  ASSERT_EQ(run("phantom sphere --size 24 -o s.mha").exit_code, 0);
  write("long.csv", "t,x,y,z\n0,0,0,60\n4000,0,0,40\n");
  const ProcessResult r =
      run("touch s.mha --path long.csv -o steps.csv", "env -u DISPLAY timeout --preserve-status -s INT 1");
  EXPECT_EQ(r.exit_code, 130) << r.err;
  EXPECT_FALSE(fs::exists(folder_ / "steps.csv"));
}

}  // namespace
}  // namespace trephine::command_tests
