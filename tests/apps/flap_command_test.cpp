// The command flap and scripts that cut bone flaps: on the built-in head, on a real head, and on a scan of a
// plastic skull.
#include <cmath>

#include "data-tools/formats/open_volume.h"
#include "tests/apps/command_fixture.h"
#include "tests/data-tools/file_helpers.h"
#include "tests/whole.h"

namespace trephine::command_tests {
namespace {

double distance_to(const Json& p, double x, double y, double z) {
  return std::hypot(p[0].get<double>() - x, p[1].get<double>() - y, p[2].get<double>() - z);
}

TEST_F(Command, AFlapIsSawnLiftedRecordedAndReplayed) {
  ASSERT_EQ(run("phantom head --spacing 1.6 --case h").exit_code, 0);
  const Json flap = json(
      "flap h --at=-30,-25,70 --diameter 40 --saw 2.4 --lift 30 --target tumour -o open.mha "
      "--flap flap.stl --screenshot flap.png --record f.session");
  EXPECT_EQ(flap["holes"], 0);
  ASSERT_EQ(flap["pieces"].size(), 1u);
  EXPECT_NEAR(flap["area_mm2"].get<double>(), 0.780 * 40 * 40 * 1.03, 80);  // 32 corners, on a curved surface
  EXPECT_NEAR(flap["kerf_mm3"].get<double>() / (2.4 * flap["walls_mm2"].get<double>()), 1, 0.02);
  EXPECT_GT(flap["target"]["depth_mm"], 5);
  EXPECT_GE(flap["target"]["covered_share"], 0);
  EXPECT_GT(flap["outline"]["roundness"], 0.9);
  ASSERT_FALSE(flap["forbidden"].empty());
  EXPECT_EQ(flap["forbidden"][0]["structure"], "dura");
  EXPECT_EQ(flap["forbidden"][0]["is_stripped"], true) << "the saw's foot strips the dura off the bone";
  EXPECT_GT(fs::file_size(folder_ / "flap.stl"), 10000u);
  EXPECT_GT(fs::file_size(folder_ / "flap.png"), 20000u);
  const Json again = json("replay f.session --scan h --verify -o again.mha");
  EXPECT_EQ(again["is_same"], true);
  EXPECT_EQ(again["content_hash"], flap["content_hash"]);
  EXPECT_EQ(read(file("again.mha")), read(file("open.mha")));
  const std::string timeline = run("timeline f.session").out;
  EXPECT_NE(timeline.find("Bone flap of"), std::string::npos);
  EXPECT_NE(timeline.find("The dura was pushed aside"), std::string::npos) << timeline;
  EXPECT_EQ(timeline.find("The tool tore"), std::string::npos) << timeline;
  EXPECT_NE(timeline.find("place-body"), std::string::npos);
  // The flap was cut before the first tick. The first state of the comparison is the uncut scan.
  const Json compared = json("compare f.session --scan h");
  EXPECT_GT(compared["only_in_first_mm3"], flap["kerf_mm3"].get<double>());
  EXPECT_EQ(compared["first"], "uncut");

  // The outline is read from a CSV file and from the plan of a case. The planned outline is a file of 3D
  // Slicer, in RAS. The flap is compared with its own outline, and a moved flap with the same outline.
  std::string csv = "name,x,y,z\n", slicer = R"({"markups":[{"type":"ClosedCurve","coordinateSystem":"RAS",)"
                                             R"("controlPoints":[)";
  for (std::size_t i = 0; i < flap["anchors_world_mm"].size(); ++i) {
    const Json& p = flap["anchors_world_mm"][i];
    csv += "flap " + std::to_string(i + 1) + "," + p[0].dump() + "," + p[1].dump() + "," + p[2].dump() + "\n";
    slicer += std::string(i ? "," : "") + "{\"label\":\"\",\"position\":[" +
              std::to_string(-p[0].get<double>()) + "," + std::to_string(-p[1].get<double>()) + "," +
              std::to_string(p[2].get<double>()) + "]}";
  }
  write("o.csv", csv);
  write("o.mrk.json", slicer + "]}]}");
  if (!runs_all_cases()) return;
  const Json by_file = json("flap h --anchors o.csv --saw 2.4 --planned o.mrk.json");
  EXPECT_EQ(by_file["flap_mm3"], flap["flap_mm3"]);
  EXPECT_LT(by_file["planned"]["worst_mm"], 0.01);
  const Json moved = json("flap h --at=-27,-25,70 --diameter 40 --saw 2.4 --planned o.mrk.json");
  EXPECT_GT(moved["planned"]["worst_mm"], 1);
  EXPECT_LT(moved["planned"]["mean_mm"], 4);
  ASSERT_EQ(run("phantom head --spacing 1.6 -o s.mha").exit_code, 0);
  ASSERT_EQ(run("import s.mha --plan o.csv -o planned").exit_code, 0);
  EXPECT_NEAR(json("flap planned --landmarks flap --saw 2.4")["flap_mm3"].get<double>(),
              flap["flap_mm3"].get<double>(), 1);
}

TEST_F(Command, AnInvalidFlapIsReportedAndDrawn) {
  ASSERT_EQ(run("phantom head --spacing 1.6 -o s.mha").exit_code, 0);
  // The bone is thicker than the limit of 3 mm.
  const ProcessResult none =
      run("flap s.mha --at=-30,-25,70 --diameter 50 --saw 2.4 --thickest 3 -o open.mha --screenshot why.png "
          "--json");
  EXPECT_EQ(none.exit_code, 1);
  const Json report = Json::parse(none.out);
  EXPECT_FALSE(report["refused"]["reason"].get<std::string>().empty());
  EXPECT_LT(distance_to(report["refused"]["position_world_mm"], -30, -25, 70), 40);
  EXPECT_FALSE(fs::exists(folder_ / "open.mha"));
  EXPECT_GT(fs::file_size(folder_ / "why.png"), 20000u);
  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"", "--anchors, --landmarks, --at"},
           {"--at 1,2,3 --landmarks flap", "more than one outline"},
           {"--at 1,2", "X,Y,Z"},
           {"--at 0,0,300", "no bone near"},
           {"--at 0,0,80 --diameter 500", "10 to 200"},
           {"--at 0,0,80 --corners 2", "3 to 100"},
           {"--at 0,0,80 --saw 0.7", "0.8"},
           {"--at 0,0,80 --distance 5", "20"},
           {"--at 0,0,80 --leave none", "number of a piece"},
           {"--at 0,0,80 --leave 2x", "number of a piece"},
           {"--at 0,0,80 --leave 4294967297", "number of a piece"},
           {"--landmarks flap", "no landmarks with this prefix"},
           {"--anchors nowhere.csv", "nowhere.csv"},
           {"--at=-30,-25,70 --diameter 40 --saw 2.4 --target brian", "unknown label"},
           {"--at=-30,-25,70 --diameter 40 --saw 0.8 --smallest-burr 30", "too narrow"}}) {
    SCOPED_TRACE(arguments);
    const ProcessResult ended = run("flap s.mha " + arguments);
    EXPECT_EQ(ended.exit_code, 2);
    EXPECT_NE(ended.err.find(words), std::string::npos) << ended.err;
  }
}

