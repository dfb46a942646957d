// Plans and segmentations of other programs: their frames are honoured, and missing facts are requested.
#include "data-tools/cases/plan_file.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/dicom_files.h"
#include "apps/bench/scenes/scratch.h"
#include "data-tools/cases/label_file.h"
#include "data-tools/cases/phantom_cases.h"
#include "data-tools/cases/script_file.h"
#include "data-tools/phantoms/head_phantom.h"

namespace trephine::data_tools {
namespace {

class Plans : public ::testing::Test {
 protected:
  Result<PlanFile> read(const std::string& name, const std::string& text) const {
    std::ofstream(scratch_ / name, std::ios::binary) << text;
    return read_plan(scratch_ / name);
  }
  void expect_refused(const std::string& name, const std::string& text, const std::string& word) const {
    const auto plan = read(name, text);
    ASSERT_FALSE(plan.is_ok()) << word;
    EXPECT_NE(plan.error().message().find(word), std::string::npos) << plan.error().message();
    EXPECT_FALSE(plan.error().remedy.empty());
  }
  scenes::Scratch scratch_;
};

/// Returns a line and a list of points as 3D Slicer 5.6 saves them.
std::string markups(const std::string& frame) {
  const std::string place = "\"coordinateSystem\": \"" + frame + "\", \"coordinateUnits\": \"mm\"";
  return "{\"@schema\": \"https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/"
         "Resources/Schema/markups-schema-v1.0.3.json#\", \"markups\": [{\"type\": \"Line\", " +
         place +
         ", \"controlPoints\": [{\"id\": \"1\", \"label\": \"L3 left-1\", \"position\": [10.5, -20.25, 30], "
         "\"positionStatus\": \"defined\"}, {\"id\": \"2\", \"label\": \"L3 left-2\", \"position\": [12, "
         "-50, 31], \"positionStatus\": \"defined\"}]}, {\"type\": \"Fiducial\", " +
         place +
         ", \"controlPoints\": [{\"label\": \"nasion\", \"position\": [0, 80, 5], \"positionStatus\": "
         "\"defined\"}, {\"label\": \"later\", \"position\": [0, 0, 0], \"positionStatus\": "
         "\"undefined\"}]}]}";
}

TEST_F(Plans, MarkupsKeepTheirFrame) {
  for (const auto& [frame, signs] :
       {std::pair("LPS", glm::dvec3(1)), std::pair("RAS", glm::dvec3(-1, -1, 1))}) {
    const auto plan = read("a.mrk.json", markups(frame));
    ASSERT_TRUE(plan.is_ok()) << plan.error().message();
    ASSERT_EQ(plan.value().trajectories.size(), 1U);
    const volume::PlannedTrajectory& t = plan.value().trajectories[0];
    EXPECT_EQ(t.name, "L3 left");
    EXPECT_EQ(t.entry_world, signs * glm::dvec3(10.5, -20.25, 30));
    EXPECT_EQ(t.target_world, signs * glm::dvec3(12, -50, 31));
    ASSERT_EQ(plan.value().landmarks.size(), 1U);
    EXPECT_EQ(plan.value().landmarks[0].name, "nasion");
    EXPECT_EQ(plan.value().landmarks[0].position_world, signs * glm::dvec3(0, 80, 5));
    EXPECT_EQ(plan.value().notices.size(), 1U) << "a point without a position";
  }
  expect_refused("a.mrk.json", markups("scanner"), "LPS or RAS");
  expect_refused("a.mrk.json", markups(""), "LPS or RAS");
  expect_refused("a.mrk.json", "{\"markups\": 3}", "controlPoints");
  expect_refused("a.mrk.json", "no json", "controlPoints");
}

TEST_F(Plans, TablesDeclareTheirColumnsAndFrame) {
  const auto plain = read("a.csv",
                          "name,entry_x,entry_y,entry_z,target_x,target_y,target_z,diameter\r\n"
                          "left,1,2,3,4,5,6,5.5\r\n\"right, lower\",-1,2,3,-4,5,6,\r\n");
  ASSERT_TRUE(plain.is_ok()) << plain.error().message();
  ASSERT_EQ(plain.value().trajectories.size(), 2U);
  EXPECT_EQ(plain.value().trajectories[0].diameter, 5.5);
  EXPECT_EQ(plain.value().trajectories[1].name, "right, lower");
  EXPECT_EQ(plain.value().trajectories[1].target_world, glm::dvec3(-4, 5, 6));
  EXPECT_EQ(plain.value().notices.size(), 1U) << "the frame is not stated";
  const auto slicer = read("a.fcsv",
                           "# Markups fiducial file version = 4.11\n# CoordinateSystem = RAS\n"
                           "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
                           "vtk1,10,20,30,0,0,0,1,1,1,0,inion,,\n");
  ASSERT_TRUE(slicer.is_ok()) << slicer.error().message();
  ASSERT_EQ(slicer.value().landmarks.size(), 1U);
  EXPECT_EQ(slicer.value().landmarks[0].name, "inion");
  EXPECT_EQ(slicer.value().landmarks[0].position_world, glm::dvec3(-10, -20, 30));
  EXPECT_TRUE(slicer.value().notices.empty());
  expect_refused("a.csv", "a,b,c\n1,2,3\n", "columns");
  expect_refused("a.csv", "a,b,c\n1,2,3\n", "a.csv:1");
  expect_refused("a.csv", "name;x;y;z\nnasion;1;2;3\n", "semicolons");
  expect_refused("a.csv", "name,x,y,z\nnasion,1,5,x7\n", "a.csv:2");
  expect_refused("a.csv", "name,x,y,z\nnasion,\"1,5\",2,3\n", "decimal point");
  expect_refused("a.csv", "name,x,y,z\n", "no trajectory and no landmark");
  expect_refused("a.csv", "# CoordinateSystem = IJK\nname,x,y,z\na,1,2,3\n", "LPS or RAS");
}

TEST_F(Plans, CasesKeepLandmarks) {
  CasePlan plan;
  plan.name = "x";
  plan.structures.push_back({});
  plan.structures[0].shape.name = "bone";
  plan.landmarks.push_back({"nasion", {0.125, -80, 5}});
  const auto again = parse_case(case_text(plan, false), "case.toml");
  ASSERT_TRUE(again.is_ok()) << again.error().message();
  ASSERT_EQ(again.value().landmarks.size(), 1U);
  EXPECT_EQ(again.value().landmarks[0].name, "nasion");
  EXPECT_EQ(again.value().landmarks[0].position_world, glm::dvec3(0.125, -80, 5));
}

TEST_F(Plans, CasesKeepPlansAndMaterials) {
  CasePlan plan;
  plan.name = "x";
  plan.label_names = {"background", "tumour", "L4"};
  CaseStructure bone;
  bone.shape.name = "bone";
  bone.shape.low = 300;
  bone.material = {0.7, 0.001, 0.3, 0.2, 0.01, 4.0, 1.5};
  bone.blocks_back = true;
  bone.back_material = CaseMaterial{0.4};
  plan.structures.push_back(bone);
  plan.trajectories.push_back({"left L4", {1, 2, 3}, {4, 5, 6}, 5.5, "screws", "left", "L4"});
  plan.outlines.push_back({"flap", {{0, 0, 0}, {10, 0, 0.5}, {0, 10, 0}}});
  plan.planes.push_back({"band", {0, 0, 40}, {0, 0.6, 0.8}});
  plan.targets.push_back({"the tumour", "tumour"});
  const std::string text = case_text(plan, true);
  const auto again = parse_case(text, "case.toml");
  ASSERT_TRUE(again.is_ok()) << again.error().message();
  EXPECT_EQ(static_cast<const volume::SurgicalPlan&>(again.value()), plan);
  EXPECT_EQ(again.value().structures[0].material, bone.material);
  EXPECT_EQ(again.value().structures[0].back_material, bone.back_material);
  EXPECT_TRUE(again.value().structures[0].blocks_front && again.value().structures[0].blocks_back);
  const std::pair<const char*, const char*> wrong[] = {
      {"side = \"left\"", "side = \"upper\""},          {"label = \"tumour\"", "label = \"tumor\""},
      {"normal = [0, 0.6, 0.8]", "normal = [0, 0, 0]"}, {"points = [", "points = 3 # ["},
      {"sides = \"both\"", "sides = \"all\""},          {"back_stiffness = 0.4", "back_stiffness = 101"},
      {"target = [4, 5, 6]", "target = [1, 2, 3]"},     {"group = ", "groups = "}};
  for (const auto& [found, replacement] : wrong) {
    std::string other = text;
    const std::size_t at = other.find(found);
    if (at == std::string::npos) {
      ADD_FAILURE() << found << " is not in\n" << text;
      continue;
    }
    other.replace(at, std::string(found).size(), replacement);
    EXPECT_FALSE(parse_case(other, "case.toml").is_ok()) << replacement;
  }
}

/// A case; the test below names its lines by number.
constexpr const char* k_case = R"(schema = 2
name = "x"
hounsfield = true
[labels]
names = ["L4", "cord"]
[[structures]]
name = "bone"
low = 300
static_friction = 0.2
dynamic_friction = 0.1
[[structures]]
name = "cord"
label = 2
[[models]]
name = "nerve"
file = "nerve.ply"
[[trajectories]]
name = "screw"
entry = [1, 2, 3]
target = [4, 5, 6]
side = "left"
vertebra = "L4"
[[outlines]]
name = "flap"
points = [[0, 0, 0], [10, 0, 0], [0, 10, 0]]
)";

TEST_F(Plans, ErrorsOfCasesNameLineValueAndRemedy) {
  const auto valid = parse_case(k_case, "case.toml");
  ASSERT_TRUE(valid.is_ok()) << valid.error().message();
  const struct {
    const char *found, *replacement;
    int line;
    const char* message;
  } rows[] = {
      {"schema = 2", "schema = \"2\"", 1, "\"2\""},
      {"schema = 2", "schema = 9", 1, "schema 9"},
      {"schema = 2", "schema = 0", 1, "schema = 2"},
      {"low = 300", "low = \"300\"", 8, "without quotation marks"},
      {"low = 300", "low = 1e9", 8, "out of range"},
      {"name = \"bone\"", "name = 7", 7, "with quotation marks"},
      {"name = \"bone\"", "name = \"\"", 7, "is empty"},
      {"dynamic_friction = 0.1", "dynamic_friction = 0.3", 10, "0.3 and 0.2"},
      {"name = \"cord\"\nlabel", "name = \"bone\"\nlabel", 11, "two objects have the same name"},
      {"name = \"nerve\"", "name = \"cord\"", 14, "two objects have the same name"},
      {"label = 2", "label = 2\nvolume = \"mr\"", 11, "unknown volume"},
      {"target = [4, 5, 6]", "target = [1, 2, 3]", 17, "another point as target"},
      {"target = [4, 5, 6]", "target = [4, 5]", 20, "found:    [4, 5]\n"},
      {"side = \"left\"", "side = \"upper\"", 17, "side left or right, or no side"},
      {"vertebra = \"L4\"", "vertebra = \"L9\"", 22, "L9"},
      {", [0, 10, 0]]", "]", 23, "3 to 256 points"},
      {", [0, 10, 0]]", ", [5, 0, 0]]", 23, "not on one line"},
  };
  for (const auto& row : rows) {
    SCOPED_TRACE(row.replacement);
    std::string text = k_case;
    const std::size_t at = text.find(row.found);
    ASSERT_NE(at, std::string::npos);
    const auto refused =
        parse_case(text.replace(at, std::string(row.found).size(), row.replacement), "c/case.toml");
    ASSERT_FALSE(refused.is_ok());
    EXPECT_EQ(refused.error().where, "c/case.toml, line " + std::to_string(row.line));
    EXPECT_NE(refused.error().message().find(row.message), std::string::npos) << refused.error().message();
  }
}

TEST_F(Plans, CasesKeepTheColoursOfLabels) {
  CasePlan plan;
  plan.name = "x";
  plan.structures.push_back({});
  plan.structures[0].shape.name = "bone";
  plan.label_names = {"background", "skull", "dura"};
  plan.label_colours = {{0, 0, 0}, {216, 180, 140}, {0, 9, 255}};
  const std::string text = case_text(plan, true);
  const auto again = parse_case(text, "case.toml");
  ASSERT_TRUE(again.is_ok()) << again.error().message();
  EXPECT_EQ(again.value().label_colours, plan.label_colours);
  for (const char* wrong : {"[\"#d8b48c\"]", "[\"#d8b48c\", \"blue\"]", "[\"#d8b48c\", 3]", "5"}) {
    std::string other = text;
    const std::size_t at = other.find("colours = ") + 10;
    other.replace(at, other.find('\n', at) - at, wrong);
    const auto refused = parse_case(other, "case.toml");
    ASSERT_FALSE(refused.is_ok()) << wrong;
    EXPECT_NE(refused.error().message().find("colour"), std::string::npos) << refused.error().message();
  }
}

/// Options of a DICOM segmentation with two segments. A slice without voxels of a segment has no frame of it.
struct SegmentationOptions {
  int bits = 1;  ///< per voxel: 1, or 8 for fractions
  bool overlaps = false;
  double third_frame_z = 16;  ///< mm; slices are 2 apart, starting at 10
  bool has_colours = false;
  scenes::Syntax syntax = scenes::Syntax::explicit_little;
};
std::string segmentation(const SegmentationOptions& of) {
  using scenes::DicomFile;
  DicomFile file;
  file.set(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.66.4")
      .set(0x00080018, "UI", "1.2.3.9")
      .set(0x00080060, "CS", "SEG");
  file.set_short(0x00280002, "US", {1}).set(0x00280004, "CS", "MONOCHROME2").set(0x00280008, "IS", "3");
  file.set_short(0x00280010, "US", {5}).set_short(0x00280011, "US", {7});
  file.set_short(0x00280100, "US", {of.bits}).set_short(0x00280101, "US", {of.bits});
  file.set_short(0x00280102, "US", {of.bits - 1}).set_short(0x00280103, "US", {0});
  file.set_short(0x0062000e, "US", {200});
  const auto segment = [&](int number, const char* label, const std::vector<double>& lab) {
    DicomFile one;
    one.set_short(0x00620004, "US", {number}).set(0x00620005, "LO", label);
    const auto stored = [](double share) { return static_cast<int>(std::floor(65535 * share + 0.5)); };
    if (of.has_colours)
      one.set_short(0x0062000d, "US",
                    {stored(lab[0] / 100), stored((lab[1] + 128) / 255), stored((lab[2] + 128) / 255)});
    return one;
  };
  // The red and the blue of sRGB as CIELab values for D50, the encoding of colours in DICOM.
  file.set_items(0x00620002, {segment(1, "skull", {54.2917, 80.8125, 69.8851}),
                              segment(4, "dura mater", {29.5676, 68.2986, -112.0294})});
  DicomFile shared;
  shared.set_items(0x00209116, {DicomFile().set(0x00200037, "DS", "1\\0\\0\\0\\1\\0")});
  shared.set_items(0x00289110, {DicomFile().set(0x00280030, "DS", "0.5\\0.25").set(0x00180050, "DS", "2")});
  file.set_items(0x52009229, {shared});
  const auto frame = [](double z, int number) {
    DicomFile one;
    one.set_items(0x00209113, {DicomFile().set(0x00200032, "DS", "-3\\4\\" + std::to_string(z))});
    one.set_items(0x0062000a, {DicomFile().set_short(0x0062000b, "US", {number})});
    return one;
  };
  file.set_items(0x52009230, {frame(10, 1), frame(of.overlaps ? 10 : 12, 4), frame(of.third_frame_z, 1)});
  // Voxel i of frame f belongs to its segment when (i + f) % 3 == 0; frames follow each other bit by bit.
  std::string pixels(of.bits == 1 ? (3 * 35 + 7) / 8 + 1 : 3 * 35 + 1, '\0');
  for (int f = 0; f < 3; ++f)
    for (int i = 0; i < 35; ++i) {
      const int at = 35 * f + i;
      if (of.bits == 8)
        pixels[static_cast<std::size_t>(at)] = static_cast<char>((i + f) % 3 == 0 ? 100 : i % 2 * 99);
      else if ((i + f) % 3 == 0 || (of.overlaps && i == 0))
        pixels[static_cast<std::size_t>(at / 8)] =
            static_cast<char>(pixels[static_cast<std::size_t>(at / 8)] | 1 << at % 8);
    }
  file.set_pixels(pixels);
  return file.bytes(of.syntax);
}

TEST_F(Plans, DicomSegmentationsAreLabelsWithNames) {
  const auto frame = volume::Frame::from_spacing({-3, 4, 10}, {0.25, 0.5, 2}).value();
  const volume::Volume scan = volume::make_volume({7, 5, 4}, frame).value();
  const auto write = [&](const SegmentationOptions& of) {
    std::ofstream(scratch_ / "s.dcm", std::ios::binary) << segmentation(of);
    return read_labels(scratch_ / "s.dcm", scan);
  };
  for (const int bits : {1, 8}) {
    const auto labels = write({bits});
    ASSERT_TRUE(labels.is_ok()) << labels.error().message();
    ASSERT_EQ(labels.value().names.size(), 5U);
    EXPECT_EQ(labels.value().names[1], "skull");
    EXPECT_EQ(labels.value().names[4], "dura mater");
    for (int z = 0; z < 4; ++z)
      for (int i = 0; i < 35; ++i) {
        const int f = z == 3 ? 2 : z, segment = z == 0 || z == 3 ? 1 : z == 1 ? 4 : 0;
        EXPECT_EQ(labels.value().labels[static_cast<std::size_t>(35 * z + i)], (i + f) % 3 == 0 ? segment : 0)
            << z << " " << i;
      }
    EXPECT_EQ(labels.value().notices.empty(), bits == 1) << "rounded fractions are reported";
  }
  EXPECT_TRUE(write({1}).value().colours.empty());
  const auto coloured = write({1, false, 16, true});
  ASSERT_TRUE(coloured.is_ok()) << coloured.error().message();
  ASSERT_EQ(coloured.value().colours.size(), 5U);
  const auto expect_near = [](const glm::ivec3& found, const glm::ivec3& expected) {
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(found[a], expected[a], 1) << "channel " << a;
  };
  expect_near(coloured.value().colours[1], {255, 0, 0});
  expect_near(coloured.value().colours[4], {0, 0, 255});
  // Pixels in big-endian words.
  for (const int bits : {1, 8}) {
    const auto words = write({bits, false, 16, false, scenes::Syntax::explicit_big});
    ASSERT_TRUE(words.is_ok()) << words.error().message();
    const auto plain = write({bits});
    EXPECT_EQ(
        std::memcmp(words.value().labels.data(), plain.value().labels.data(), plain.value().labels.bytes()),
        0)
        << bits;
  }
  const auto refusal = [&](const SegmentationOptions& of) {
    const auto labels = write(of);
    return labels ? std::string("it was read") : labels.error().message();
  };
  // Segments that overlap: the voxels that belong to both have their own label.
  const auto both = write({1, true});
  ASSERT_TRUE(both.is_ok()) << both.error().message();
  EXPECT_EQ(both.value().names.size(), 4u);
  EXPECT_NE(both.value().names.back().find('+'), std::string::npos) << both.value().names.back();
  EXPECT_NE(refusal({1, false, 15.3}).find("between the slices"), std::string::npos);
  std::string cut = segmentation({});
  cut.resize(cut.size() - 9);
  std::ofstream(scratch_ / "s.dcm", std::ios::binary) << cut;
  EXPECT_FALSE(read_labels(scratch_ / "s.dcm", scan).is_ok());
}

TEST(Scripts, EveryScriptOfTheDocsIsRead) {
  long count = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(TREPHINE_SOURCE_DIR "/docs/examples")) {
    if (entry.path().extension() != ".toml") continue;
    const auto script = read_script(entry.path().string());
    EXPECT_TRUE(script.is_ok()) << entry.path() << (script ? "" : script.error().message());
    ++count;
  }
  EXPECT_GT(count, 10);
}

TEST(HeadPlan, TheOutlineOfTheHeadLiesOnTheVaultAroundTheTumour) {
  for (const auto& [seed, approach] :
       {std::pair(1, HeadApproach::vault), std::pair(2, HeadApproach::vault),
        std::pair(5, HeadApproach::vault), std::pair(1, HeadApproach::frontotemporal),
        std::pair(1, HeadApproach::suboccipital), std::pair(1, HeadApproach::keyhole),
        std::pair(4, HeadApproach::frontotemporal)}) {
    const std::string name(k_head_approach_names[static_cast<std::size_t>(approach)]);
    SCOPED_TRACE(name + ", seed " + std::to_string(seed));
    const HeadAnatomy anatomy = head_anatomy(static_cast<std::uint64_t>(seed), approach);
    const auto plan = phantom_plan("head", static_cast<std::uint64_t>(seed), name);
    ASSERT_TRUE(plan.has_value());
    ASSERT_EQ(plan->outlines.size(), 1u);
    const glm::dvec3 entry = plan->trajectories[0].entry_world,
                     axis = glm::normalize(entry - plan->trajectories[0].target_world);
    ASSERT_EQ(plan->outlines[0].points_world.size(), 24u);
    for (const glm::dvec3& p : plan->outlines[0].points_world) {
      EXPECT_NEAR(vault_distance(p, anatomy), 0, 0.02);
      const glm::dvec3 away = p - entry;
      EXPECT_NEAR(glm::length(away - glm::dot(away, axis) * axis),
                  anatomy.tumour_radius + anatomy.opening_margin, 0.02);
      EXPECT_LT(glm::length(away), 1.5 * anatomy.tumour_radius + 15) << "on the same side of the head";
    }
  }
}

}  // namespace
}  // namespace trephine::data_tools
