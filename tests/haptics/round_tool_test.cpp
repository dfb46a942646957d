// A tool with a radius: its middle keeps a radius away from the solid, whatever the size of the voxels.
#include <cmath>
#include <set>

#include "tests/haptics/method_play.h"
#include "volume/offset_field.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

/// A round tool at play, judged by what its method promises of the offset field in use.
struct RoundPlay : Play {
  RoundPlay(TouchScene s, double radius, const std::string& name = "subvoxel")
      : Play(name, with_radius(std::move(s), radius)) {
    no_friction();
  }
  static TouchScene with_radius(TouchScene s, double radius) {
    EXPECT_FALSE(set_tool_radius(s, radius).has_value());
    return s;
  }
};

class RoundMethods : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, RoundMethods,
                         testing::Values("subvoxel", "scene", "scene-sequential", "implicit", "path",
                                         "explicit", "explicit-cubes"),
                         suite_name);

TEST_P(RoundMethods, RestsARadiusAboveASphereAtAnyRadius) {
  for (const double radius : {0.5, 2.0, 6.0}) {
    RoundPlay play(scenes::phantom_scene("sphere", grid(128, 1.5)), radius, GetParam());
    const double step = play.scene.shapes[0].offset->step_mm();
    using Solid = MethodInfo::Solid;
    const Solid solid = find_method(GetParam())->solid;
    double worst = 0, tangential = 0;
    const PosePath path = scenes::sphere_slide(45 + radius, 1, 100, 2);
    for (const auto& sample : path.samples()) {
      const ProxyStep s = play.step(sample.pose.position_world);
      if (!s.has_contact || sample.t < 0.1) continue;
      worst = std::max(worst, std::abs(glm::length(s.proxy_world) - 45 - radius));
      tangential = std::max(
          tangential, glm::length(glm::cross(s.proxy_world, glm::normalize(sample.pose.position_world))));
    }
    EXPECT_GT(play.contacts, 1800);
    EXPECT_EQ(play.judge.fall_throughs(), 0);
    // The blur's own is sigma^2 / R = 0.05 mm; on cubes a lattice step more.
    EXPECT_LT(worst, solid == Solid::cubes ? 1.6 * step : 0.09 + 0.05 * step) << radius;
    if (solid == Solid::smooth) {
      EXPECT_LT(tangential, 0.03) << radius;
    }
  }
}

TEST_P(RoundMethods, StaysOutOfWhatIsNarrowerAndNeverFallsThrough) {
  // A slot of 8 mm takes a tool of 3 mm radius, not one of 5.
  for (const double radius : {3.0, 5.0}) {
    RoundPlay play(scenes::phantom_scene("slot", grid(96, 1)), radius, GetParam());
    play.step({0, 0, 15});
    ProxyStep s;
    for (int i = 0; i < 400; ++i) s = play.step(dvec3(0, 0, 15 - 0.1 * i));
    const double depth = data_tools::phantom_distance("slot", {}, s.proxy_world);
    EXPECT_NEAR(depth, radius < 4 ? 3 : std::sqrt(25.0 - 16.0), radius < 4 ? 0.3 : 1.1) << radius;
    EXPECT_EQ(play.judge.fall_throughs(), 0);
  }
  for (const char* name : {"gyroid", "corner", "plate"}) {
    RoundPlay play(scenes::phantom_scene(name, grid(64, 0.7)), 2.5, GetParam());
    double least = 1e9;
    const PosePath path = scenes::rough_walk(dvec3(-45), dvec3(45), 3, 3000, 5);
    bool was_free = false;
    for (const auto& sample : path.samples()) {
      const ProxyStep s = play.step(sample.pose.position_world);
      const double distance = data_tools::phantom_distance(name, {}, s.proxy_world);
      was_free = was_free || (s.has_contact && distance > 2);
      if (was_free && s.has_contact) least = std::min(least, distance);
    }
    EXPECT_EQ(play.judge.fall_throughs(), 0) << name;
    EXPECT_GT(play.contacts, 300) << name;
    if (std::string(name) != "gyroid") {  // whose distance is of first order only
      const bool is_of_cubes = find_method(GetParam())->solid == MethodInfo::Solid::cubes;
      EXPECT_GT(least, 2.5 - (is_of_cubes ? 1.9 : 0.9)) << name;  // a voxel is 1.9 mm, the blur 1.3
    }
  }
}