/// A flap of docs/examples that is cut without an outline, by a burr that a hand moves.
TEST_F(Command, AFlapCutByHandIsDetachedAutomatically) {
  write("f.toml", read(TREPHINE_SOURCE_DIR "/docs/examples/free-hand-flap.toml"));
  const Json played = json("run f.toml --record f.session");
  EXPECT_EQ(played["is_met"], true) << played.dump(1);
  EXPECT_EQ(json("replay f.session --verify")["is_same"], true);
  if (!runs_all_cases()) return;
  const std::string timeline = run("timeline f.session").out;
  EXPECT_NE(timeline.find("free-pieces"), std::string::npos);
  EXPECT_EQ(timeline.find("job-discarded"), std::string::npos);
  // Without `free_pieces` the flap is not detached.
  std::string script = read(file("f.toml"));
  script.erase(script.find("free_pieces = 100"), 17);
  write("g.toml", script);
  const ProcessResult left = run("run g.toml");
  EXPECT_NE(left.exit_code, 0);
  EXPECT_NE(left.out.find("bodies"), std::string::npos);
}

/// A flap of docs/examples that is cut without an outline, by a craniotome.
TEST_F(Command, AFlapCutByACraniotomeIsDetachedAutomatically) {
  if (!runs_all_cases()) GTEST_SKIP() << "set TREPHINE_WHOLE; Craniotome.JoinsBurrHoles* tests a small vault";
  write("f.toml", read(TREPHINE_SOURCE_DIR "/docs/examples/craniotome-flap.toml"));
  EXPECT_EQ(json("run f.toml --record f.session")["is_met"], true);
  EXPECT_EQ(json("replay f.session --verify")["is_same"], true);
}

