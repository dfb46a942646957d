// A round tool: its centre stays its radius away from the solid, for any voxel size.
#include <cmath>
#include <random>
#include <set>

#include "apps/verify/ball_judge.h"
#include "apps/verify/volume_samples.h"
#include "tests/haptics/proxy/method_play.h"
#include "volume/fields/offset_field.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

/// Returns the scene with a ball of this radius (mm) as its tool.
TouchScene with_radius(TouchScene s, double radius) {
  EXPECT_FALSE(set_tool_radius(s, radius).has_value());
  return s;
}

struct RoundPlay : Play {
  RoundPlay(const TouchScene& round, const std::string& name) : Play(name, round) { no_friction(); }
  RoundPlay(TouchScene s, double radius, const std::string& name = "subvoxel")
      : RoundPlay(with_radius(std::move(s), radius), name) {}
};

constexpr const char* k_round_methods[] = {"subvoxel", "scene",    "scene-sequential", "implicit",
                                           "path",     "explicit", "explicit-cubes"};

class RoundMethods : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, RoundMethods, testing::ValuesIn(k_round_methods), name_suffix);

/// The offset fields of a radius are built once, for all methods.
TEST(RoundTool, RestsARadiusAboveASphereAtAnyRadius) {
  for (const double radius : {0.5, 2.0, 6.0}) {
    const TouchScene scene = with_radius(scenes::phantom_scene("sphere", phantom_options(128, 1.5)), radius);
    const double step = scene.items[0].offset->step_mm();
    const PosePath path = scenes::sphere_slide(45 + radius, 1, 100, 2);
    for (const char* name : k_round_methods) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(radius));
      RoundPlay play(scene, name);
      using Solid = MethodInfo::Solid;
      const Solid solid = find_method(name)->solid;
      double worst = 0, tangential = 0;
      for (const auto& sample : path.samples()) {
        const ProxyStep s = play.step(sample.pose.position_world);
        if (!s.has_contact || sample.t < 0.1) continue;
        worst = std::max(worst, std::abs(glm::length(s.proxy_world) - 45 - radius));
        tangential = std::max(
            tangential, glm::length(glm::cross(s.proxy_world, glm::normalize(sample.pose.position_world))));
      }
      EXPECT_GT(play.contacts, 1800);
      EXPECT_EQ(play.judge.fall_throughs(), 0);
      // The error by blur is sigma^2 / R = 0.05 mm; on cubes, the error is up to 1.6 steps of the lattice.
      EXPECT_LT(worst, solid == Solid::cubes ? 1.6 * step : 0.09 + 0.05 * step);
      if (solid == Solid::smooth) {
        EXPECT_LT(tangential, 0.03);
      }
    }
  }
}

TEST(RoundTool, StaysOutOfNarrowerGapsAndNeverFallsThrough) {
  // A slot 8 mm wide admits a tool of 3 mm radius, but not a tool of 5 mm radius.
  for (const double radius : {3.0, 5.0}) {
    const TouchScene scene = with_radius(scenes::phantom_scene("slot", phantom_options(96, 1)), radius);
    for (const char* method : k_round_methods) {
      SCOPED_TRACE(std::string(method) + " " + std::to_string(radius));
      RoundPlay play(scene, method);
      play.step({0, 0, 15});
      ProxyStep s;
      for (int i = 0; i < 400; ++i) s = play.step(dvec3(0, 0, 15 - 0.1 * i));
      const double depth = data_tools::phantom_distance("slot", {}, s.proxy_world);
      EXPECT_NEAR(depth, radius < 4 ? 3 : std::sqrt(25.0 - 16.0), radius < 4 ? 0.3 : 1.1);
      EXPECT_EQ(play.judge.fall_throughs(), 0);
    }
  }
  const PosePath path = scenes::rough_walk(dvec3(-45), dvec3(45), 3, 3000, 5);
  for (const char* name : {"gyroid", "corner", "plate"}) {
    const TouchScene scene = with_radius(scenes::phantom_scene(name, phantom_options(64, 0.7)), 2.5);
    for (const char* method : k_round_methods) {
      SCOPED_TRACE(std::string(method) + " " + name);
      RoundPlay play(scene, method);
      double least = 1e9;
      bool was_free = false;
      for (const auto& sample : path.samples()) {
        const ProxyStep s = play.step(sample.pose.position_world);
        const double distance = data_tools::phantom_distance(name, {}, s.proxy_world);
        was_free = was_free || (s.has_contact && distance > 2);
        if (was_free && s.has_contact) least = std::min(least, distance);
      }
      EXPECT_EQ(play.judge.fall_throughs(), 0);
      EXPECT_GT(play.contacts, 300);
      if (std::string(name) != "gyroid") {  // phantom_distance() of a gyroid is exact only to first order
        const bool is_of_cubes = find_method(method)->solid == MethodInfo::Solid::cubes;
        EXPECT_GT(least, 2.5 - (is_of_cubes ? 1.9 : 0.9));  // mm; a voxel is 1.9 mm, the blur 1.3 mm
      }
    }
  }
}

