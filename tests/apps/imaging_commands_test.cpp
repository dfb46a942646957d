// X-rays, cross-sections, slices, measures and renderings by command: files that other programs read, poses
// that are read back from files, and errors.
#include <cmath>
#include <set>
#include <sstream>

#include "data-tools/cases/plan_file.h"
#include "data-tools/dicom/xray_file.h"
#include "tests/apps/command_fixture.h"
#include "tests/data-tools/file_helpers.h"
#include "tests/whole.h"

namespace trephine::command_tests {
namespace {

/// Returns the floats of a MetaImage.
std::vector<float> floats_of(const std::string& file) {
  const std::string marker = "ElementDataFile = LOCAL\n";
  const std::size_t at = file.find(marker);
  if (at == std::string::npos) return {};
  std::vector<float> values((file.size() - at - marker.size()) / sizeof(float));
  std::copy_n(file.data() + at + marker.size(), values.size() * sizeof(float),
              reinterpret_cast<char*>(values.data()));
  return values;
}

/// Returns a PLY file of small beads. Each bead is an octahedron, which is a closed surface.
std::string beads_ply(const std::vector<std::array<double, 3>>& middles, double radius) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\nelement vertex " << 6 * middles.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << 8 * middles.size()
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& m : middles)
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-radius, radius}) {
        for (int a = 0; a < 3; ++a)
          out << m[static_cast<std::size_t>(a)] + (a == axis ? side : 0) << (a < 2 ? ' ' : '\n');
      }
  for (std::size_t b = 0; b < middles.size(); ++b)
    for (int octant = 0; octant < 8; ++octant) {
      const std::size_t x = 6 * b + (octant & 1 ? 1 : 0), y = 6 * b + 2 + (octant & 2 ? 1 : 0),
                        z = 6 * b + 4 + (octant & 4 ? 1 : 0);
      const bool is_even = (octant & 1) + (octant >> 1 & 1) + (octant >> 2 & 1) == 1 || octant == 7;
      out << "3 " << x << ' ' << (is_even ? y : z) << ' ' << (is_even ? z : y) << '\n';
    }
  return out.str();
}

TEST_F(Command, AnXrayIsMadeAndItsPoseRoundTrips) {
  const Json report = json(
      "fluoro spine --view lateral --primary 81 --pixels 200 --isocentre 3,20,-4 "
      "-o a.png --dicom a.dcm --sums a.mha");
  EXPECT_EQ(report["c_arm"]["primary_degrees"], 81);
  EXPECT_EQ(report["c_arm"]["secondary_degrees"], 0);
  EXPECT_NEAR(report["c_arm"]["pixel_mm"].get<double>(), 0.3 * 1024 / 200, 1e-12);
  EXPECT_NEAR(report["exposure"]["kerma_mgy"].get<double>(), 0.512, 1e-9);
  EXPECT_GT(report["rays_past_the_border_in_the_body_percent"],
            10);  // the phantom ends inside the body, as a block that was cut out of a back
  EXPECT_EQ(report["plan"].size(), 12u);
  EXPECT_GT(fs::file_size(folder_ / "a.png"), 10000u);
  const auto pose = data_tools::read_xray_pose(file("a.dcm"));
  ASSERT_TRUE(pose) << pose.error().message();
  EXPECT_EQ(pose.value().columns, 200);
  EXPECT_EQ(*pose.value().isocentre, glm::dvec3(3, 20, -4));
  // With the pose of that file the image is the same. It is the same to the bit, because the decimal strings
  // of the file represent these numbers exactly.
  json("fluoro spine --pose a.dcm --sums b.mha");
  const std::vector<float> a = floats_of(read(file("a.mha"))), b = floats_of(read(file("b.mha")));
  ASSERT_EQ(a.size(), 200u * 200u);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a, b);
  // An X-ray of the surfaces, side by side with that of the volume.
  const Json side_by_side = json("fluoro spine --view ap --pixels 200 --side-by-side -o b.png");
  EXPECT_EQ(side_by_side["unbalanced_rays"], 0);
  EXPECT_GT(side_by_side["surface_against_volume"]["zncc"], 0.98);
  EXPECT_LT(side_by_side["surface_against_volume"]["mape_percent"], 8);
}