/// The craniotomy of docs/examples on a coarser head. A perforator drills a hole, and an invalid outline is
/// refused. A flap is cut on a branch of its own, grasped, lifted and put back. Then the script switches to
/// the first branch.
TEST_F(Command, ACraniotomyIsPlayedBranchedAndReplayed) {
  ASSERT_EQ(run("phantom head --spacing 1.6 -o s.mha").exit_code, 0);
  std::string script = read(TREPHINE_SOURCE_DIR "/docs/examples/craniotomy.toml");
  const auto change = [&script](const std::string& from, const std::string& to) {
    for (std::size_t at = script.find(from); at != std::string::npos; at = script.find(from, at + to.size()))
      script.replace(at, from.size(), to);
  };
  change("scan = \"head\"", "scan = \"s.mha\"");
  change("saw=1.6", "saw=2.4");
  write("c.toml", script);
  const Json played = json("run c.toml --record c.session --pictures p");
  EXPECT_EQ(played["is_met"], true) << played.dump(1);
  EXPECT_GT(fs::file_size(folder_ / "p/flap.png"), 20000u);
  const Json again = json("replay c.session --scan s.mha --verify");
  EXPECT_EQ(again["is_same"], true);
  EXPECT_EQ(again["branches"], Json({"main", "flap"}));
  EXPECT_GT(again["history_bytes"], 100000);
  const Json timeline = json("timeline c.session");
  EXPECT_EQ(timeline["branches"], Json({"flap", "main"}));
  // The state at 10.3 s is on the branch `flap`, and the end is on `main`. They differ by the flap and its
  // kerf.
  const Json differs = json("compare c.session --scan s.mha --time 10.3 -o both.png");
  EXPECT_EQ(differs["only_in_first_mm3"], 0);
  EXPECT_GT(differs["only_in_second_mm3"], 3000);
  EXPECT_GT(fs::file_size(folder_ / "both.png"), 50000u);
  if (!runs_all_cases()) return;
  // The session is replayed to 10.3 s, where its branch is `flap` and the hand holds the flap.
  const Json lifted = json("replay c.session --scan s.mha --until 10.3");
  EXPECT_EQ(lifted["branches"], Json({"flap", "main"}));
  const Json back = json("compare c.session --scan s.mha --time 8.2 --with 10.3");
  EXPECT_NEAR(back["only_in_first_mm3"].get<double>(), differs["only_in_second_mm3"].get<double>(), 1e-6);
  const Json hole = json("compare c.session --scan s.mha --time 0 --with 8.2");
  EXPECT_NEAR(hole["only_in_first_mm3"].get<double>() /
                  json("replay c.session --scan s.mha --until 8.2")["removed_mm3_total"].get<double>(),
              1, 0.01);
  EXPECT_EQ(json("compare c.session --scan s.mha --time 9 --with 9")["only_in_first_mm3"], 0);
  std::set<std::string> branches;
  for (const Json& row : timeline["rows"]) branches.insert(row.value("branch", ""));
  EXPECT_TRUE(branches.contains("main") && branches.contains("flap"));
  const std::string text = run("timeline c.session").out;
  EXPECT_NE(text.find("[flap] hold-body"), std::string::npos);
  EXPECT_NE(text.find("No bone flap: the outline crosses itself"), std::string::npos);
  EXPECT_NE(text.find(" ..."), std::string::npos) << "long lists are shortened";

  // Unknown script positions are refused before the scan is opened.
  change("anchors={a};{b}", "anchors={a};{nowhere}");
  write("n.toml", script);
  const ProcessResult unknown = run("run n.toml");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("{nowhere}"), std::string::npos) << unknown.err;
  change("{nowhere}", "{b 1,2}");
  write("n.toml", script);
  EXPECT_NE(run("run n.toml").err.find("{b 1,2}"), std::string::npos);
}