/// A sheet of one voxel, flat or tilted, holds a round tool on both sides.
TEST(RoundTool, ThinSheetStopsRoundToolFromBothSides) {
  for (const double angle : {0.0, 23.0, 37.0})
    for (const double side : {1.0, -1.0}) {
      // A voxel is 1.26 mm; the sheet passes through voxel centres.
      RoundPlay play(
          scenes::phantom_scene("plate", phantom_options(95, 0, 0, {{"thickness", 1.35}, {"angle", angle}})),
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

TEST_P(RoundMethods, HoversOverAFreshHoleUntilItsFieldIsReadyAndIgnoresFieldsFromBeforeGrowth) {
  RoundPlay play(scenes::phantom_scene("plane", phantom_options(96, 1, 0, {{"angle", 0}})), 2, GetParam());
  // For methods on cubes, the surface is only as accurate as the faces of the cubes.
  const double slack =
      find_method(GetParam())->solid == MethodInfo::Solid::cubes ? play.scene.items[0].offset->step_mm() : 0;
  volume::RemovalEditor editor(play.version, {play.scene.items[0].field});
  const auto uncut = play.version;
  play.step({0, 0, 8});
  for (int i = 0; i < 60; ++i) play.step({0, 0, -8});
  EXPECT_NEAR(play.step({0, 0, -8}).proxy_world.z, 2, 0.1 + slack);
  // After a cut, the stale field holds the tool above the hole.
  const volume::RemovalReport report = editor.remove({{0, 0, 3}, {0, 0, -6}, 5});
  play.set_version(editor.publish());
  EXPECT_NEAR(play.step({0, 0, -8}).proxy_world.z, 2, 0.1 + slack);
  // The updated field arrives with a later version: the tool descends to a radius above the floor at z = -11.
  const auto cut = editor.publish();
  play.set_version(cut, {play.scene.items[0].offset->updated(play.scene.items[0].field,
                                                             *play.scene.items[0].bits, *cut, report.box)});
  ProxyStep s;
  for (int i = 0; i < 40; ++i) s = play.step({0, 0, -14});
  EXPECT_NEAR(s.proxy_world.z, -9, 0.3 + slack);
  EXPECT_EQ(play.judge.fall_throughs(), 0);
  // The walls hold too.
  for (int i = 0; i < 400; ++i) s = play.step({9 * std::cos(0.02 * i), 9 * std::sin(0.02 * i), -7});
  EXPECT_NEAR(std::sqrt(s.proxy_world.x * s.proxy_world.x + s.proxy_world.y * s.proxy_world.y), 3,
              0.35 + slack);
  EXPECT_EQ(play.judge.fall_throughs(), 0);
  // Undo: the restored version has its own field again, in which the tool is buried in matter.
  editor.reset(uncut);
  play.set_version(editor.publish());
  EXPECT_TRUE(play.step({0, 0, -7}).is_buried);
}

TEST(RoundTool, OtherMethodsAndBadRadiiAreRefused) {
  TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32, 1));
  for (const double radius : {-1.0, 6.5, std::nan("")})
    EXPECT_TRUE(set_tool_radius(scene, radius).has_value()) << radius;
  EXPECT_FALSE(set_tool_radius(scene, 4).has_value());
  for (const MethodInfo& info : method_catalogue()) {
    const auto method = make_method(info.name).value();
    const Status refused = method->prepare(scene);
    EXPECT_EQ(refused.has_value(), !info.takes(*scene.tool)) << info.name;
    if (refused && !info.is_six_dof()) {
      EXPECT_NE(refused->message().find("radius"), std::string::npos);
    }
  }
  scene.items[0].sides = Side::both;
  EXPECT_TRUE(set_tool_radius(scene, 2).has_value());
  EXPECT_FALSE(set_tool_radius(scene, 0).has_value());
  EXPECT_EQ(scene.items[0].offset, nullptr);
}

/// Makes a wall perpendicular to x in thick slices. Its intensity rises linearly with the depth, and is 300
/// at the sides of the wall.
TouchScene thick_slices(const dvec3& spacing, const dvec3& extent, double half_thickness) {
  const glm::ivec3 size(glm::ceil(extent / spacing));
  volume::Volume v = volume::make_volume(
                         size, volume::Frame::from_spacing(-0.5 * spacing * dvec3(size - 1), spacing).value())
                         .value();
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const double depth = half_thickness - std::abs(v.frame.world_from_volume({x, y, z}).x);
        v.voxels[v.index(x, y, z)] =
            static_cast<std::int16_t>(300 + std::clamp(1000 * depth, -9000.0, 9000.0));
      }
  return scenes::scene_of(std::move(v));
}

