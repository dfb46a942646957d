// A case keeps every voxel of its scan, whichever shape is chosen at the import. The cleaned shape is stored
// next to the scan.
#include <algorithm>
#include <glm/geometric.hpp>

#include "apps/workbench/operation.h"
#include "apps/workbench/source.h"
#include "data-tools/cases/case_folder.h"
#include "tests/apps/command_fixture.h"
#include "tests/data-tools/file_helpers.h"
#include "tests/whole.h"

namespace trephine::command_tests {
namespace {

class CaseShape : public Command {
 protected:
  /// Imports `scan` with `options` as the case `name`. Expects that the voxels of the case equal those of the
  /// scan. Returns the case.
  data_tools::OpenedCase expect_same_voxels(const std::string& scan, const std::string& options,
                                            const std::string& name) {
    SCOPED_TRACE(name + " " + options);
    const ProcessResult result = run("import '" + scan + "' " + options + " -o " + name);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    auto opened = data_tools::open_case(file(name));
    EXPECT_TRUE(opened.is_ok());
    if (!opened.is_ok()) return {};
    const std::string path = scan[0] == '/' ? scan : file(scan);
    volume::Volume read = data_tools::is_case_folder(path)
                              ? std::move(data_tools::open_case(path).value().scan.volume)
                              : std::move(data_tools::open_volume(path).value().volume);
    const auto from = read.voxels.span();
    const auto kept = opened.value().scan.volume.voxels.span();
    EXPECT_TRUE(std::equal(from.begin(), from.end(), kept.begin(), kept.end()));
    return std::move(opened).value();
  }
  /// Expects that `command` writes the same picture of `a` and of `b`, byte for byte.
  void expect_same_picture(const std::string& command, const std::string& a, const std::string& b,
                           const std::string& options) {
    SCOPED_TRACE(command + " " + options);
    for (const auto& [source, picture] : {std::pair(a, "a.png"), std::pair(b, "b.png")}) {
      const ProcessResult result = run(command + " " + source + " " + options + " -o " + picture);
      EXPECT_EQ(result.exit_code, 0) << result.err;
    }
    EXPECT_TRUE(read(file("a.png")) == read(file("b.png")));
    std::filesystem::remove(file("a.png")), std::filesystem::remove(file("b.png"));
  }
};

/// Intensities of a hollow box of bone with thin bone in one wall, a table behind it, and two separate grains
/// of bone, inside and outside the box.
int box_on_a_table(int x, int y, int z) {
  const int most = std::max({std::abs(x - 16), std::abs(y - 14), std::abs(z - 16)});
  if (y >= 29) return 600;
  if (most == 9) return std::max(std::abs(y - 14), std::abs(z - 16)) < 2 && x < 16 ? 200 : 900;
  if (x == 16 && y == 14 && z == 16) return 500;
  return x == 2 && y == 2 && z < 4 ? 320 : most < 9 ? 40 : -1000;
}

TEST(Threshold, IsThatOfASpineIfOnlyVertebraeAreLabelled) {
  workbench::Source source;
  const auto low_with = [&](std::vector<std::string> names) {
    volume::Volume scan =
        volume::make_volume({4, 4, 4}, volume::Frame::from_axes({}, glm::dmat3(1)).value()).value();
    scan.is_hounsfield = true;
    scan.label_names = std::move(names);
    source.volume = std::make_shared<const volume::Volume>(std::move(scan));
    return workbench::choose_shape(source, {}, {}).value().low;
  };
  EXPECT_EQ(low_with({}), 300);
  EXPECT_EQ(low_with({"", "vertebrae_L4", "spinal_cord"}), 150);
  EXPECT_EQ(low_with({"", "vertebrae_C1", "skull"}), 300);
  EXPECT_EQ(low_with({"", "vertebral artery"}), 300);
  source.facts = {{"body part", "LSPINE"}};
  EXPECT_EQ(low_with({}), 150);
}

TEST(Threshold, IsThatOfASpineWhereMuchBoneIsCancellous) {
  std::string notice;
  workbench::Listener listener;
  listener.notice = [&](const std::string& text) { notice = text; };
  const auto low_with = [&](int cancellous) {
    volume::Volume scan =
        volume::make_volume({10, 10, 10}, volume::Frame::from_axes({}, glm::dmat3(1)).value()).value();
    scan.is_hounsfield = true;
    for (std::size_t i = 0; i < 1000; ++i)
      scan.voxels[i] = i < 200 ? 900 : i < 200 + static_cast<std::size_t>(cancellous) ? 180 : 40;
    workbench::Source source;
    source.volume = std::make_shared<const volume::Volume>(std::move(scan));
    return workbench::choose_shape(source, {}, listener).value().low;
  };
  EXPECT_EQ(low_with(60), 300);
  EXPECT_EQ(low_with(100), 150);
  EXPECT_NE(notice.find("there are 50 of 150 to 300 HU"), std::string::npos) << notice;
}

/// A skull within soft tissue, and a head holder that does not touch it.
workbench::Source head_in_holder() {
  volume::Volume scan =
      volume::make_volume({40, 48, 40}, volume::Frame::from_axes({}, glm::dmat3(1)).value()).value();
  scan.is_hounsfield = true;
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 40; ++x) {
        const double r = glm::length(glm::dvec3(x - 20, y - 20, z - 20));
        scan.voxels[scan.index(x, y, z)] = y >= 47 ? 600 : r < 18 ? (r > 9 && r < 12 ? 900 : 40) : -1000;
      }
  workbench::Source source;
  source.volume = std::make_shared<const volume::Volume>(std::move(scan));
  return source;
}

TEST(HeadHolder, IsLeftOutUnlessTheShapeIsChosen) {
  std::vector<std::string> notices;
  workbench::Listener listener;
  listener.notice = [&](const std::string& text) { notices.push_back(text); };
  const auto holder_value = [&](const workbench::OperationChoice& choice, bool& is_altered) {
    auto opened = workbench::make_operation(head_in_holder(), choice, listener);
    EXPECT_TRUE(opened);
    const volume::Volume& scan = *opened.value().source.volume;
    is_altered = opened.value().source.is_altered;
    return scan.window_voxels()[scan.index(20, 47, 20)];
  };
  const auto is_reported = [&] {
    return std::any_of(notices.begin(), notices.end(),
                       [](const std::string& text) { return text.find("left out: 1 part") == 0; });
  };
  workbench::OperationChoice choice;
  choice.shape.omits_holder = true;
  bool is_altered = false;
  EXPECT_EQ(holder_value(choice, is_altered), -1000);
  EXPECT_TRUE(is_altered) << "a session must contain the scan";
  EXPECT_TRUE(is_reported());
  notices.clear();
  choice.shape.iso = 300;
  EXPECT_EQ(holder_value(choice, is_altered), 600);
  EXPECT_FALSE(is_altered);
  EXPECT_FALSE(is_reported());
}

/// A head and its holder in NRRD: the holder is not drawn unless requested.
TEST_F(CaseShape, ARenderingLeavesOutAHolder) {
  write("held.nrrd", nrrd(40, [](int x, int y, int z) {
          const double r = glm::length(glm::dvec3(x - 20, y - 18, z - 20));
          return y >= 39 ? 600 : r < 17 ? (r > 9 && r < 12 ? 900 : 40) : -1000;
        }));
  const auto picture = [&](const std::string& options) {
    const ProcessResult ran =
        run("render held.nrrd --hounsfield --from front --pixels 64 -o r.png " + options);
    EXPECT_EQ(ran.exit_code, 0) << ran.err;
    EXPECT_EQ(ran.out.find("left out: 1 part") != std::string::npos, options.find("sur") == std::string::npos)
        << ran.out;
    return read(file("r.png"));
  };
  const std::string bone = picture(""), skin = picture("--transfer-function bone-and-skin");
  EXPECT_NE(bone, picture("--surroundings"));
  EXPECT_NE(skin, picture("--transfer-function bone-and-skin --surroundings"));
}

TEST_F(CaseShape, LeavesTheScanUnchanged) {
  write("raw.nrrd", nrrd(32, box_on_a_table));
  const data_tools::OpenedCase opened =
      expect_same_voxels("raw.nrrd", "--preset skull --fill-thin 3", "made");
  const volume::Volume& v = opened.scan.volume;
  ASSERT_FALSE(v.shape_voxels.is_empty());
  EXPECT_NE(read(file("made/case.toml")).find("[shape]"), std::string::npos);
  const auto shape_at = [&](int x, int y, int z) { return v.shape_voxels[v.index(x, y, z)]; };
  EXPECT_EQ(shape_at(2, 2, 2), -1000) << "a grain";
  EXPECT_EQ(shape_at(20, 30, 20), -1000) << "the table";
  EXPECT_EQ(shape_at(16, 14, 16), -1000) << "a part inside";
  EXPECT_EQ(shape_at(7, 14, 16), 375) << "thin bone is closed";
  EXPECT_EQ(shape_at(7, 5, 16), 900);
  EXPECT_EQ(shape_at(12, 14, 16), 40);
  expect_same_picture("slice", "raw.nrrd", "made", "--plane sagittal --at 16,14,16");
  expect_same_picture("slice", "raw.nrrd", "made", "--plane axial --at 7,14,16");
  expect_same_picture("fluoro", "raw.nrrd", "made", "--view ap --pixels 128");
  // A case that is imported from this case has the same shape, and a session of this case replays with it.
  const data_tools::OpenedCase again = expect_same_voxels("made", "", "again");
  EXPECT_EQ(volume::content_hash(again.scan.volume), volume::content_hash(v));
  EXPECT_NE(volume::content_hash(data_tools::open_volume(file("raw.nrrd")).value().volume),
            volume::content_hash(v))
      << "another shape is another scene";
  write("p.csv", "t,x,y,z\n0,7,14,40\n1,7,14,20\n");
  ASSERT_EQ(run("touch made --path p.csv -o t.csv --record d.session").exit_code, 0);
  EXPECT_EQ(run("replay d.session --scan made --verify").exit_code, 0);
  EXPECT_NE(run("replay d.session --scan raw.nrrd --verify").exit_code, 0);
  ASSERT_EQ(
      run("drill raw.nrrd --largest --burr-diameter 3 --path p.csv --record e.session -o e.mha").exit_code,
      0);
  EXPECT_EQ(run("replay e.session --verify").exit_code, 0) << "the shape is in the session";
}

TEST_F(CaseShape, IsRefusedWhereItDoesNotFit) {
  write("raw.nrrd", nrrd(32, box_on_a_table));
  ASSERT_EQ(run("import raw.nrrd --preset skull -o made").exit_code, 0);
  const std::string plan = read(file("made/case.toml"));
  const std::size_t at = plan.find("values = [");
  ASSERT_NE(at, std::string::npos) << plan;
  write("made/case.toml", plan.substr(0, at) + "values = [40000]" + plan.substr(plan.find('\n', at)));
  EXPECT_NE(run("info made").err.find("not an intensity"), std::string::npos);
  write("made/case.toml", plan.substr(0, at) + "values = []" + plan.substr(plan.find('\n', at)));
  EXPECT_NE(run("info made").err.find("has no values"), std::string::npos);
  write("made/case.toml", plan);
  ASSERT_EQ(run("convert head -o made/other.mha").exit_code, 0);
  std::filesystem::rename(file("made/other.mha"), file("made/shape.mha"));
  EXPECT_NE(run("info made").err.find("different sizes"), std::string::npos);
  std::filesystem::remove(file("made/shape.mha"));
  EXPECT_NE(run("info made").err.find("lacks its shape"), std::string::npos);
}

TEST_F(CaseShape, LeavesEveryRealScanUnchanged) {
  const std::string data = data_tools::real_data();
  if (data.empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  const struct {
    const char *scan, *reading, *shape;
    bool is_small;
  } scans[] = {{"/spine_lumbar/example_ct.nii.gz", "", "--preset spine", true},
               {"/mr_head/ch2.nii.gz", "", "--auto --largest", true},
               {"/spine_thoracic/tspine_roi_078x078x1.nii.gz", "--hounsfield", "--preset spine", false},
               {"/spine_vhf/vhf_lumbar_pelvis_1mm.dicom.tar.xz", "", "--preset spine", false},
               {"/skull_phantom/bone_1mm.dicom.tar.xz", "", "--largest", false},
               {"/head_real/pcir_head_0.6mm.dicom.tar.xz", "", "--preset skull", false}};
  for (const auto& [scan, reading, shape, is_small] : scans) {
    if (!is_small && !runs_all_cases()) continue;
    const data_tools::OpenedCase opened =
        expect_same_voxels(data + scan, std::string(reading) + " " + shape, "made");
    EXPECT_FALSE(opened.scan.volume.shape_voxels.is_empty()) << "each shape leaves out a part";
    const glm::dvec3 middle =
        opened.scan.volume.frame.world_from_volume(0.5 * glm::dvec3(opened.scan.volume.size));
    const std::string at =
        std::to_string(middle.x) + "," + std::to_string(middle.y) + "," + std::to_string(middle.z);
    const std::string source = "'" + data + scan + "' " + reading;
    expect_same_picture("slice", source, "made", "--plane sagittal --at=" + at);
    if (opened.plan.is_hounsfield)
      expect_same_picture("fluoro", source, "made", "--view lateral --pixels 256");
    fs::remove_all(file("made"));
  }
}

}  // namespace
}  // namespace trephine::command_tests
