// Effects, materials, surfaces that yield or are switched off, and the events of these surfaces.
#include <cmath>

#include "haptics/mesh/mesh_tree.h"
#include "tests/haptics/servo/servo_bench.h"

namespace trephine::haptics {
namespace {

struct EffectRun {
  TouchScene scene = scene_of_plane();
  LawSet laws;
  LawMemory memory;
  explicit EffectRun(const std::string& words) { EXPECT_FALSE(laws.add(law_of(words)).has_value()); }
  LawForces step(const dvec3& hip, const ProxyStep& proxy = {}, const dvec3& contact = dvec3(0),
                 bool is_working = true, const dvec3& torque = dvec3(0)) {
    return memory.step(
        laws,
        {scene, nullptr, proxy, contact, torque, hip, {1, 0, 0, 0}, dvec3(0), dvec3(0), k_dt, is_working});
  }
};

TEST(Effects, EachEqualsItsFormulaWithinItsBound) {
  expect_near(EffectRun("constant force=1,0,-0.5").step({3, 4, 5}).active_world, {1, 0, -0.5}, 1e-15);
  expect_near(EffectRun("constant force=0,0,9 most=2").step({}).active_world, {0, 0, 2}, 1e-12);
  expect_near(EffectRun("spring anchor=0,0,10 stiffness=0.2").step({5, 0, 10}).passive_world, {-1, 0, 0},
              1e-15);
  expect_near(EffectRun("spring anchor=0,0,10 stiffness=0.2").step({500, 0, 10}).passive_world, {-3, 0, 0},
              1e-12);
  EffectRun plane("plane point=0,0,2 normal=0,0,4 stiffness=0.5");
  expect_near(plane.step({0, 0, 3}).passive_world, dvec3(0), 1e-15);
  expect_near(plane.step({0, 0, 1}).passive_world, {0, 0, 0.5}, 1e-15);
  expect_near(EffectRun("gravity mass=0.1").step({}).active_world, {0, 0, 0.980665}, 1e-12);
  // A drill along z with a wall toward -x is dragged toward -y. Without contact, and while the drill is off,
  // no force acts.
  ProxyStep left;
  left.set_contact(0, Side::front, {1, 0, 0});
  EffectRun drill("spin drag=0.3 chatter=0");
  expect_near(drill.step({}, left, {2, 0, 0}).active_world, {0, -0.6, 0}, 1e-12);
  expect_near(drill.step({}, {}, {2, 0, 0}).active_world, dvec3(0), 1e-12);
  expect_near(EffectRun("spin drag=0.3 chatter=0").step({}, left, {2, 0, 0}, false).active_world, dvec3(0),
              1e-12);
  EffectRun viscous("viscous damping=0.01");
  LawForces f;
  for (int i = 0; i < 60; ++i) f = viscous.step({0.02 * i, 0, 0});  // 20 mm/s
  expect_near(f.passive_world, {-0.2, 0, 0}, 1e-6);
  EffectRun vibration("vibration direction=1,0,0 amplitude=0.5 frequency=50");
  double most = 0, mean = 0, crossings = 0, last = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = vibration.step({}).active_world.x;
    most = std::max(most, std::abs(x));
    mean += x / 1000;
    crossings += x * last < 0;
    last = x;
  }
  EXPECT_NEAR(most, 0.5, 1e-3);
  EXPECT_NEAR(mean, 0, 1e-3);
  EXPECT_NEAR(crossings, 100, 1);  // 50 Hz for a second
  // A vibration stands for the torque that the device lacks: 0.01 N per N mm beyond 50 N mm about x, with the
  // stylus along z, is a vibration along y.
  EffectRun lever("missing-torque gain=0.01 rendered=50 frequency=50");
  double along = 0, across = 0;
  for (int i = 0; i < 200; ++i) {
    const dvec3 force = lever.step({}, {}, dvec3(0), true, {150, 0, 0}).active_world;
    along = std::max(along, std::abs(force.y));
    across = std::max({across, std::abs(force.x), std::abs(force.z)});
  }
  EXPECT_NEAR(along, 1, 1e-3);
  EXPECT_LT(across, 1e-12);
  for (int i = 0; i < 20; ++i)
    expect_near(lever.step({}, {}, dvec3(0), true, {0, 50, 0}).active_world, dvec3(0), 1e-15);
  double about_stylus = 0;
  for (int i = 0; i < 20; ++i)
    about_stylus = std::max(about_stylus, lever.step({}, {}, dvec3(0), true, {0, 0, 550}).active_world.z);
  EXPECT_NEAR(about_stylus, 3, 1e-3) << "limited by its default of 3 N";
  // The force of a texture is the slope of its ripples times the normal force.
  EffectRun ripples("texture direction=1,0,0 height=0.1 wavelength=2");
  ProxyStep touch;
  touch.has_contact = true;
  touch.normal_world = {0, 0, 1};
  for (const double x : {0.0, 0.5, 1.0, 1.7}) {
    touch.proxy_world = {x, 0, 0};
    const double slope = 0.1 * 3.14159265358979323846 * std::cos(3.14159265358979323846 * x);
    expect_near(ripples.step({x, 0, -1}, touch, {0, 0, 2}).active_world, {-2 * slope, 0, 0}, 1e-9);
  }
}

TEST(Effects, ATrackResistsOnlyAtItsEnd) {
  EffectRun track("line start=0,0,2 ahead=0,0,-1 stiffness=1 resistance=2");
  const auto at = [&](double x, double z) { return track.step({x, 0, z}); };
  double z = 1.99;
  for (; z > 0.1; z -= 0.01)
    EXPECT_NEAR(at(0, z).passive_world.z, 2 - z, 0.02);  // the spring at the end of the track
  for (; z > -6; z -= 0.01) at(0, z);
  EXPECT_NEAR(at(0, z).passive_world.z, 2, 0.02);
  // A motion back and forth within the track meets no resistance; sideways, a spring holds the tip.
  for (double back = z; back < -1; back += 0.01)
    if (const LawForces f = at(0, back); back > z + 2.1) {
      EXPECT_NEAR(f.passive_world.z, 0, 1e-9);
    }
  EXPECT_NEAR(at(0.5, -2).passive_world.x, -0.5, 1e-12);
  // Cycles in and out take energy from the hand, and return no more than they took.
  track.memory.reset();
  double given = 0, last_z = 1, least = 1e300;
  dvec3 held(0);
  for (int i = 0; i < 20000; ++i) {
    const double depth = 3 * std::sin(1e-3 * i) - 1;
    given += held.z * (depth - last_z);
    last_z = depth;
    held = at(0, depth).passive_world;
    least = std::min(least, -given);
  }
  EXPECT_GT(least, -0.01);
  EXPECT_LT(given, -1.9);  // N mm: the track grows by 1 mm against 2 N
}

TEST(Effects, ALawKeepsItsMemoryByItsIdWhileOthersComeAndGo) {
  const TouchScene scene = scene_of_plane();
  const ProxyStep none{};
  const auto track = [](double resistance, std::uint32_t id) {
    Effect effect = parse_effect("line start=0,0,2 ahead=0,0,-1 stiffness=1").value();
    std::get<LineTrack>(effect.kind).resistance = resistance;
    return haptics::law_of(effect, id).value();
  };
  const auto set_of = [](std::vector<ServoLaw> laws) {
    LawSet set;
    for (ServoLaw& law : laws) EXPECT_FALSE(set.add(std::move(law)).has_value());
    return set;
  };
  LawMemory memory;
  const auto push_at = [&](const LawSet& set, double z) {
    return memory
        .step(set, {scene,
                    nullptr,
                    none,
                    dvec3(0),
                    dvec3(0),
                    {0, 0, z},
                    {1, 0, 0, 0},
                    dvec3(0),
                    dvec3(0),
                    k_dt,
                    true})
        .passive_world.z;
  };
  const LawSet alone = set_of({track(2, 7)}), second = set_of({law_of("constant", 1), track(2, 7)}),
               softer = set_of({track(1, 7)}), another = set_of({track(2, 8)});
  for (double z = 2; z > -6; z -= 0.01) push_at(alone, z);
  EXPECT_NEAR(push_at(alone, -6), 2, 0.02);
  push_at(alone, -3);
  EXPECT_NEAR(push_at(second, -3), 0, 1e-9);   // next to another law: still within its track
  EXPECT_NEAR(push_at(softer, -6), 1, 0.02);   // other parameters, same id: the track is kept
  EXPECT_NEAR(push_at(another, -9), 0, 0.02);  // another id: a new track, which starts here
  EXPECT_NEAR(push_at(another, -11), 2, 0.02);
  // The law was absent in between: its track starts again at the current depth, and resists from there on.
  EXPECT_NEAR(push_at(alone, -3), 0, 0.02);
  EXPECT_NEAR(push_at(alone, -6), 2, 0.02);
  // The id is used again for a track with another start: the depth of the earlier track is discarded.
  Effect shifted = parse_effect("line start=0,0,1 ahead=0,0,-1 stiffness=1 resistance=2").value();
  const LawSet other = set_of({haptics::law_of(shifted, 7).value()});
  EXPECT_NEAR(push_at(other, -1), 0, 0.02);
  EXPECT_NEAR(push_at(other, -4), 2, 0.02);
}

TEST(Effects, ActiveEffectsGiveAMovingHandAtMostTheirPower) {
  EffectRun push("constant force=20,0,0 most=20");
  LawForces f;
  for (int i = 0; i < 60; ++i) f = push.step({1.0 * i, 0, 0});  // 1 m/s along the push
  EXPECT_LE(glm::length(f.active_world) * 1000, LawMemory::k_power * 1.001);
}

TEST(Effects, InvalidWordsAndLawsAreRefused) {
  for (const char* words :
       {"", "hum", "spring anchor=1,2", "spring anchor=0,0,0 stiffness=-1", "viscous damping",
        "vibration amplitude=nan", "line ahead=0,0,0", "texture wavelength=0", "gravity mass=2",
        "plane most=0", "constant force=99,0,0"}) {
    const auto effect = parse_effect(words);
    ASSERT_FALSE(effect) << words;
    EXPECT_FALSE(effect.error().expected.empty()) << words;
  }
  EXPECT_NE(parse_effect("hum").error().message().find("texture"), std::string::npos);
  LawSet laws;
  for (std::uint32_t i = 0; i < LawSet::k_max; ++i) EXPECT_FALSE(laws.add(law_of("viscous", i)).has_value());
  EXPECT_TRUE(laws.add(law_of("viscous", 100)).has_value());
  LawSet twice;
  EXPECT_FALSE(twice.add(law_of("viscous", 3)).has_value());
  EXPECT_TRUE(twice.add(law_of("gravity", 3)).has_value());
  EXPECT_TRUE(LawMemory().is_empty());
}

// A drill guide turns the stylus toward a direction. Its torque, which is bounded, equals a closed form.
TEST(Effects, AlignTurnsTheStylusAlongADirection) {
  const ServoLaw law =
      law_of(parse_effect("align direction=0,0,-2 stiffness=80 damping=0 most=5").value(), 1).value();
  LawSet set;
  ASSERT_FALSE(set.add(law));
  const TouchScene scene = scene_of_plane();
  ProxyStep nothing;
  for (const double angle : {0.0, 0.2, -0.7, 1.5, 3.0}) {
    LawMemory memory;
    const glm::dquat turned(std::cos(angle / 2), std::sin(angle / 2), 0, 0);
    const LawForces f = memory.step(set, {scene, nullptr, nothing, dvec3(0), dvec3(0), dvec3(0, 0, 9), turned,
                                          dvec3(0), dvec3(0), k_dt, true});
    // The -z axis of the stylus is turned from the direction by `angle` (rad) about x: the torque is about
    // -x.
    const double expected = -std::min(80 * std::abs(std::sin(angle)), 50.0) * (std::sin(angle) < 0 ? -1 : 1);
    expect_near(f.torque_world, {expected, 0, 0}, 1e-9);
    EXPECT_EQ(f.passive_world, dvec3(0));
    EXPECT_EQ(f.active_world, dvec3(0));
  }
  EXPECT_FALSE(parse_effect("align direction=0,0,0"));
  EXPECT_FALSE(parse_effect("align stiffness=-1"));
}

TEST(Material, IsStifferInDenserBoneAndViscousAlongTheSurface) {
  TouchScene scene = scene_of_plane();
  ProxyStep touch;
  touch.has_contact = true;
  touch.shape = 0, touch.side = Side::front;
  touch.normal_world = {0, 0, 1};
  ForceOptions raw;
  raw.smoothing_alpha = 1;
  // The stiffness depends on the HU one voxel (2.5 mm) below the contact.
  scene.items[0].ramp = StiffnessRamp{300, 1400, 2};
  double last = 0;
  for (double z = 4; z > -6; z -= 0.5) {
    touch.proxy_world = {0, 0, z};
    const double k = ForceModel(raw, k_dt).step(touch, {0, 0, z - 1}, scene).force_world.z;
    EXPECT_GE(k, last - 1e-12);
    last = k;
  }
  EXPECT_NEAR(last, 2, 0.01);
  touch.proxy_world = {0, 0, 8};
  EXPECT_NEAR(ForceModel(raw, k_dt).step(touch, {0, 0, 7}, scene).force_world.z, 0.5, 1e-12);
  // The contact of a ball is one radius below its centre. At a back side, bone is in the direction of the
  // normal.
  scene.tool = std::make_shared<const ToolShape>(3);
  touch.proxy_world = {0, 0, 3 - 6};
  EXPECT_NEAR(ForceModel(raw, k_dt).step(touch, {0, 0, -4}, scene).force_world.z, 2, 0.01);
  scene.tool = std::make_shared<const ToolShape>(0);
  touch.side = Side::back;
  touch.normal_world = {0, 0, -1};
  touch.proxy_world = {0, 0, 3};
  EXPECT_NEAR(ForceModel(raw, k_dt).step(touch, {0, 0, 4}, scene).force_world.z, -0.5, 0.01);
  touch.side = Side::front;
  touch.normal_world = {0, 0, 1};
  scene.items[0].ramp.reset();
  scene.items[0].material.viscosity = 0.01;
  scene.items[0].material.damping = 0;
  ForceModel model(raw, k_dt);
  touch.proxy_world = {0, 0, 0};
  model.step(touch, {0, 0, -1}, scene);
  touch.proxy_world = {0.05, 0, 0};  // 50 mm/s along the surface; the spring is not stretched along it
  expect_near(model.step(touch, {0.05, 0, -1}, scene).force_world, {-0.5, 0, 0.5}, 1e-12);
  // The back side has its own material.
  scene.items[0].back_material = Material{1.5, 0, 0, 0};
  EXPECT_EQ(material_of(scene, 0, Side::front).stiffness, 0.5);
  EXPECT_EQ(material_of(scene, 0, Side::back).stiffness, 1.5);
}

class Surfaces : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, Surfaces,
                         testing::Values("subvoxel", "implicit", "path", "explicit", "explicit-cubes", "mesh",
                                         "scene"));