/// A wall of 1 mm in slices of 3 or 5 mm is not passed, and a ball's centre stays its radius away.
TEST(RoundTool, AThinWallUnderThickSlicesIsNotPassed) {
  for (const double slice : {3.0, 5.0})
    for (const double radius : {0.5, 1.0, 2.0}) {
      RoundPlay play(thick_slices({0.4, 0.4, slice}, {24, 24, 40}, 0.5), radius);
      std::mt19937_64 random(3);
      std::uniform_real_distribution<double> part(-1, 1);
      int passed = 0;
      double nearest = 1e9;
      for (int push = 0; push < 200; ++push) {
        const double y = 7 * part(random), z = 12 * part(random), along = part(random), up = 4 * part(random);
        const dvec3 from(-6, y, z), to(4, y + 3 * along, z + up);
        play.state = {};
        for (int i = 0; i <= 60; ++i) {
          const ProxyStep s = play.step(from + (i / 60.0) * (to - from));
          nearest = std::min(nearest, -s.proxy_world.x - 0.5);
        }
        passed +=
            play.state.has_proxy && play.scene.base->frame.world_from_volume(play.state.proxy_volume).x > 0;
      }
      EXPECT_EQ(passed, 0) << slice << " " << radius;
      // The spline of the smooth solid lowers the peak of a sheet of two voxels, so that its surface lies
      // deeper.
      EXPECT_GT(nearest, radius - 0.1 - 0.02 * radius - 0.15) << slice << " " << radius;
    }
}

