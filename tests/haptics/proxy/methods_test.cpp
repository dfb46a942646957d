// Requirements for every method that promises a solid, for each kind of solid.
#include "haptics/methods/methods.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include "tests/haptics/proxy/method_play.h"
#include "tests/scenes/golden.h"
#include "volume/base/deterministic_math.h"
#include "volume/surface/surface_nets.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

class Methods : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, Methods,
                         testing::Values("implicit", "path", "explicit", "explicit-cubes", "subvoxel", "mesh",
                                         "depth", "scene", "scene-sequential"),
                         name_suffix);

/// Methods that support cuts. The surfaces of "mesh" and "depth" are built once, from the uncut volume.
class VoxelMethods : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, VoxelMethods,
                         testing::Values("implicit", "path", "explicit", "explicit-cubes", "subvoxel",
                                         "scene", "scene-sequential"),
                         name_suffix);

TEST_P(Methods, FreeMotionFollowsTheHipExactly) {
  Play play(GetParam(), scenes::phantom_scene("sphere", phantom_options(64, 1)));
  for (int i = 0; i < 50; ++i) {
    const dvec3 hip(50.0 + i * 0.1, 40, 10);
    const ProxyStep s = play.step(hip);
    EXPECT_FALSE(s.has_contact);
    EXPECT_LT(glm::length(s.proxy_world - hip), 1e-12);
  }
  EXPECT_EQ(play.judge.fall_throughs(), 0);
}

TEST_P(Methods, StaysNearASphereAndFacesOut) {
  for (const double shear : {0.0, 20.0}) {
    Play play(GetParam(), scenes::phantom_scene("sphere", phantom_options(128, 1.5, shear)));
    play.no_friction();
    double worst = 0, worst_angle = 0;
    long count = 0;
    const PosePath path = scenes::sphere_slide(45, 1.0, 100, 2);
    for (const auto& sample : path.samples()) {
      const ProxyStep s = play.step(sample.pose.position_world);
      if (!s.has_contact || sample.t < 0.1) continue;
      worst = std::max(worst, std::abs(glm::length(s.proxy_world) - 45));
      worst_angle = std::max(
          worst_angle, std::acos(std::min(1.0, glm::dot(s.normal_world, glm::normalize(s.proxy_world)))));
      ++count;
    }
    EXPECT_GT(count, 1800);
    EXPECT_EQ(play.judge.fall_throughs(), 0);
    // Voxels of 0.94 mm. Methods on cubes touch corners of voxels; for others, the blur shifts the surface.
    const bool is_of_cubes = find_method(GetParam())->solid == MethodInfo::Solid::cubes;
    EXPECT_LT(worst, is_of_cubes ? 0.82 : 0.058);
    EXPECT_LT(worst_angle, is_of_cubes                                                   ? 0.07
                           : find_method(GetParam())->solid == MethodInfo::Solid::smooth ? 0.02
                                                                                         : 0.06);
  }
}

/// Returns the tolerance of a method on the sphere (mm): the sag of the surface between two slices. It is
/// larger on masks, whose edges are not blurred, and for methods on cubes, which touch the corners of voxels.
double most_off(const std::string& method, const scenes::Scan& scan) {
  const double slice = 1.5 * scan.slice;
  using Solid = MethodInfo::Solid;
  const Solid solid = find_method(method)->solid;
  if (solid == Solid::cubes) return scan.is_mask ? 1.1 * slice + 0.3 : 0.7 * slice + 0.3;
  if (solid == Solid::smooth) return scan.is_mask ? 0.18 * slice + 0.02 : 0.045 * slice + 0.01;
  return scan.is_mask ? 0.8 * slice + 0.1 : 0.055 * slice + 0.01;
}