TEST_P(Surfaces, YieldWhenPressedTooHardAndHoldAgainFartherOff) {
  for (const Slices& slices : k_slices) {
    SCOPED_TRACE(slices.thick);
    TouchScene scene = scene_of_plane(slices);
    scene.items[0].material.pop_force = 2;
    scene.items[0].material.pop_rearm = 3;
    Servo servo(scene, GetParam());
    servo.step({0.2, 0.1, 10});
    double strongest = 0;
    for (double z = 3; z > -12; z -= 0.01)
      strongest = std::max(strongest, glm::length(servo.step({0.2, 0.1, z}).force_world));
    EXPECT_EQ(servo.count(TouchEvent::popped), 1);
    EXPECT_EQ(servo.count(TouchEvent::rearmed), 1);
    EXPECT_EQ(servo.count(TouchEvent::touched), 1);
    EXPECT_EQ(servo.count(TouchEvent::untouched), 1);
    EXPECT_LT(strongest, 2.1);
    EXPECT_GT(strongest, 1.9);
    EXPECT_FALSE(servo.step({0.2, 0.1, -12}).has_contact);
    // The tool is drawn out and pressed in again: the surface holds again.
    for (double z = -12; z < 5; z += 0.05) servo.step({0.2, 0.1, z});
    for (double z = 5; z > -2; z -= 0.05) servo.step({0.2, 0.1, z});
    EXPECT_TRUE(servo.step({0.2, 0.1, -2}).has_contact);
    EXPECT_EQ(servo.count(TouchEvent::popped), 1);
  }
}