/// In a scan of thick slices, a ball of 2.5 mm radius reaches the end of a hole that a burr of 3 mm radius
/// cut.
TEST(RoundTool, ReachesTheEndOfItsOwnHoleUnderThickSlices) {
  constexpr double k_radius = 3, k_touch = 2.5;  // radii of the burr and of the touched ball, mm
  TouchScene scene = thick_slices({0.5, 0.5, 3}, {30, 30, 48}, 12);
  const volume::CutLattice lattice = volume::CutLattice::for_burr(*scene.base, 2 * k_radius).value();
  volume::RemovalEditor editor(std::make_shared<volume::Version>(scene.base, lattice),
                               {scene.items[0].field});
  const dvec3 start(-18, 2.1, -3.2), end(1.3, -3.4, 4.7);
  editor.remove({start, end, k_radius, false});
  RoundPlay play(std::move(scene), k_touch);
  const auto cut = editor.publish();
  auto field =
      volume::OffsetField::build(play.scene.items[0].field, *play.scene.items[0].bits, cut.get(), k_touch);
  ASSERT_TRUE(field);
  play.set_version(cut, {field.value()});
  double worst = 0;
  ProxyStep last;
  for (int i = 0; i <= 300; ++i) {
    const dvec3 hip = start + (i / 300.0) * (end - start);
    last = play.step(hip);
    worst = std::max(worst, glm::length(last.proxy_world - hip));
  }
  EXPECT_LT(worst, 1e-6);
  // At the end and at the side of the hole, the tool can move by the difference of the two radii, to the
  // accuracy of the lattice.
  for (const dvec3& direction :
       {glm::normalize(end - start), glm::normalize(glm::cross(end - start, dvec3(0, 0, 1)))}) {
    for (int i = 1; i <= 60; ++i) last = play.step(end + (i / 20.0) * direction);
    EXPECT_TRUE(last.has_contact);
    EXPECT_NEAR(glm::dot(last.proxy_world - end, direction), k_radius - k_touch, 0.2);
    for (int i = 60; i >= 0; --i) last = play.step(end + (i / 20.0) * direction);
  }
  EXPECT_EQ(play.judge.fall_throughs(), 0);
}

/// The ball stays out of the smooth solid of the scan, also if voxels are larger than its radius, and on
/// masks whose threshold is one of their two values.
TEST(RoundTool, StaysOutOfCoarseVoxelsAndMasksAtTheirOwnValues) {
  struct Case {
    double voxel, slice, radius;  ///< voxel edge, mm; slice thickness in voxels; mm
    bool is_mask;
  };
  for (const Case& c : {Case{2, 1, 0.5, false}, Case{3, 1, 1, false}, Case{5, 1, 3, false},
                        Case{2, 3, 1, false}, Case{1, 1, 1, true}, Case{0.5, 6, 4, true}}) {
    SCOPED_TRACE(std::to_string(c.voxel) + " x " + std::to_string(c.slice) + ", radius " +
                 std::to_string(c.radius));
    data_tools::PhantomOptions o;
    o.spacing_mm = c.voxel * dvec3(1, 1, c.slice);
    o.size = glm::ivec3(glm::ceil(dvec3(48) / *o.spacing_mm));
    o.psf_sigma_voxels = c.is_mask ? 0 : 0.8;
    o.parameters = {{"radius", 16}};
    volume::Volume result = data_tools::make_phantom("sphere", o).value();
    volume::Shape shape;
    if (c.is_mask) {
      for (auto& v : result.voxels.span()) v = v >= 300 ? 1 : 0;
      shape.low = 1;
    }
    TouchScene scene = scenes::scene_of(std::move(result), {0.5, 0, 0, 0}, shape);
    soften(scene);
    ASSERT_FALSE(set_tool_radius(scene, c.radius).has_value());
    Play play("subvoxel", std::move(scene));
    const verify::SmoothSolid solid =
        verify::smooth_solid(play.scene.base, shape, nullptr, play.scene.items[0].soft);
    const verify::BallJudge judge(c.radius, 300);
    double deepest = 0;
    const PosePath path = scenes::sphere_slide(16, 4, 60, 0.5);
    for (const auto& sample : path.samples()) {
      const ProxyStep step = play.step((1 + c.radius / 16) * sample.pose.position_world);
      deepest = std::max(deepest, judge.penetration_mm(step.proxy_world, [&](const dvec3& p) {
        return solid.is_solid(play.scene.base->frame.volume_from_world(p));
      }));
    }
    EXPECT_GT(play.contacts, 300);
    EXPECT_LT(deepest, 0.1 + 0.02 * c.radius);
  }
}

}  // namespace
}  // namespace trephine::haptics