/// A sheet of one voxel, flat or tilted, holds a round tool on both sides.
TEST(RoundTool, AThinSheetHoldsItFromBothSides) {
  for (const double angle : {0.0, 23.0, 37.0})
    for (const double side : {1.0, -1.0}) {
      // A voxel is 1.25 mm; the sheet lies through voxel centres.
      RoundPlay play(scenes::phantom_scene("plate", grid(95, 0, 0, {{"thickness", 1.35}, {"angle", angle}})),
                     3);
      const double a = angle / 57.29577951308232;
      const dvec3 n = side * dvec3(std::sin(a), 0, std::cos(a)), along(std::cos(a), 0, -std::sin(a));
      play.step(12.0 * n);
      ProxyStep s;
      for (int i = 0; i < 300; ++i) s = play.step((12 - 0.05 * i) * n);
      for (int i = 0; i < 300; ++i) {
        s = play.step(-3.0 * n + 0.05 * i * along);
        ASSERT_NEAR(glm::dot(s.proxy_world, n), 3.3, 1.0) << angle << " " << side << " " << i;
      }
      EXPECT_EQ(play.judge.fall_throughs(), 0);
    }
}

TEST_P(RoundMethods, HoversOverAFreshHoleUntilItsFieldIsThereAndNeverTrustsOneFromBeforeGrowth) {
  RoundPlay play(scenes::phantom_scene("plane", grid(96, 1, 0, {{"angle", 0}})), 2, GetParam());
  // On cubes the surface is only as near as their faces.
  const double slack =
      find_method(GetParam())->solid == MethodInfo::Solid::cubes ? play.scene.shapes[0].offset->step_mm() : 0;
  volume::RemovalEditor editor(play.version, {play.scene.shapes[0].field});
  const auto untouched = play.version;
  play.step({0, 0, 8});
  for (int i = 0; i < 60; ++i) play.step({0, 0, -8});
  EXPECT_NEAR(play.step({0, 0, -8}).proxy_world.z, 2, 0.1 + slack);
  // Cut: the stale field holds the tool above the hole; bounded by the depth of the cut.
  const volume::RemovalReport report = editor.remove({{0, 0, 3}, {0, 0, -6}, 5});
  play.set_version(editor.publish());
  EXPECT_NEAR(play.step({0, 0, -8}).proxy_world.z, 2, 0.1 + slack);
  // The field's update comes with a later version: down to a radius above the floor at -11.
  editor.attach({play.scene.shapes[0].offset->updated(play.scene.shapes[0].field, *play.scene.shapes[0].bits,
                                                      editor.working(), report.box)});
  play.set_version(editor.publish());
  ProxyStep s;
  for (int i = 0; i < 40; ++i) s = play.step({0, 0, -14});
  EXPECT_NEAR(s.proxy_world.z, -9, 0.3 + slack);
  EXPECT_EQ(play.judge.fall_throughs(), 0);
  // Walls too.
  for (int i = 0; i < 400; ++i) s = play.step({9 * std::cos(0.02 * i), 9 * std::sin(0.02 * i), -7});
  EXPECT_NEAR(std::sqrt(s.proxy_world.x * s.proxy_world.x + s.proxy_world.y * s.proxy_world.y), 3,
              0.35 + slack);
  EXPECT_EQ(play.judge.fall_throughs(), 0);
  // Undo: the older version brings its own field, and the tool is buried, not inside.
  editor.reset(untouched);
  play.set_version(editor.publish());
  EXPECT_TRUE(play.version->offsets().empty());
  EXPECT_TRUE(play.step({0, 0, -7}).is_buried);
}

TEST(RoundTool, OtherMethodsAndBadRadiiAreRefusedInWords) {
  TouchScene scene = scenes::phantom_scene("sphere", grid(32, 1));
  for (const double radius : {-1.0, 6.5, std::nan("")})
    EXPECT_TRUE(set_tool_radius(scene, radius).has_value()) << radius;
  EXPECT_FALSE(set_tool_radius(scene, 4).has_value());
  for (const MethodInfo& info : method_catalogue()) {
    const auto method = make_method(info.name).value();
    const volume::Status refused = method->prepare(scene);
    const bool has_radius = std::set<std::string>{"subvoxel", "mesh", "scene",    "scene-sequential",
                                                  "implicit", "path", "explicit", "explicit-cubes"}
                                .contains(info.name);
    EXPECT_EQ(refused.has_value(), !has_radius) << info.name;
    if (refused) {
      EXPECT_NE(refused->message().find("radius"), std::string::npos);
    }
  }
  scene.shapes[0].sides = Sides::both;
  EXPECT_TRUE(set_tool_radius(scene, 2).has_value());
  EXPECT_FALSE(set_tool_radius(scene, 0).has_value());
  EXPECT_EQ(scene.shapes[0].offset, nullptr);
}

}  // namespace
}  // namespace trephine::haptics