TEST_P(Surfaces, AreSwitchedOffAndOnAndReportWhenNotReady) {
  Servo servo(scene_of_plane(), GetParam());
  servo.step({0.2, 0.1, 5});
  servo.hand().set_touchable(0, false);
  for (double z = 5; z > -2; z -= 0.05) EXPECT_FALSE(servo.step({0.2, 0.1, z}).has_contact);
  for (double z = -2; z < 5; z += 0.05) servo.step({0.2, 0.1, z});
  servo.hand().set_touchable(0, true);
  for (double z = 5; z > -2; z -= 0.05) servo.step({0.2, 0.1, z});
  EXPECT_TRUE(servo.step({0.2, 0.1, -2}).has_contact);
  // A plane that is switched on while the tool is inside its solid does not hold the tool there.
  servo.hand().set_touchable(0, false);
  servo.step({0.2, 0.1, -3});
  servo.hand().set_touchable(0, true);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(servo.step({0.2, 0.1, -3}).has_contact);
  servo.events.clear();
  servo.hand().set_ready(0, false);
  servo.step({0.2, 0.1, 4});
  ASSERT_EQ(servo.count(TouchEvent::not_ready), 1);
  for (double z = 4; z > -2; z -= 0.05) EXPECT_FALSE(servo.step({0.2, 0.1, z}).has_contact);
  for (double z = -2; z < 4; z += 0.05) servo.step({0.2, 0.1, z});
  servo.hand().set_ready(0, true);
  for (double z = 4; z > -2; z -= 0.05) servo.step({0.2, 0.1, z});
  EXPECT_EQ(servo.count(TouchEvent::ready), 1);
  EXPECT_TRUE(servo.step({0.2, 0.1, -2}).has_contact);
  EXPECT_STREQ(event_name(TouchEvent::lost_resistance), "lost resistance");
}