/// Five beads appear in an X-ray at the pixels that docs/examples/xray_pixel.py computes from the header of
/// its DICOM file.
TEST_F(Command, AnXraysHeaderGivesThePositionsOfBeads) {
  if (std::system("/usr/bin/python3 -c pass") != 0) GTEST_SKIP() << "no python3 for the script";
  const std::vector<std::array<double, 3>> beads{
      {0, 0, 0}, {22, -9, 14}, {-17, 21, -18}, {9, 27, 25}, {-26, -14, 6}};
  write("beads.ply", beads_ply(beads, 1.5));
  for (const std::string pose : {"--primary 67 --secondary -13 --isocentre 4,7,-2", "--view ap"}) {
    const std::string arm = "fluoro spine --pixels 400 --supersampling 3 " + pose;
    json(arm + " --sums without.mha");
    json(arm + " --mesh beads.ply --mesh-matter steel --sums with.mha --dicom with.dcm");
    std::vector<float> with = floats_of(read(file("with.mha"))),
                       without = floats_of(read(file("without.mha")));
    ASSERT_EQ(with.size(), 1200u * 1200u);
    ASSERT_EQ(with.size(), without.size());
    for (const auto& bead : beads) {
      std::ostringstream script;
      script << "/usr/bin/python3 '" << TREPHINE_SOURCE_DIR << "/docs/examples/xray_pixel.py' '"
             << file("with.dcm") << "' " << bead[0] << ',' << bead[1] << ',' << bead[2] << " > '"
             << file("pixel") << "'";
      ASSERT_EQ(std::system(script.str().c_str()), 0);
      std::istringstream output(read(file("pixel")));
      double column = 0, row = 0, x = 0, y = 0, all = 0;
      output >> column >> row;
      for (int j = 0; j < 1200; ++j)
        for (int i = 0; i < 1200; ++i) {
          const double c = (i - 1) / 3.0, r = (j - 1) / 3.0;  // in the image's pixels
          if (std::abs(c - column) > 6 || std::abs(r - row) > 6) continue;
          const auto at = static_cast<std::size_t>(i + 1200 * j);
          const double extra = static_cast<double>(with[at]) - static_cast<double>(without[at]);
          all += extra, x += c * extra, y += r * extra;
        }
      ASSERT_GT(all, 1) << column << ' ' << row;
      EXPECT_NEAR(x / all, column, 0.1) << pose;
      EXPECT_NEAR(y / all, row, 0.1) << pose;
    }
    if (!runs_all_cases()) break;
  }
}

/// Shots in a session are commands. The command fluoro repeats any of them on the state of its time.
TEST_F(Command, ShotsOfASessionAreRepeated) {
  json("phantom sphere --size 64 -o s.mha");  // opens sooner than a spine
  write("x.toml",
        "schema = 1\nscan = \"s.mha\"\nrate = 250\n"
        "[[hands]]\ninstrument = \"burr\"\nparameters = \"diameter=6 kinematic=yes\"\n"
        "points = [[0, 0, 90, 0, 0], [0.2, 0, 75, 0, 0], [0.4, 0, 68, 0, 1], [2.4, 0, 40, 0, 1], [2.6, 0, "
        "90, 0, 0]]\n"
        "[[do]]\nat = 0.1\ncommand = \"shoot\"\nrefused = true\n"
        "[[do]]\nat = 0.1\ncommand = \"c-arm\"\nwith = \"primary=90 columns=160 rows=160 pixel=2\"\n"
        "[[do]]\nat = 0.1\ncommand = \"shoot\"\n"
        "[[do]]\nat = 2.7\ncommand = \"shoot\"\nwith = \"time=0.2\"\n"
        "[[do]]\nat = 2.9\ncommand = \"undo\"\n"
        "[[expect]]\nwhat = \"X-ray shots\"\nleast = 2\nmost = 2\n"
        "[[expect]]\nwhat = \"events x-ray-taken\"\nleast = 2\n");
  const Json played = json("run x.toml --record x.session");
  EXPECT_EQ(played["is_met"], true) << played.dump(1);
  EXPECT_EQ(json("replay x.session --scan s.mha --verify")["is_same"], true);
  if (runs_all_cases()) {
    EXPECT_NE(run("timeline x.session").out.find("X-ray"), std::string::npos);
  }
  const auto sums = [&](const std::string& options) {
    json("fluoro x.session --scan s.mha --sums sums.mha " + options);
    return floats_of(read(file("sums.mha")));
  };
  const std::vector<float> before = sums("--shot 1"), drilled = sums("--shot 2");
  ASSERT_EQ(before.size(), 160u * 160u);
  if (runs_all_cases()) {
    EXPECT_EQ(before, sums("")) << "the undo restored the matter";
  }
  double most = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_GE(before[i], drilled[i] - 1e-5f);  // matter was removed
    most = std::max(most, static_cast<double>(before[i]) - static_cast<double>(drilled[i]));
  }
  EXPECT_GT(most, 0.05);
  EXPECT_NE(run("fluoro x.session --scan s.mha --shot 3").err.find("1 to 2"), std::string::npos);
}