/// Uniform bone that fills the phantom_options ends half a voxel outside its last samples, in every unit and
/// frame.
TEST_P(Methods, ASolidEndsHalfAVoxelBeyondTheBorder) {
  for (const scenes::Scan& scan : scenes::k_scans) {
    SCOPED_TRACE(scan.name());
    Play play(GetParam(), scenes::scan_scene(scan, true));
    play.no_friction();
    const volume::Frame& frame = play.scene.base->frame;
    const dvec3 size(play.scene.base->size);
    for (int axis = 0; axis < 3; ++axis)
      for (const int end : {0, 1}) {
        dvec3 hip = 0.5 * size;
        play.state = {};
        play.judge.restart();
        ProxyStep s;
        const double border = end ? size[axis] - 0.5 : -0.5, out = end ? 1 : -1;
        for (int i = 0; i <= 60; ++i) {
          hip[axis] = border + out * (3 - 0.06 * i);
          s = play.step(frame.world_from_volume(hip));
        }
        ASSERT_TRUE(s.has_contact) << axis << " " << end;
        EXPECT_NEAR(frame.volume_from_world(s.proxy_world)[axis], border, 0.02) << axis << " " << end;
      }
    EXPECT_EQ(play.judge.fall_throughs(), 0);
  }
}

TEST_P(Methods, HoldsInEveryFrameUnitAndMask) {
  for (const scenes::Scan& scan : scenes::k_scans) {
    SCOPED_TRACE(scan.name());
    Play play(GetParam(), scenes::scan_scene(scan, false));
    double worst = 0, inside = 0;
    const PosePath path = scenes::sphere_slide(45, 3.0, 100, 1);
    for (const auto& sample : path.samples()) {
      const ProxyStep s = play.step(scan.unit * sample.pose.position_world);
      ASSERT_TRUE(std::isfinite(glm::length(s.proxy_world)));
      if (!s.has_contact || sample.t < 0.1) continue;
      const double off = glm::length(s.proxy_world) / scan.unit - 45;
      worst = std::max(worst, std::abs(off)), inside = std::max(inside, -off);
    }
    EXPECT_GT(play.contacts, 800);
    EXPECT_EQ(play.judge.fall_throughs(), 0);
    EXPECT_LT(worst, most_off(GetParam(), scan)) << inside << " mm inside";
  }
}

TEST_P(Methods, NeverFallsThroughThinPlatesAtAnySpeed) {
  for (const double thickness : {0.94, 1.41, 1.88})              // 1, 1.5 and 2 voxels
    for (const double speed : {0.05, 2.0, 10.0, 60.0, 400.0}) {  // mm per step
      Play play(GetParam(),
                scenes::phantom_scene("plate",
                                      phantom_options(128, 0, 0, {{"thickness", thickness}, {"angle", 37}})));
      dvec3 hip(0, 0, 50);
      play.step(hip);
      while (hip.z > -50) {
        hip += dvec3(0.13 * speed, 0.07 * speed, -speed);
        if (std::abs(hip.x) > 40) hip.x = 0;
        play.step(hip);
      }
      EXPECT_EQ(play.judge.fall_throughs(), 0) << thickness << " " << speed;
      // A thinner plate may have holes where it contains no voxel centre; a plate of two voxels has no holes.
      if (thickness > 1.8) {
        EXPECT_GT(play.contacts, 0) << thickness << " " << speed;
      }
    }
}

TEST_P(Methods, NeverFallsThroughARoughWalk) {
  for (const char* name : {"gyroid", "shell", "corner", "groove"})
    for (const double psf : {0.0, 0.7}) {
      Play play(GetParam(), scenes::phantom_scene(name, phantom_options(96, psf, 12)));
      const PosePath path = scenes::rough_walk(dvec3(-55), dvec3(55), 3.0, 6000, 5);
      for (const auto& sample : path.samples()) {
        const ProxyStep s = play.step(sample.pose.position_world);
        ASSERT_TRUE(std::isfinite(s.proxy_world.x + s.proxy_world.y + s.proxy_world.z));
      }
      EXPECT_EQ(play.judge.fall_throughs(), 0) << name << " " << psf;
      EXPECT_EQ(play.judge.buried_starts(), 0) << name << " " << psf;
      EXPECT_GT(play.contacts, 1000);
    }
}