/// A real head at 0.6 mm: the perforator passes both tables and the diploe between them, and stops by itself.
TEST_F(Command, ABurrHoleInARealHead) {
  const std::string data = data_tools::real_data();
  if (data.empty() || !runs_all_cases()) GTEST_SKIP() << "set TREPHINE_WHOLE and TREPHINE_DATA";
  ASSERT_EQ(
      run("convert " + data + "/head_real/pcir_head_0.6mm.dicom.tar.xz --padding-to-air -o h.mha").exit_code,
      0);
  write("p.toml", R"(schema = 1
scan = "h.mha"
rate = 250
[[places]]
name = "side"
from = [[1, -0.2, 0.55]]
[[hands]]
instrument = "perforator"
place = "side"
stiffness = 0.5
shaft = [0, 0, 1]
points = [[0, 0, 0, 15, 0], [0.2, 0, 0, 7, 0], [0.21, 0, 0, 6, 1], [0.6, 0, 0, -12, 1], [9.6, 0, 0, -40, 1],
          [9.61, 0, 0, -10, 0], [10, 0, 0, 30, 0]]
[[expect]]
what = "events perforator-stopped"
least = 1
most = 1
[[expect]]
what = "thickness_mm side"
least = 6
most = 8
[[expect]]
what = "removed_mm3"
least = 550
most = 750
)");
  const Json played = json("run p.toml --record p.session");
  EXPECT_EQ(played["is_met"], true) << played.dump(1);
  EXPECT_EQ(json("replay p.session --scan h.mha --verify")["is_same"], true);
  const Json timeline = json("timeline p.session");
  bool has_stopped = false;
  for (const Json& row : timeline["rows"])
    has_stopped = has_stopped || row.dump().find("perforator stopped after 5.8") != std::string::npos;
  EXPECT_TRUE(has_stopped) << timeline.dump(1);
}

/// A plastic skull with its cap sawn off: a seam runs around the vault.
TEST_F(Command, FlapsOfAPlasticSkull) {
  const std::string data = data_tools::real_data();
  if (data.empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  ASSERT_EQ(run("convert " + data + "/skull_phantom/bone_1mm.dicom.tar.xz -o skull.mha").exit_code, 0);
  // A flap on the cap is one piece.
  const Json cap = json("flap skull.mha --at 0,100,830 --diameter 60");
  EXPECT_EQ(cap["pieces"].size(), 1u);
  EXPECT_EQ(cap["holes"], 0);
  // A flap across the seam on the left consists of two pieces: the first is of the cap, the second of the
  // rest of the skull. --leave 2 leaves the second piece in place.
  const Json seam = json("flap skull.mha --at 62,80,772 --diameter 44 --leave 2");
  ASSERT_EQ(seam["pieces"].size(), 2u);
  EXPECT_GT(seam["pieces"][0]["position_world_mm"][2], seam["pieces"][1]["position_world_mm"][2]);
  EXPECT_EQ(seam["pieces"][1]["is_detached"], false);
  // Near the orbital rim, removed matter is close to the axis of the flap and does not reach the roof of the
  // orbit.
  const Json rim = json("flap skull.mha --at=-30,20,758 --diameter 26 -o rim.mha");
  const volume::Volume before = data_tools::open_volume(file("skull.mha")).value().volume;
  const volume::Volume after = data_tools::open_volume(file("rim.mha")).value().volume;
  const Json &apex = rim["apex_world_mm"], &middle = rim["middle_world_mm"];
  const auto vec = [](const Json& p) { return glm::dvec3(p[0], p[1], p[2]); };
  const glm::dvec3 axis = glm::normalize(vec(middle) - vec(apex));
  double widest = 0, deepest = 0;
  std::size_t gone = 0;
  for (std::size_t i = 0; i < before.voxels.size(); ++i) {
    if (!(before.voxels[i] >= 300 && after.voxels[i] < 300)) continue;
    ++gone;
    const auto x = static_cast<int>(i) % before.size.x,
               y = static_cast<int>(i) / before.size.x % before.size.y,
               z = static_cast<int>(i) / (before.size.x * before.size.y);
    const glm::dvec3 w = before.frame.world_from_volume({x, y, z}) - vec(middle);
    const double along = glm::dot(w, axis);
    deepest = std::max(deepest, -along);
    widest = std::max(widest, glm::length(w - along * axis));
  }
  EXPECT_GT(gone, 5000u);
  EXPECT_LT(widest, 13 + 0.8 + 1.5);
  EXPECT_LT(deepest, 16);  // the roof of the orbit is farther
}

}  // namespace
}  // namespace trephine::command_tests