/// docs/examples/c-arm-tour.toml: one of two screws is too far medial, which the section measures.
TEST_F(Command, ACArmGoesAroundTwoScrews) {
  write("t.toml", read(TREPHINE_SOURCE_DIR "/docs/examples/c-arm-tour.toml"));
  const Json played = json("run t.toml --record t.session");
  EXPECT_EQ(played["is_met"], true) << played.dump(1);
  const Json shot = json("fluoro t.session --shot 3 --pixels 128 -o shot.png");
  EXPECT_NEAR(shot["exposure"]["area_product_mgy_cm2"].get<double>(), 102.2,
              3);  // the open field consists of whole pixels
  EXPECT_GT(fs::file_size(folder_ / "shot.png"), 5000u);
  const std::string plane = " --at 0,22,5.8 --normal 0,0.05,-1 --pixel 0.1 ";
  const Json section = json("section t.session" + plane + "-o s.png --svg s.svg");
  ASSERT_EQ(section["objects"].size(), 6u);  // bone, forbidden structures of the plan, two screws
  const std::string drawn = read(file("s.svg"));
  EXPECT_NE(drawn.find("<title>bone, "), std::string::npos);
  std::set<std::string> colours;
  for (std::size_t at = 0; (at = drawn.find("fill=\"", at)) != std::string::npos; ++at)
    colours.insert(drawn.substr(at + 6, 7));
  EXPECT_EQ(colours.size(), 5u);  // one colour per object; no nerve root is in the plane
  // Heads of the session's screws do not count as outside bone.
  EXPECT_GT(section["models_outside_bone_mm2"], 25);
  EXPECT_LT(section["models_outside_bone_mm2"], 60);
  ASSERT_EQ(section["screws"].size(), 2u);
  EXPECT_LT(section["screws"][0]["breach_mm"], 0.5);
  EXPECT_GT(section["screws"][1]["breach_mm"], 3);
  EXPECT_EQ(section["screws"][1]["toward"], "the patient's right");
  if (!runs_all_cases()) return;
  // The part of a screw beyond the picture is reported.
  const Json narrow = json("section spine --screw=-18.8,37.8,6.6:-6.5,-9.5,4.1:6.5 --width 40" + plane);
  EXPECT_GT(narrow["models_beyond_picture_mm2"], 100);
  // The planned screw is in bone except for its head, which does not count; the screw on the left side
  // reaches into the canal.
  const Json planned = json("section spine --screw=-18.8,37.8,6.6:-6.5,-9.5,4.1:6.5" + plane);
  const Json wrong = json("section spine --screw=15.8,37.8,6.6:-3.5,-5.5,4.1:6.5" + plane);
  EXPECT_LT(planned["models_outside_bone_mm2"], 5);
  EXPECT_GT(wrong["models_outside_bone_mm2"], 25);
  EXPECT_LT(planned["screws"][0]["breach_mm"], 0.5);
  EXPECT_GT(wrong["screws"][0]["breach_mm"], 3);
  EXPECT_EQ(wrong["screws"][0]["toward"], "the patient's right");
  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"--at 0,0,500", "does not intersect the scan"},
           {"--normal 0,0,0", "looks nowhere"},
           {"--pixel 0", "out of range"},
           {"--screw 1,2,3", "no screw"},
           {"--trajectory nowhere", "L4 left pedicle"}}) {
    const ProcessResult bad = run("section spine " + arguments);
    EXPECT_EQ(bad.exit_code, 2) << arguments;
    EXPECT_NE(bad.err.find(words), std::string::npos) << arguments << "\n" << bad.err;
    if (!runs_all_cases()) break;
  }
}