TEST_P(Methods, HoldsWhileItIsDrilledAndUndoneUnderTheTool) {
  Play play(GetParam(), scenes::phantom_scene("shell", phantom_options(64, 0)));
  volume::RemovalEditor editor(play.version, {play.scene.items[0].field});
  std::vector<std::shared_ptr<const volume::Version>> history{play.version};
  dvec3 last(0, 30, 42);
  int i = 0;
  const PosePath path = scenes::rough_walk(dvec3(-30, 0, 20), dvec3(30, 55, 55), 1.5, 4000, 9);
  for (const auto& sample : path.samples()) {
    const dvec3 hip = sample.pose.position_world;
    if (++i % 200 < 60 && i % 4 == 0) {
      editor.remove({last, hip, 2.5});
      play.set_version(editor.publish());
    }
    if (i % 200 == 60) {
      editor.end_stroke();
      history.push_back(play.version);
    }
    if (i % 700 == 0) {  // back to an earlier state: matter grows, perhaps over the tool
      const std::size_t k = hash_bits(static_cast<std::uint64_t>(i)) % history.size();
      editor.reset(history[k]);
      history.resize(k + 1);
      play.set_version(editor.publish());
    }
    play.step(hip);
    last = hip;
  }
  EXPECT_EQ(play.judge.fall_throughs(), 0);
  EXPECT_GT(play.contacts, 500);
}

TEST_P(VoxelMethods, HoldsInADrilledCavityAndReachesFartherAfterRemoval) {
  Play play(GetParam(), scenes::phantom_scene("plane", phantom_options(96, 1, 0, {{"angle", 0}})));
  volume::RemovalEditor editor(play.version, {play.scene.items[0].field});
  play.step({0, 0, 5});
  for (int i = 0; i < 100; ++i) play.step({0, 0, -6});
  EXPECT_NEAR(glm::length(play.step({0, 0, -6}).proxy_world - dvec3(0, 0, -6)), 6, 1.25);
  editor.remove({{0, 0, 2}, {0, 0, -8}, 4});
  play.set_version(editor.publish());
  for (int i = 0; i < 200; ++i) play.step({0, 0, -6});
  EXPECT_FALSE(play.step({0, 0, -6}).has_contact);
  // Push against floor and wall of the hole from inside.
  for (int i = 0; i < 4000; ++i) {
    const double a = i * 0.01;
    play.step({8 * std::cos(a), 8 * std::sin(a), -9 - 5 * std::sin(0.37 * a)});
  }
  EXPECT_EQ(play.judge.fall_throughs(), 0);
  EXPECT_GT(play.contacts, 3000);
}

TEST_P(Methods, BackSideHoldsAProxyInTheSolid) {
  TouchScene scene = scenes::phantom_scene("sphere", phantom_options(96, 1));
  scene.items[0].sides = Side::both;
  Play play(GetParam(), scene);
  play.step(dvec3(0));
  if (std::string(GetParam()) != "mesh") {  // this method uses only triangles
    EXPECT_TRUE(play.state.inside.contains(0));
  }
  ProxyStep s;
  for (int i = 0; i < 600; ++i) s = play.step(dvec3(0.1 * i, 0.02 * i, 0));
  EXPECT_TRUE(s.has_contact);
  EXPECT_EQ(s.side, Side::back);
  EXPECT_LT(glm::length(s.proxy_world), 46.5);
  EXPECT_LT(glm::dot(s.normal_world, glm::normalize(s.proxy_world)),
            -0.95);  // into the solid, where the proxy is
  // If only the front side is touchable, the proxy leaves the solid with the same motion, and cannot enter it
  // again.
  play.scene.items[0].sides = Side::front;
  if (std::string(GetParam()) == "scene-sequential") {  // this method has its own scene for each volume
    EXPECT_FALSE(play.method->prepare(play.scene).has_value());
  }
  for (int i = 0; i < 600; ++i) s = play.step(dvec3(0.1 * i, 0.02 * i, 0));
  EXPECT_FALSE(s.has_contact);
  for (int i = 0; i < 600; ++i) s = play.step(dvec3(60 - 0.1 * i, 12 - 0.02 * i, 0));
  EXPECT_TRUE(s.has_contact);
  EXPECT_EQ(s.side, Side::front);
}

