// Shipped procedures on real CT, planned like the phantoms: they are played to their end and scored.
#include <glm/geometric.hpp>
#include <numbers>

#include "data-tools/formats/open_volume.h"
#include "tests/apps/command_fixture.h"
#include "tests/data-tools/file_helpers.h"
#include "tests/whole.h"
#include "volume/scan/traversal.h"

namespace trephine::command_tests {
namespace {

using glm::dvec3;

/// Replaces the first occurrence of a text, which must exist.
void replace(std::string& text, const std::string& before, const std::string& after) {
  const std::size_t at = text.find(before);
  ASSERT_NE(at, std::string::npos) << before;
  text.replace(at, before.size(), after);
}
std::string toml(const dvec3& p) {
  return "[" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " + std::to_string(p.z) + "]";
}

/// Walks through a scan in short steps.
struct Walker {
  const volume::Volume& scan;
  double bone;                           // HU
  static constexpr double k_step = 0.2;  // mm

  bool is_bone(const dvec3& p) const {
    const glm::ivec3 v = volume::voxel_of(scan.frame.volume_from_world(p));
    return scan.contains(v) && scan.voxels[scan.index(v.x, v.y, v.z)] >= bone;
  }
  dvec3 first_bone(dvec3 p, const dvec3& along) const {
    for (int i = 0; i < 2000 && !is_bone(p); ++i) p += k_step * along;
    return p;
  }
  /// Returns the first point behind which 2 mm contain no bone.
  dvec3 beyond(dvec3 p, const dvec3& along) const {
    const auto is_near = [&] {
      for (double t = 0; t <= 2; t += k_step)
        if (is_bone(p + t * along)) return true;
      return false;
    };
    for (int i = 0; i < 200 && is_near(); ++i) p += k_step * along;
    return p;
  }
};

TEST_F(Command, ACraniotomyOnARealHeadIsPlayedToItsEnd) {
  const std::string data = data_tools::real_data();
  if (data.empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  if (!runs_all_cases()) GTEST_SKIP() << "set TREPHINE_WHOLE";
  const std::string scan = data + "/head_real/pcir_head_0.6mm.dicom.tar.xz";
  ASSERT_EQ(run("import '" + scan + "' --largest -o real").exit_code, 0);
  const auto opened = data_tools::open_volume(file("real/volume.mha"));
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  // A burr hole on the upper left of the vault, and a circle of 25 mm around it.
  const Walker walker{opened.value().volume, 300};
  const dvec3 middle(-6, 0, 70), outward = glm::normalize(dvec3(0.75, -0.25, 0.6)),
                                 entry = walker.first_bone(middle + 140.0 * outward, -outward),
                                 inside = walker.beyond(entry, -outward);
  EXPECT_NEAR(glm::distance(entry, inside), 7.5, 2.5) << "thickness of the vault, mm";
  const dvec3 right = glm::normalize(glm::cross(outward, dvec3(0, 0, 1))), up = glm::cross(right, outward);
  std::string points;
  for (int i = 0; i < 24; ++i) {
    const double angle = 2 * std::numbers::pi * i / 24;
    const dvec3 aside = 25.0 * (std::cos(angle) * right + std::sin(angle) * up);
    points += (i > 0 ? ", " : "") + toml(walker.first_bone(entry + aside + 30.0 * outward, -outward));
  }
  write("real/case.toml", read(file("real/case.toml")) +
                              "\n[[trajectories]]\nname = \"burr hole over the tumour\"\nentry = " +
                              toml(entry) + "\ntarget = " + toml(inside - 0.5 * outward) +
                              "\n[[outlines]]\nname = \"craniotomy\"\npoints = [" + points + "]\n");
  const Json played = json("run " TREPHINE_SOURCE_DIR
                           "/docs/examples/procedure-approach.toml --scan real --record r.session");
  EXPECT_EQ(played["is_met"], true) << played["checks"].dump(1);
  const Json score = json("score r.session --scan real");
  EXPECT_EQ(score["is_same"], true);
  EXPECT_EQ(score["points"], score["possible"]) << score.dump(1);
  EXPECT_EQ(score["not_judged"], 6) << "the case has no target";
}

TEST_F(Command, AScrewInARealVertebraIsPlacedAndJudgedStepByStep) {
  if (data_tools::real_data().empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  import_real_spine(data_tools::real_data());
  write("real/case.toml", read(file("real/case.toml")) + k_real_pedicle);
  std::string script = read(TREPHINE_SOURCE_DIR "/docs/examples/procedure-laminectomy-screws.toml");
  replace(script, "scan = \"spine\"\nplan = true\n", "scan = \"./real\"\nlabel = \"vertebrae_L4\"\n");
  // The burr thins the bone at the entry.
  replace(script, "shaft = [0, 1, 0]\n", "place = \"left\"\nshaft = [0, 0, 1]\n");
  const std::size_t begin = script.find("  [0, 0, 95, 8, 0]"), end = script.find("]\n\n", begin);
  script.replace(begin, end - begin,
                 "  [0, 0, 0, 40, 0],\n  [0.3, 0, 0, 8, 0],\n  [0.5, 0, 0, 1, 1],\n  [2.5, 2, 0, -3, 1],\n"
                 "  [2.6, 0, 0, 10, 0],\n  [2.9, 0, 0, 60, 0],\n  [9.6, 0, 0, 60, 0],\n");
  replace(script, "-47, 0]", "-42, 0]");
  replace(script, "length=45", "length=35");
  replace(script, "with = \"vertebra=L4 body=1\"", "with = \"body=1\"");
  replace(script, "with = \"vertebra=L4\"", "");
  replace(script, "what = \"worst screw grade\"\nmost = 0\n", "what = \"worst screw grade\"\nmost = 1\n");
  write("r.toml", script);
  const Json played = json("run r.toml --record r.session");
  EXPECT_EQ(played["is_met"], true) << played["checks"].dump(1);
  const Json score = json("score r.session --scan real");
  EXPECT_EQ(score["is_same"], true);
  EXPECT_EQ(score["not_judged"], 0);
  EXPECT_GE(score["points"].get<double>(), 0.75 * score["possible"].get<double>()) << score.dump(1);
}

}  // namespace
}  // namespace trephine::command_tests