/// A slab along a planned trajectory; a slice before and after a cut, with the value at a position; errors.
TEST_F(Command, ASliceShowsTheScanBeforeAndAfterACut) {
  const Json slab =
      json("slice spine --plane sagittal --trajectory 'L4 left pedicle' --slab 4 --pixel 0.5 -o a.png");
  EXPECT_EQ(slab["plane"]["slab_mm"], 4);
  EXPECT_GT(fs::file_size(folder_ / "a.png"), 20000u);
  json("phantom sphere --size 64 -o s.mha");
  write("d.toml",
        "schema = 1\nscan = \"s.mha\"\nrate = 250\n[[hands]]\ninstrument = \"burr\"\nparameters = "
        "\"diameter=6 kinematic=yes\"\n"
        "points = [[0, 0, 90, 0, 0], [0.2, 0, 75, 0, 0], [0.4, 0, 68, 0, 1], [2.4, 0, 40, 0, 1]]\n");
  json("run d.toml --record d.session");
  const Json cut = json(
      "slice d.session --scan s.mha --plane axial --at 0,43,0 --pixel 0.5 --side-by-side --probe 0,43,0 -o "
      "b.png");
  EXPECT_GT(cut["probe"]["before"], 100);
  EXPECT_EQ(cut["probe"]["now"], -1000);
  if (runs_all_cases()) {
    EXPECT_EQ(
        json("slice d.session --scan s.mha --until 0.3 --at 0,43,0 --probe 0,43,0 --pixel 1")["probe"]["now"],
        cut["probe"]["before"]);
  }
  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"--level 40", "invalid grey window"},
           {"--probe 0,0,900", "outside the scan"},
           {"--slab -1", "out of range"},
           {"--at 0,0,900", "does not intersect the scan"}}) {
    const ProcessResult bad = run("slice s.mha --pixel 1 " + arguments);
    EXPECT_EQ(bad.exit_code, 2) << arguments;
    EXPECT_NE(bad.err.find(words), std::string::npos) << arguments << "\n" << bad.err;
    if (!runs_all_cases()) break;
  }
}