TEST_P(VoxelMethods, GrowthOverTheProxyIsReportedAndGivesNoForce) {
  Play play(GetParam(), scenes::phantom_scene("plane", phantom_options(64, 1, 0, {{"angle", 0}})));
  const auto uncut = play.version;
  volume::RemovalEditor editor(play.version, {play.scene.items[0].field});
  editor.remove({{0, 0, 0}, {0, 0, -15}, 8});
  play.set_version(editor.publish());
  play.step({0, 0, 10});
  play.step({0, 0, -10});
  play.set_version(uncut);
  const ProxyStep s = play.step({0, 0, -10});
  EXPECT_TRUE(s.is_buried);
  EXPECT_FALSE(s.has_contact);
}

TEST_P(Methods, FrictionHoldsStillAndTrailsByTheCone) {
  Play play(GetParam(), scenes::phantom_scene("plane", phantom_options(128, 1.5, 0, {{"angle", 0}})));
  play.step({0.3, 0.2, 5});
  for (int i = 0; i < 20; ++i) play.step({0.3, 0.2, -2});
  const dvec3 held = play.step({0.3, 0.2, -2}).proxy_world;
  ProxyStep s;
  for (int i = 0; i < 500; ++i) s = play.step({0.3 + 0.3, 0.2, -2});
  EXPECT_LT(glm::length(s.proxy_world - held), 1e-4);  // within the static cone nothing creeps
  dvec3 hip(0.6, 0.2, -2);
  for (int i = 0; i < 300; ++i) {
    hip.x += 0.05;
    s = play.step(hip);
  }
  EXPECT_NEAR(hip.x - s.proxy_world.x, 0.15 * (s.proxy_world.z - hip.z), 0.1);
  EXPECT_EQ(play.judge.fall_throughs(), 0);
}

/// Two shapes, skin over bone: the nearer shape holds the proxy, for any order of the items. A proxy that
/// starts in the skin is held by the bone when it is pressed further.
TEST_P(Methods, TheNearerOfTwoShapesHolds) {
  for (const bool is_bone_first : {false, true}) {
    TouchScene scene = scenes::phantom_scene("plane", phantom_options(64, 2, 0, {{"angle", 0}}));
    volume::Shape skin, bone;
    skin.low = -300, skin.high = 700, bone.low = 700;
    scene.items.clear();
    for (const volume::Shape& shape : is_bone_first ? std::array{bone, skin} : std::array{skin, bone})
      scene.items.push_back(
          {volume::Field(*scene.base, shape),
           std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, shape)),
           Material{0.5, 0.001, 0, 0}, Side::front});
    const auto method = make_method(GetParam()).value();
    ASSERT_FALSE(method->prepare(scene).has_value());
    const volume::Version version(scene.base);
    ProxyState state;
    ProxyStep s = method->step(scene, version, state, {{1, 1, 20}});
    for (const double z : {20.0, -8.0, -8.0}) s = method->step(scene, version, state, {{1, 1, z}});
    EXPECT_TRUE(s.has_contact) << is_bone_first;
    EXPECT_EQ(s.shape, is_bone_first ? 1 : 0);
    EXPECT_GT(s.proxy_world.z, 0.3);  // on the skin: above z = 0, the middle of the blurred edge
    // The proxy starts inside the skin, moves down to the bone, and is pressed further for some steps.
    state = {};
    method->step(scene, version, state, {{1, 1, 0.2}});
    for (int i = 0; i < 60; ++i) s = method->step(scene, version, state, {{1 + 0.01 * i, 1, 0.2 - 0.1 * i}});
    EXPECT_TRUE(s.has_contact) << is_bone_first;
    EXPECT_FALSE(s.is_buried);
    EXPECT_EQ(s.shape, is_bone_first ? 0 : 1);
    EXPECT_GT(s.proxy_world.z, -2);
  }
}