/// The occupancy of a shape becomes ready part by part. Where it is ready, the plane holds; elsewhere, an
/// event reports that the plane does not hold.
TEST_P(Surfaces, HoldWhereTheirBitsAreReadyAndReportWhereTheyAreNot) {
  Servo servo(scene_of_plane(), GetParam());
  const volume::Frame& frame = servo.scene.base->frame;
  const glm::ivec3 last = servo.scene.base->size - 1;
  // The half with x > 0 is ready.
  const int middle = volume::voxel_of(frame.volume_from_world({0, 0, 0})).x;
  servo.hand().set_ready(0, volume::VoxelBox{{middle, 0, 0}, last});
  const double voxel = frame.spacing().x;
  servo.step({8 * voxel, 0.1, 5});
  for (double z = 5; z > -2; z -= 0.05) servo.step({8 * voxel, 0.1, z});
  EXPECT_TRUE(servo.step({8 * voxel, 0.1, -2}).has_contact);
  EXPECT_EQ(servo.count(TouchEvent::not_ready), 0);
  // The tool slides toward the other half: it is released before the border, with an event.
  bool was_held = true;
  for (double x = 8 * voxel; x > -8 * voxel; x -= 0.05) {
    was_held = servo.step({x, 0.1, -2}).has_contact;
    EXPECT_EQ(was_held, servo.count(TouchEvent::not_ready) == 0) << x;
  }
  EXPECT_FALSE(was_held);
  for (double z = -2; z < 5; z += 0.05) servo.step({-8 * voxel, 0.1, z});
  // The rest becomes ready: the plane holds everywhere.
  servo.hand().set_ready(0, volume::VoxelBox{{0, 0, 0}, last});
  for (double z = 5; z > -2; z -= 0.05) servo.step({-8 * voxel, 0.1, z});
  EXPECT_TRUE(servo.step({-8 * voxel, 0.1, -2}).has_contact);
  EXPECT_EQ(servo.count(TouchEvent::ready), 1);
  // No part is ready; then all parts are, set by the short form of set_ready().
  servo.hand().set_ready(0, volume::VoxelBox{{0, 0, 0}, {-1, -1, -1}});
  EXPECT_FALSE(servo.step({-8 * voxel, 0.1, -2}).has_contact);
  EXPECT_EQ(servo.count(TouchEvent::not_ready), 2);
  servo.hand().set_ready(0, true);
  servo.step({-8 * voxel, 0.1, 5});
  EXPECT_EQ(servo.count(TouchEvent::ready), 2);
}

}  // namespace
}  // namespace trephine::haptics