/// Rulers, angles, tapes and regions are measured, and their markups can be read as a plan.
TEST_F(Command, MeasuresAreReportedAndKept) {
  const Json report = json(
      "measure head --ruler 0,0,0:3,4,12 --angle 5,0,0:0,0,0:0,0,9 --tape 0,-88,20:74,0,40 --region "
      "0,0,5:6 "
      "--markups m.mrk.json");
  ASSERT_EQ(report["measures"].size(), 4u);
  EXPECT_NEAR(report["measures"][0]["length_mm"].get<double>(), 13, 1e-9);
  EXPECT_NEAR(report["measures"][1]["angle_degrees"].get<double>(), 90, 1e-6);
  const Json& tape = report["measures"][2];
  EXPECT_GT(tape["length_mm"].get<double>(), tape["straight_mm"].get<double>() + 5);
  EXPECT_GT(tape["moved_mm"], 1);
  EXPECT_LT(tape["moved_mm"], 25);
  if (runs_all_cases()) {
    EXPECT_NE(run("measure head --tape 5000,0,0:0,-125,20").out.find("from the surface"), std::string::npos);
  }
  EXPECT_LE(tape["taut_mm"].get<double>(), tape["length_mm"].get<double>());
  EXPECT_NEAR(report["measures"][3]["mean"].get<double>(), 27, 5);  // brain
  const auto plan = data_tools::read_plan(file("m.mrk.json"));
  ASSERT_TRUE(plan) << plan.error().message();
  ASSERT_GE(plan.value().trajectories.size(), 1u);
  EXPECT_EQ(plan.value().trajectories[0].target_world, glm::dvec3(3, 4, 12));
  // In a session a measurement is a job. A script can expect its result, and the session is replayed.
  write("m.toml",
        "schema = 1\nscan = \"head\"\nrate = 250\n[[hands]]\npoints = [[0, 0, 0, 150], [0.2, 0, 0, 150]]\n"
        "[[do]]\nat = 0.1\ncommand = \"measure\"\nwith = \"kind=tape at=0,-88,20;74,0,40\"\n"
        "[[expect]]\nwhat = \"measured length\"\nleast = 112\nmost = 125\n");
  EXPECT_EQ(json("run m.toml --record m.session")["is_met"], true);
  if (runs_all_cases()) {
    EXPECT_EQ(json("replay m.session --verify")["is_same"], true);
  }
  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"", "no measurement requested"},
           {"--ruler 0,0,0", "wrong number of positions"},
           {"--region 0,0,0:x", "invalid radius"},
           {"--tape 0,0:1,1,1", "X,Y,Z"}}) {
    const ProcessResult bad = run("measure head " + arguments);
    EXPECT_EQ(bad.exit_code, 2) << arguments;
    EXPECT_NE(bad.err.find(words), std::string::npos) << arguments << "\n" << bad.err;
  }
  if (runs_all_cases()) {
    EXPECT_EQ(run("measure head --region 0,0,900:5").exit_code, 1);
  }
}

TEST_F(Command, InvalidXraysAreRefused) {
  write("open.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n");
  write("no.dcm", "nothing");
  std::string inward = beads_ply({{0, 0, 0}}, 3);
  for (std::size_t at = inward.find("\n3 "); at != std::string::npos; at = inward.find("\n3 ", at + 1))
    std::swap(inward[at + 5], inward[at + 7]);
  write("inward.ply", inward);
  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"spine --view sideways", "sideways"},
           {"spine --to-patient 1200", "between source and detector"},
           {"spine --isocentre 1000,0,0", "no ray intersects the scan"},
           {"spine --mesh inward.ply", "face inward"},
           {"spine --sums a.txt", "wrong extension"},
           {"spine --energy 500", "out of range"},
           {"spine --collimate 10", "invalid field"},
           {"spine --isocentre 1,2", "X,Y,Z"},
           {"spine --mesh open.ply", "3 open edges"},
           {"spine --pose no.dcm", "no X-ray image"},
           {"spine --shot 1", "no shots"},
           {"spine --until 3", "no time"},
           {"spine --primary nan", "primary"},
           {"spine --size 9000", "out of range"},
           {"spine --dicom open.ply --mesh open.ply", "open.ply"}}) {
    const ProcessResult bad = run("fluoro " + arguments);
    EXPECT_EQ(bad.exit_code, 2) << arguments;
    EXPECT_NE(bad.err.find(words), std::string::npos) << arguments << "\n" << bad.err;
    if (!runs_all_cases() && arguments == "spine --energy 500") break;
  }
  EXPECT_EQ(leftovers({"open.ply", "no.dcm", "inward.ply"}), "");
}