TEST_P(Methods, FarAwayAndHugeStepsAreHarmless) {
  Play play(GetParam(), scenes::phantom_scene("sphere", phantom_options(48, 1)));
  for (int i = 0; i < 400; ++i) {
    const auto at = [i](int k) { return hash_normal(3, static_cast<std::uint64_t>(3 * i + k)); };
    const double reach = i % 3 == 0 ? 4e3 : i % 3 == 1 ? 60 : 1e-9;
    const ProxyStep s = play.step(reach * dvec3(at(0), at(1), at(2)));
    ASSERT_TRUE(std::isfinite(s.proxy_world.x + s.proxy_world.y + s.proxy_world.z));
    ASSERT_LE(s.waypoint_count, k_max_waypoints);
  }
  EXPECT_EQ(play.judge.fall_throughs(), 0);
}

TEST_P(VoxelMethods, WorkDoesNotGrowWithTheVolume) {
  // Equal voxel spacing, volumes of 50^3 and 200^3 voxels: identical steps, identical work.
  long work[2] = {0, 0};
  for (const int i : {0, 1}) {
    data_tools::PhantomOptions o = phantom_options(i == 0 ? 50 : 200, 0, 0, {{"radius", 10}});
    o.spacing_mm = dvec3(0.5);
    const TouchScene scene = scenes::phantom_scene("sphere", o);
    const auto method = make_method(GetParam()).value();
    ASSERT_FALSE(method->prepare(scene).has_value());
    ProxyState state;
    const volume::Version version(scene.base);
    const PosePath path = scenes::sphere_slide(10, 0.5, 50, 1);
    for (const auto& sample : path.samples()) {
      const ProxyStep s = method->step(scene, version, state, {sample.pose.position_world});
      work[i] += s.counters.voxels + s.counters.cells + s.counters.triangles + s.counters.iterations;
    }
  }
  // Only the blocks of empty space around the sphere differ, so the work may differ by 1 %.
  EXPECT_NEAR(static_cast<double>(work[0]), static_cast<double>(work[1]),
              0.01 * static_cast<double>(work[0]));
  EXPECT_GT(work[0], 1000);
}

/// Every compiler, in debug and release builds, gives identical bits for a walk with friction and with cuts
/// under the tool.
TEST(MethodNames, EveryMethodGivesTheSameBitsOnEveryCompiler) {
  for (const MethodInfo& info : method_catalogue()) {
    if (!info.takes_points) continue;
    const TouchScene scene = scenes::phantom_scene("gyroid", phantom_options(56, 0.7, 9));
    const auto method = make_method(info.name).value();
    ASSERT_FALSE(method->prepare(scene).has_value());
    std::shared_ptr<const volume::Version> version = std::make_shared<volume::Version>(scene.base);
    volume::RemovalEditor editor(version, {scene.items[0].field});
    ProxyState state;
    std::uint64_t hash = 14695981039346656037ull;
    long contacts = 0;
    double most_lag = 0;
    const PosePath path = scenes::rough_walk(dvec3(-50), dvec3(50), 2.0, 3000, 17);
    int i = 0;
    for (const auto& sample : path.samples()) {
      const dvec3& hip = sample.pose.position_world;
      if (++i % 100 == 50) {
        editor.remove({hip, hip, 4});
        version = editor.publish();
      }
      const ProxyStep step = method->step(scene, *version, state, {hip});
      contacts += step.has_contact;
      if (!step.has_contact) most_lag = std::max(most_lag, glm::length(step.proxy_world - hip));
      for (const dvec3& v : {step.proxy_world, step.normal_world})
        for (int a = 0; a < 3; ++a) hash = (hash ^ std::bit_cast<std::uint64_t>(v[a])) * 1099511628211ull;
    }
    EXPECT_EQ(hash, scenes::golden(info.name)) << info.name << " 0x" << std::hex << hash;
    EXPECT_GT(contacts, 500) << info.name;
    if (info.solid != MethodInfo::Solid::nothing) {
      EXPECT_LT(most_lag, 1e-9) << info.name;  // without contact no proxy lags behind its HIP
    }
  }
}