/// Breach and side of the breach, for screws near the face of a block and through a cavity, and a screw that
/// meets no bone.
TEST_F(Command, ABreachIsMeasuredWithItsSide) {
  write("block.nrrd", nrrd(40, [](int x, int y, int z) {
          const bool is_block = std::min({x, y, z}) >= 8 && x < 24 && y < 30 && z < 32;
          return is_block && !(z >= 18 && z < 22 && y < 16) ? 800 : -1000;
        }));
  const double face = 23 + 500.0 / 1800;  // x of the threshold of 300 HU between voxels of 800 and -1000 HU
  const auto breach = [&](const std::string& screw) {
    return json("section block.nrrd --at 16,20,20 --screw=" + screw)["screws"][0];
  };
  for (const double x : {19.0, 20.5, 21.5, 23.0}) {
    const Json one = breach(std::to_string(x) + ",24,36:" + std::to_string(x) + ",24,10:6");
    EXPECT_NEAR(one["breach_mm"].get<double>(), std::max(0.0, x + 3 - face), 0.1) << x;
    EXPECT_EQ(one.value("toward", ""), x + 3 > face + 0.1 ? "the patient's left" : "") << x;
  }
  const Json front = breach("16,10,36:16,10,10:6");
  EXPECT_NEAR(front["breach_mm"].get<double>(), 15 + 1300.0 / 1800 - 10 + 3, 0.15)
      << "from the back wall of the cavity to the front of the screw";
  EXPECT_NEAR(front["from_entry_mm"].get<double>(), 16, 2.5);
  EXPECT_EQ(front["toward"], "the front");
  EXPECT_EQ(breach("35,35,36:35,35,10:6")["meets_bone"], false);
}