TEST(MethodNames, EachMethodTakesWhatItsInfoStates) {
  const data_tools::PhantomOptions options = phantom_options(24, 1);
  const TouchScene plain = scenes::phantom_scene("sphere", options);
  const auto mesh_of = [&](int mover) {
    const volume::Mesh net = volume::surface_net({&plain.items[0].field, nullptr, plain.items[0].bits.get()});
    std::vector<dvec3> vertices;
    for (const glm::vec3& v : net.vertices.span())
      vertices.push_back(plain.base->frame.world_from_volume(dvec3(v)));
    const auto triangles = net.triangles.span();
    TouchItem item = mesh_item(
        "model", std::make_shared<const MeshTree>(
                     std::move(vertices), std::vector<std::uint32_t>(triangles.begin(), triangles.end())));
    item.mover = mover;
    return item;
  };
  for (const MethodInfo& info : method_catalogue()) {
    SCOPED_TRACE(info.name);
    EXPECT_EQ(info.is_six_dof(), info.takes_sets_of_balls || info.takes_shells);
    TouchScene tool = plain;
    if (info.takes_shells) {
      ASSERT_FALSE(set_tool(tool, std::make_shared<const ToolShape>(ToolProfile{{{-2, 2}, {2, 2}}, 1})));
    } else if (info.is_six_dof()) {
      ASSERT_FALSE(set_tool(tool, 2, {{0, 0, 0}, {0, 0, 4}}));
    }
    const auto accepts = [&](const TouchScene& scene) {
      return !make_method(info.name).value()->prepare(scene).has_value();
    };
    EXPECT_TRUE(accepts(tool));
    TouchScene cut = tool;
    ASSERT_FALSE(set_smallest_burr(cut, 10));
    EXPECT_EQ(accepts(cut), info.takes_cuts);
    for (const int mover : {-1, 0}) {
      TouchScene model = tool;
      model.items.push_back(mesh_of(mover));
      EXPECT_EQ(accepts(model), mover < 0 ? info.takes_meshes : info.takes_moving_meshes) << mover;
    }
  }
  // The general method of each kind of tool.
  for (const ToolShape& tool : {ToolShape(), ToolShape(1.0), ToolShape(std::vector<ToolShape::Ball>{{{}, 1}}),
                                ToolShape(ToolProfile{{{-2, 2}, {2, 2}}, 1})}) {
    const MethodInfo& general = general_method(tool);
    EXPECT_TRUE(general.takes(tool) && general.takes_cuts && general.takes_moving_meshes) << general.name;
    EXPECT_FALSE(general.is_baseline);
  }
}

TEST(MethodNames, TheErrorOfAnUnknownNameListsTheKnownOnes) {
  const auto result = make_method("subvoxels");
  ASSERT_FALSE(result);
  for (const MethodInfo& info : method_catalogue())
    EXPECT_NE(result.error().message().find(info.name), std::string::npos) << info.name;
  EXPECT_EQ(std::string(method_catalogue()[0].name), k_default_method);
}

}  // namespace
}  // namespace trephine::haptics