/// A real lumbar spine with slices of 3 mm. The left screw passes through its pedicle, and the right screw
/// through the canal, on purpose.
TEST_F(Command, OnARealSpineTheWrongScrewIsDetected) {
  if (data_tools::real_data().empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  const std::string spine = data_tools::real_data() + "/spine_lumbar/example_ct.nii.gz";
  const char *correct = "23.3,-109.6,318:12.6,-140,318:5.5", *wrong = "-12,-106,318:4,-136,318:5.5";
  const auto outside = [&](const char* screw) {
    return json("section " + spine + " --iso 90 --at -3.5,-115,318 --width 110 --screw=" + screw +
                " -o s.png")["models_outside_bone_mm2"]
        .get<double>();
  };
  EXPECT_LT(outside(correct), 30);
  EXPECT_GT(outside(wrong), 40);
  // Both screws are metal in an X-ray. The commands slice and render accept them, too.
  const std::string both = spine + " --screw=" + correct + " --screw=" + wrong;
  EXPECT_EQ(run("fluoro " + both + " --isocentre -3.5,-125,318 --pixels 200 -o x.png --sums x.mha").exit_code,
            0);
  EXPECT_EQ(run("fluoro " + spine + " --isocentre -3.5,-125,318 --pixels 200 --sums y.mha").exit_code, 0);
  const std::vector<float> with = floats_of(read(file("x.mha"))), without = floats_of(read(file("y.mha")));
  ASSERT_EQ(with.size(), 40000u);
  int changed = 0;
  for (std::size_t i = 0; i < with.size(); ++i) changed += with[i] > without[i] + 0.1F;
  EXPECT_GT(changed, 60);
  EXPECT_LT(changed, 2000);
  EXPECT_EQ(run("slice " + both + " --at -3.5,-115,318 --width 100 -o sl.png").exit_code, 0);
  EXPECT_EQ(run("render " + both + " --pixels 200 --from back -o r.png").exit_code, 0);
}

/// With labels, cancellous bone counts as bone, and a textbook screw is inside the vertebra. By a threshold
/// alone, more than 60 mm² of its shaft are outside bone.
TEST_F(Command, ATextbookScrewIsInsideBone) {
  if (data_tools::real_data().empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  const std::string folder = data_tools::real_data() + "/spine_lumbar/";
  ASSERT_EQ(run("import " + folder + "example_ct.nii.gz --labels " + folder +
                "spine_report/totalseg.nii.gz --preset spine -o lumbar")
                .exit_code,
            0);
  const std::string screw = " --screw=25,-113,285:6,-146,285:6 --at 15,-130,285 --plane axial --width 120";
  const Json by_labels = json("section lumbar" + screw);
  EXPECT_NEAR(by_labels["models_mm2"].get<double>(), 264, 3);
  EXPECT_LT(by_labels["models_outside_bone_mm2"], 1);
  EXPECT_LT(by_labels["screws"][0]["breach_mm"], 0.1);
  const Json by_window = json("section " + folder + "example_ct.nii.gz --iso 150" + screw);
  EXPECT_GT(by_window["models_outside_bone_mm2"], 60) << "without the head";
}

/// docs/examples/tumour.toml: slices and model agree, and measures of the session are exported as markups.
TEST_F(Command, ATumourIsMeasuredOnSlicesAndOnItsModel) {
  write("t.toml", read(TREPHINE_SOURCE_DIR "/docs/examples/tumour.toml"));
  EXPECT_EQ(json("run t.toml --record t.session")["is_met"], true);
  const Json report = json("measure t.session --markups t.mrk.json");
  ASSERT_EQ(report["measures"].size(), 3u);
  EXPECT_EQ(report["measures"][2]["kind"], "part");
  const auto plan = data_tools::read_plan(file("t.mrk.json"));
  ASSERT_TRUE(plan) << plan.error().message();
  if (!runs_all_cases()) return;
  // The command measures the same volume of the part as the session.
  const Json part = json(
      "measure head --label tumour --part -37,14,37:25 --region -37,14,37:25 --patch "
      "\"-37,1.6,42:-32,1.6,36:-42,1.6,36\"");
  EXPECT_NEAR(part["measures"][2]["size_mm3"].get<double>(), report["measures"][2]["size_mm3"].get<double>(),
              1);
  EXPECT_GT(part["measures"][1]["area_mm2"], 30);
  EXPECT_EQ(run("measure head --label tumour --part -37,14,37:5").exit_code, 1);
}

TEST_F(Command, AScanIsRenderedByRayCasting) {
  const Json bone = json("render spine --from back --pixels 160 -o a.png");
  EXPECT_GT(fs::file_size(folder_ / "a.png"), 5000u);
  EXPECT_NEAR(bone["window"]["low"].get<double>(), 160 + 0.1 / 0.55 * 160, 1);
  EXPECT_TRUE(bone["window"]["high"].is_null());
  // These options reduce the number of samples: fewer samples per ray, and no samples of matter that is
  // clipped, hidden, cut out or behind a screw.
  const double whole = bone["samples"].get<double>();
  EXPECT_LT(json("render spine --from back --pixels 160 --samples 200 --hide L4 --clip 0,0,0:0,1,0 --cutout "
                 "\"L4 left "
                 "pedicle\" --screw 15,40,6:-3,-5,4:6.5")["samples"]
                .get<double>(),
            0.6 * whole);
  // MR has no Hounsfield units: the default transfer function has three points, and the user may pass
  // opacities.
  std::string mr =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      "ElementSpacing = 1 1 2\n"
      "DimSize = 16 16 16\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
  for (int i = 0; i < 16 * 16 * 16; ++i) mr += static_cast<char>(i % 16 > 3 && i % 16 < 12 ? 90 + i % 7 : 3);
  write("mr.mha", mr);
  EXPECT_EQ(json("render mr.mha --pixels 64")["transfer_function"].size(), 3u);
  const Json own = json("render mr.mha --pixels 64 --opacity=-40:0,-20:0.4,0:0.4,100:0");
  EXPECT_NEAR(own["window"]["low"].get<double>(), -35, 1);
  EXPECT_NEAR(own["window"]["high"].get<double>(), 75, 1);
  EXPECT_NE(run("render mr.mha --transfer-function bone").err.find("--transfer-function grey"),
            std::string::npos);
  for (const char* bad : {"--transfer-function gold", "--opacity 5", "--opacity 5:0,4:1", "--opacity 5:2",
                          "--opacity '5:0;6:1'", "--size 9", "--size 5000", "--slices 3", "--clip 1,2,3",
                          "--clip 0,0,0:0,0,0", "--cutout nowhere", "--hide nothing", "--translucent nothing",
                          "--share 2", "--cutout-radius 0", "--from nowhere", "-o spine.txt"})
    EXPECT_EQ(run(std::string("render mr.mha --pixels 64 ") + bad).exit_code, 2) << bad;
}

}  // namespace
}  // namespace trephine::command_tests
