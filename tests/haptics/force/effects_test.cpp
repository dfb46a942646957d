// Effects, surfaces that give way or are switched off, and what is told about them.
// One file: each effect against its law, by the same judge.
#include "haptics/force/effects.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/proxy/methods.h"
#include "haptics/servo/servo_core.h"
#include "tests/scenes/scenes.h"
#include "volume/removal.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

constexpr double k_dt = 1e-3;

/// Of voxels of 2.5 mm, or as scanners slice.
struct Slices {
  double across = 2.5, thick = 2.5, shear = 0;  ///< mm, mm, degrees
};
constexpr Slices k_slices[] = {{}, {1.5, 3.75, 0}, {0.8, 9.6, 0}, {1.2, 6, 25}};

TouchScene scene_of_plane(const Slices& slices = {}) {
  data_tools::PhantomOptions o;
  o.spacing_mm = {slices.across, slices.across, slices.thick};
  o.shear_degrees = slices.shear;
  o.size = glm::ivec3(48);
  o.psf_sigma_voxels = 1.5;
  o.parameters = {{"angle", 0}};
  TouchScene scene = scenes::phantom_scene("plane", o);
  scene.items[0].material = {0.5, 0.001, 0, 0};
  return scene;
}

ServoLaw law_of(const std::string& words, std::uint32_t id = 0) {
  const auto effect = parse_effect(words);
  EXPECT_TRUE(effect) << effect.error().message();
  return haptics::law_of(effect.value(), id).value();
}

struct Rack {
  TouchScene scene = scene_of_plane();
  LawSet laws;
  LawMemory memory;
  explicit Rack(const std::string& words) { EXPECT_FALSE(laws.add(law_of(words)).has_value()); }
  explicit Rack(const Effect& effect, TouchScene touched = scene_of_plane()) : scene(std::move(touched)) {
    EXPECT_FALSE(laws.add(haptics::law_of(effect, 0).value()).has_value());
  }
  LawForces step(const dvec3& hip, const ProxyStep& proxy = {}, const dvec3& contact = dvec3(0),
                 const volume::Version* cuts = nullptr) {
    return memory.step(laws, {scene, cuts, proxy, contact, hip, {1, 0, 0, 0}, dvec3(0), dvec3(0), k_dt});
  }
};

void expect_near(const dvec3& a, const dvec3& b, double within) { EXPECT_LT(glm::length(a - b), within); }

TEST(Effects, EachIsItsFormulaAndNeverMoreThanItsBound) {
  expect_near(Rack("constant force=1,0,-0.5").step({3, 4, 5}).active_world, {1, 0, -0.5}, 1e-15);
  expect_near(Rack("constant force=0,0,9 most=2").step({}).active_world, {0, 0, 2}, 1e-12);
  expect_near(Rack("spring anchor=0,0,10 stiffness=0.2").step({5, 0, 10}).rendered_world, {-1, 0, 0}, 1e-15);
  expect_near(Rack("spring anchor=0,0,10 stiffness=0.2").step({500, 0, 10}).rendered_world, {-3, 0, 0},
              1e-12);
  Rack plane("plane point=0,0,2 normal=0,0,4 stiffness=0.5");
  expect_near(plane.step({0, 0, 3}).rendered_world, dvec3(0), 1e-15);
  expect_near(plane.step({0, 0, 1}).rendered_world, {0, 0, 0.5}, 1e-15);
  expect_near(Rack("gravity mass=0.1").step({}).active_world, {0, 0, 0.980665}, 1e-12);
  Rack honey("viscous damping=0.01");
  LawForces f;
  for (int i = 0; i < 60; ++i) f = honey.step({0.02 * i, 0, 0});  // 20 mm/s
  expect_near(f.rendered_world, {-0.2, 0, 0}, 1e-6);
  Rack shaker("vibration direction=1,0,0 amplitude=0.5 frequency=50");
  double most = 0, mean = 0, crossings = 0, last = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = shaker.step({}).active_world.x;
    most = std::max(most, std::abs(x));
    mean += x / 1000;
    crossings += x * last < 0;
    last = x;
  }
  EXPECT_NEAR(most, 0.5, 1e-3);
  EXPECT_NEAR(mean, 0, 1e-3);
  EXPECT_NEAR(crossings, 100, 1);  // 50 Hz for a second
  // Texture: the slope of its ripples times the pressure.
  Rack ripples("texture direction=1,0,0 height=0.1 wavelength=2");
  ProxyStep touch;
  touch.has_contact = true;
  touch.normal_world = {0, 0, 1};
  for (const double x : {0.0, 0.5, 1.0, 1.7}) {
    touch.proxy_world = {x, 0, 0};
    const double slope = 0.1 * 3.14159265358979323846 * std::cos(3.14159265358979323846 * x);
    expect_near(ripples.step({x, 0, -1}, touch, {0, 0, 2}).active_world, {-2 * slope, 0, 0}, 1e-9);
  }
}

TEST(Effects, ATrackResistsOnlyWhereItIsMadeLongerAndSaysWhereItsTissueEnds) {
  // Down into bone (z < 0), from 2 mm above it.
  Effect effect = parse_effect("line start=0,0,2 ahead=0,0,-1 stiffness=1 resistance=2").value();
  std::get<LineTrack>(effect.kind).shape = 0;
  Rack rack(effect);
  const auto at = [&](double x, double z) { return rack.step({x, 0, z}); };
  double z = 1.9;
  for (; z > 0.1; z -= 0.01) EXPECT_LT(at(0, z).rendered_world.z, 1e-12);  // air: nothing
  for (; z > -6; z -= 0.01) at(0, z);
  EXPECT_NEAR(at(0, z).rendered_world.z, 2, 0.02);  // bone: its resistance
  // Back and forth in the track costs nothing; sideways a spring holds.
  for (double back = z; back < -1; back += 0.01) {
    const LawForces f = at(0, back);
    if (back > z + 2.1) {
      EXPECT_NEAR(f.rendered_world.z, 0, 1e-9);
    }
    EXPECT_FALSE(f.has_lost_resistance);
  }
  EXPECT_NEAR(at(0.5, -2).rendered_world.x, -0.5, 1e-12);
  // Out of the bone: the plunge.
  bool has_lost = false;
  for (double up = -2; up < 1; up += 0.01) has_lost = at(0, up).has_lost_resistance || has_lost;
  EXPECT_TRUE(has_lost);
  // A cycle in and out takes energy, and never gives any.
  rack.memory.reset();
  double given = 0, last_z = 1, least = 1e300;
  dvec3 held(0);
  for (int i = 0; i < 20000; ++i) {
    const double depth = 3 * std::sin(1e-3 * i) - 1;
    given += held.z * (depth - last_z);
    last_z = depth;
    held = at(0, depth).rendered_world;
    least = std::min(least, -given);
  }
  EXPECT_GT(least, -0.01);
  EXPECT_LT(given, -1.9);  // one millimetre more of track, at 2 N
}

/// Where bone was cut a line meets no resistance, and says when it comes through.
TEST(Effects, ALineFeelsNoBoneThatWasCut) {
  Effect effect = parse_effect("line start=0,0,2 ahead=0,0,-1 stiffness=1 resistance=2").value();
  std::get<LineTrack>(effect.kind).shape = 0;
  for (const Slices& slices : k_slices)
    for (const bool is_cut : {false, true}) {
      SCOPED_TRACE(slices.thick);
      TouchScene scene = scene_of_plane(slices);
      ASSERT_FALSE(set_smallest_burr(scene, 10).has_value());
      volume::RemovalEditor editor(untouched(scene), {scene.items[0].field});
      editor.remove({{0, 0, -20}, {0, 0, -30}, 5, false});  // a cavity from z = -15 down
      const auto cut = editor.publish();
      Rack rack(effect, scene);
      bool has_lost = false;
      LawForces f;
      for (double z = 1.9; z > -20; z -= 0.01) {
        f = rack.step({0, 0, z}, {}, dvec3(0), is_cut ? cut.get() : nullptr);
        has_lost = has_lost || f.has_lost_resistance;
        if (z > -14 && z < -4) {
          EXPECT_NEAR(f.rendered_world.z, 2, 0.02);
        }
      }
      EXPECT_EQ(has_lost, is_cut);
      EXPECT_NEAR(f.rendered_world.z, is_cut ? 0 : 2, 0.02);
    }
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
        .step(set, {scene, nullptr, none, dvec3(0), {0, 0, z}, {1, 0, 0, 0}, dvec3(0), dvec3(0), k_dt})
        .rendered_world.z;
  };
  const LawSet alone = set_of({track(2, 7)}), second = set_of({law_of("constant", 1), track(2, 7)}),
               softer = set_of({track(1, 7)}), another = set_of({track(2, 8)});
  for (double z = 2; z > -6; z -= 0.01) push_at(alone, z);
  EXPECT_NEAR(push_at(alone, -6), 2, 0.02);
  push_at(alone, -3);
  EXPECT_NEAR(push_at(second, -3), 0, 1e-9);   // in the track that was made, beside another law
  EXPECT_NEAR(push_at(softer, -6), 1, 0.02);   // other parameters: the same track
  EXPECT_NEAR(push_at(another, -9), 0, 0.02);  // another law: its track ends where it begins
  EXPECT_NEAR(push_at(another, -11), 2, 0.02);
  EXPECT_NEAR(push_at(alone, -3), 0, 0.02);  // forgotten meanwhile: begins anew, here ...
  EXPECT_NEAR(push_at(alone, -6), 2, 0.02);  // ... and resists from there
  // The same id for another track: what was made in the first is not made in this.
  Effect beside = parse_effect("line start=0,0,1 ahead=0,0,-1 stiffness=1 resistance=2").value();
  const LawSet other = set_of({haptics::law_of(beside, 7).value()});
  EXPECT_NEAR(push_at(other, -1), 0, 0.02);
  EXPECT_NEAR(push_at(other, -4), 2, 0.02);
}

TEST(Effects, ActiveOnesGiveAMovingHandNoMoreThanTheirPower) {
  Rack push("constant force=20,0,0 most=20");
  LawForces f;
  for (int i = 0; i < 60; ++i) f = push.step({1.0 * i, 0, 0});  // 1 m/s along the push
  EXPECT_LE(glm::length(f.active_world) * 1000, LawMemory::k_power * 1.001);
}

TEST(Effects, BadWordsAreAnsweredWithGoodOnes) {
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
  for (std::uint32_t i = 0; i < LawSet::k_most; ++i) EXPECT_FALSE(laws.add(law_of("viscous", i)).has_value());
  EXPECT_TRUE(laws.add(law_of("viscous", 100)).has_value());
  LawSet twice;
  EXPECT_FALSE(twice.add(law_of("viscous", 3)).has_value());
  EXPECT_TRUE(twice.add(law_of("gravity", 3)).has_value());
  EXPECT_TRUE(LawMemory().is_empty());
}

// A drill's guide: a torque toward the direction, against turning, bounded; a turn of it by closed form.
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
    const LawForces f = memory.step(
        set, {scene, nullptr, nothing, dvec3(0), dvec3(0, 0, 9), turned, dvec3(0), dvec3(0), k_dt});
    // The stylus' -z lies `angle` about x off the direction: back about -x.
    const double expected = -std::min(80 * std::abs(std::sin(angle)), 50.0) * (std::sin(angle) < 0 ? -1 : 1);
    expect_near(f.torque_world, {expected, 0, 0}, 1e-9);
    EXPECT_EQ(f.rendered_world, dvec3(0));
    EXPECT_EQ(f.active_world, dvec3(0));
  }
  EXPECT_FALSE(parse_effect("align direction=0,0,0"));
  EXPECT_FALSE(parse_effect("align stiffness=-1"));
}

TEST(Material, IsHarderWhereTheScanIsDenserAndThickAlongTheSurface) {
  TouchScene scene = scene_of_plane();
  ProxyStep touch;
  touch.has_contact = true;
  touch.shape = 0, touch.side = Side::front;
  touch.normal_world = {0, 0, 1};
  ForceOptions raw;
  raw.smoothing_alpha = 1;
  // Where the ramp ends depends on the HU a voxel (2.5 mm) below the place.
  scene.items[0].ramp = StiffnessRamp{300, 1400, 2};
  double last = 0;
  for (double z = 4; z > -6; z -= 0.5) {
    touch.proxy_world = {0, 0, z};
    const double k = ForceModel(raw, k_dt).step(touch, {0, 0, z - 1}, scene).z;
    EXPECT_GE(k, last - 1e-12);
    last = k;
  }
  EXPECT_NEAR(last, 2, 0.01);
  touch.proxy_world = {0, 0, 8};
  EXPECT_NEAR(ForceModel(raw, k_dt).step(touch, {0, 0, 7}, scene).z, 0.5, 1e-12);
  // A ball's middle lies its radius above what it touches; from within, bone lies outward.
  scene.tool_radius = 3;
  touch.proxy_world = {0, 0, 3 - 6};
  EXPECT_NEAR(ForceModel(raw, k_dt).step(touch, {0, 0, -4}, scene).z, 2, 0.01);
  scene.tool_radius = 0;
  touch.side = Side::back;
  touch.normal_world = {0, 0, -1};
  touch.proxy_world = {0, 0, 3};
  EXPECT_NEAR(ForceModel(raw, k_dt).step(touch, {0, 0, 4}, scene).z, -0.5, 0.01);
  touch.side = Side::front;
  touch.normal_world = {0, 0, 1};
  scene.items[0].ramp.reset();
  scene.items[0].material.viscosity = 0.01;
  scene.items[0].material.damping = 0;
  ForceModel model(raw, k_dt);
  touch.proxy_world = {0, 0, 0};
  model.step(touch, {0, 0, -1}, scene);
  touch.proxy_world = {0.05, 0, 0};  // 50 mm/s along, no stretch along
  expect_near(model.step(touch, {0.05, 0, -1}, scene), {-0.5, 0, 0.5}, 1e-12);
  // The back has a material of its own.
  scene.items[0].back_material = Material{1.5, 0, 0, 0};
  EXPECT_EQ(material_of(scene, 0, Side::front).stiffness, 0.5);
  EXPECT_EQ(material_of(scene, 0, Side::back).stiffness, 1.5);
}

struct Servo {
  TouchScene scene;
  std::unique_ptr<ProxyMethod> method;
  ServoScene seen;
  ServoCore core;
  std::vector<TouchEvent> events;
  explicit Servo(TouchScene s, const std::string& name = "subvoxel", const ForceOptions& options = {})
      : scene(std::move(s)),
        method(make_method(name).value()),
        seen((static_cast<void>(method->prepare(scene)),
              scene_for_one(scene, *method, std::make_shared<volume::Version>(scene.base)))),
        core(options, k_dt) {}
  ServoHand& hand() { return seen.hands[0]; }
  void set_laws(const std::vector<const char*>& effects) {
    auto laws = std::make_shared<LawSet>();
    for (const char* words : effects)
      EXPECT_FALSE(laws->add(law_of(words, static_cast<std::uint32_t>(laws->laws().size()))).has_value());
    hand().laws = std::move(laws);
  }
  ServoRecord step(const dvec3& hip) {
    ServoInput input;
    input.pose.position_world = hip;
    const ServoRecord r = core.step(seen, input);
    for (std::size_t e = 0; e < r.event_count; ++e) events.push_back(r.events[e]);
    return r;
  }
  long count(TouchEvent::Kind kind) const {
    return std::count_if(events.begin(), events.end(),
                         [kind](const TouchEvent& e) { return e.kind == kind; });
  }
};

class Surfaces : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, Surfaces,
                         testing::Values("subvoxel", "implicit", "path", "explicit", "explicit-cubes", "mesh",
                                         "scene"));

TEST_P(Surfaces, GiveWayWhenPressedHarderThanTheyBearAndHoldAgainSomeWayOff) {
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
    // Out again, and in: it holds anew.
    for (double z = -12; z < 5; z += 0.05) servo.step({0.2, 0.1, z});
    for (double z = 5; z > -2; z -= 0.05) servo.step({0.2, 0.1, z});
    EXPECT_TRUE(servo.step({0.2, 0.1, -2}).has_contact);
    EXPECT_EQ(servo.count(TouchEvent::popped), 1);
  }
}

TEST_P(Surfaces, AreSwitchedOffAndOnAndSayWhenTheyAreNotReady) {
  Servo servo(scene_of_plane(), GetParam());
  servo.step({0.2, 0.1, 5});
  servo.hand().set_touchable(0, false);
  for (double z = 5; z > -2; z -= 0.05) EXPECT_FALSE(servo.step({0.2, 0.1, z}).has_contact);
  for (double z = -2; z < 5; z += 0.05) servo.step({0.2, 0.1, z});
  servo.hand().set_touchable(0, true);
  for (double z = 5; z > -2; z -= 0.05) servo.step({0.2, 0.1, z});
  EXPECT_TRUE(servo.step({0.2, 0.1, -2}).has_contact);
  // Switched on around a tool it holds from the free side only.
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

/// Bits that come from the top down: where they are the plane holds, where they are not an event says so, and
/// never a hole without one.
TEST_P(Surfaces, AreReadyWhereTheirBitsAreAndSayWhereTheyAreNot) {
  Servo servo(scene_of_plane(), GetParam());
  const volume::Frame& frame = servo.scene.base->frame;
  const glm::ivec3 last = servo.scene.base->size - 1;
  // The half with x > 0 is there.
  const int middle = volume::voxel_of(frame.volume_from_world({0, 0, 0})).x;
  servo.hand().set_ready(0, volume::VoxelBox{{middle, 0, 0}, last});
  const double voxel = frame.spacing().x;
  servo.step({8 * voxel, 0.1, 5});
  for (double z = 5; z > -2; z -= 0.05) servo.step({8 * voxel, 0.1, z});
  EXPECT_TRUE(servo.step({8 * voxel, 0.1, -2}).has_contact);
  EXPECT_EQ(servo.count(TouchEvent::not_ready), 0);
  // Slid toward the other half: let go before the border, and said.
  bool was_held = true;
  for (double x = 8 * voxel; x > -8 * voxel; x -= 0.05) {
    was_held = servo.step({x, 0.1, -2}).has_contact;
    EXPECT_EQ(was_held, servo.count(TouchEvent::not_ready) == 0) << x;
  }
  EXPECT_FALSE(was_held);
  for (double z = -2; z < 5; z += 0.05) servo.step({-8 * voxel, 0.1, z});
  // The rest comes: it holds everywhere.
  servo.hand().set_ready(0, volume::VoxelBox{{0, 0, 0}, last});
  for (double z = 5; z > -2; z -= 0.05) servo.step({-8 * voxel, 0.1, z});
  EXPECT_TRUE(servo.step({-8 * voxel, 0.1, -2}).has_contact);
  EXPECT_EQ(servo.count(TouchEvent::ready), 1);
  // Nothing of it; and all of it, said in one word.
  servo.hand().set_ready(0, volume::VoxelBox{{0, 0, 0}, {-1, -1, -1}});
  EXPECT_FALSE(servo.step({-8 * voxel, 0.1, -2}).has_contact);
  EXPECT_EQ(servo.count(TouchEvent::not_ready), 2);
  servo.hand().set_ready(0, true);
  servo.step({-8 * voxel, 0.1, 5});
  EXPECT_EQ(servo.count(TouchEvent::ready), 2);
}

/// Matter grows over a tool that is on its way out of other matter, and no way out of this is known.
TEST(ServoCore, GrowthWithoutAWayOutSetsTheToolFree) {
  Servo servo(scene_of_plane());
  const volume::Frame& frame = servo.scene.base->frame;
  volume::RemovalEditor editor(std::make_shared<volume::Version>(servo.scene.base),
                               {servo.scene.items[0].field});
  const auto solid = servo.hand().state.version;
  editor.remove({{0, 0, 5}, {0, 0, -9}, 6, false});
  servo.hand().state = TouchState(editor.publish());
  servo.step({0, 0, 5});
  for (double z = 5; z > -5; z -= 0.05) servo.step({0, 0, z});
  const auto grow = [&](std::uint64_t serial, std::uint32_t places) {
    WayOut way;
    way.serial = servo.seen.serial = serial;
    way.count = places;
    way.places_volume[0] = frame.volume_from_world({0, 0, 20});
    servo.hand().state = TouchState(solid);
    servo.hand().way = std::make_shared<WayOut>(way);
  };
  grow(1000, 1);
  ServoRecord r = servo.step({0, 0, -5});
  ASSERT_TRUE(r.is_led);
  for (int i = 0; i < 20; ++i) r = servo.step({0, 0, -5});
  ASSERT_TRUE(r.is_led);
  ASSERT_GT(glm::length(r.force_world), 0.1);
  grow(1001, 0);
  for (int i = 0; i < 50; ++i) {
    r = servo.step({0, 0, -5});
    ASSERT_FALSE(r.is_led);
    ASSERT_FALSE(r.has_contact);
  }
  EXPECT_LT(glm::length(r.force_world), 1e-6);
  // And one that was never led.
  Servo other(scene_of_plane());
  other.hand().way = servo.hand().way;  // grew before its first tick
  EXPECT_FALSE(other.step({0, 0, -5}).is_led);
}

TEST(ServoCore, AHandThatTheSceneDoesNotKnowFeelsNothingAndFaults) {
  Servo servo(scene_of_plane());
  servo.step({0, 0, 5});
  for (double z = 5; z > -2; z -= 0.05) servo.step({0, 0, z});
  ServoScene nobody{7, {}};
  ServoInput input;
  input.pose.position_world = {0, 0, -2};
  ServoRecord r;
  for (int i = 0; i < 200; ++i) r = servo.core.step(nobody, input);
  EXPECT_TRUE(r.faults & fault_stale_scene);
  EXPECT_EQ(r.force_world, dvec3(0));
  EXPECT_EQ(r.pose.buttons, 0u);
  EXPECT_EQ(r.version, 7u);
}

/// A wall that was pressed through, touched and not wholly ready is gone in the next scene.
TEST(ServoCore, WhatIsGoneIsForgotten) {
  Servo servo(scene_of_plane(), "scene");
  const TouchScene narrow = servo.scene;
  const std::shared_ptr<ProxyMethod> method_of_narrow = make_method("scene").value();
  ASSERT_FALSE(method_of_narrow->prepare(narrow).has_value());
  auto wider = std::make_shared<TouchScene>(narrow);
  const std::vector<dvec3> corners{{-9, -9, 3}, {9, -9, 3}, {9, 9, 3}, {-9, 9, 3}};
  wider->items.push_back(
      mesh_item("film", std::make_shared<MeshTree>(corners, std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3})));
  wider->items.back().material.pop_force = 0.2;
  const std::shared_ptr<ProxyMethod> method = make_method("scene").value();
  ASSERT_FALSE(method->prepare(*wider).has_value());
  servo.hand().set_scene(wider, method);
  for (double z = 5; z > 2.2; z -= 0.02) servo.step({0.2, 0.1, z});
  ASSERT_EQ(servo.count(TouchEvent::popped), 1);
  servo.hand().set_ready(1, volume::VoxelBox{{0, 0, 0}, {-1, -1, -1}});
  servo.hand().set_touchable(1, false);
  servo.step({0.2, 0.1, 2.2});
  servo.hand().set_scene(borrowed(narrow), method_of_narrow);
  EXPECT_EQ(servo.hand().part_count, 0u);
  EXPECT_FALSE(servo.hand().has_pops);
  EXPECT_TRUE(servo.hand().untouchable.is_empty() && servo.hand().not_ready.is_empty());
  ServoRecord r;
  for (double z = 2.2; z > -2; z -= 0.05) r = servo.step({0.2, 0.1, z});
  EXPECT_TRUE(r.has_contact);
  EXPECT_EQ(r.shape, 0);
}

/// The next scene may have another item, another place of a model, another tool: what is under way goes on.
TEST(ServoCore, TakesWhatTheNextSceneSays) {
  Servo servo(scene_of_plane(), "scene");
  servo.step({0.2, 0.1, 5});
  for (double z = 5; z > -2; z -= 0.05) servo.step({0.2, 0.1, z});
  ASSERT_TRUE(servo.step({0.2, 0.1, -2}).has_contact);
  // A model comes in beside the hand, and the hand goes on being held by both.
  auto wider = std::make_shared<TouchScene>(servo.scene);
  const std::vector<dvec3> corners{{4, -9, -9}, {4, 9, -9}, {4, 9, 9}, {4, -9, 9}};
  wider->items.push_back(
      mesh_item("wall", std::make_shared<MeshTree>(corners, std::vector<std::uint32_t>{0, 2, 1, 0, 3, 2})));
  wider->items.back().mover = 0;
  const std::shared_ptr<ProxyMethod> method = make_method("scene").value();
  ASSERT_FALSE(method->prepare(*wider).has_value());
  servo.hand().set_scene(wider, method);
  ServoRecord r;
  for (double x = 0.2; x < 6; x += 0.02) {
    r = servo.step({x, 0.1, -2});
    ASSERT_TRUE(r.has_contact);
    ASSERT_LT(r.proxy_world.x, 4);
    ASSERT_GT(r.proxy_world.z, -0.1);
  }
  EXPECT_NEAR(r.proxy_world.x, 4, 0.01);
  // It is put elsewhere, and switched off.
  servo.hand().set_placement(0, {{1, 0, 0}, {1, 0, 0, 0}});
  r = servo.step({6, 0.1, -2});
  EXPECT_NEAR(r.proxy_world.x, 5, 0.01);
  servo.hand().set_touchable(1, false);
  r = servo.step({6, 0.1, -2});
  EXPECT_NEAR(r.proxy_world.x, 6, 0.01);
  EXPECT_EQ(r.shape, 0);
}

/// A plate that moves sideways under a hand at rest drags it; under a hand that goes along it does not.
TEST(ServoCore, FrictionAndViscosityAreThoseOfMotionOverWhatIsTouched) {
  constexpr double k_speed = 20, k_depth = 1;  // mm/s, mm
  struct Case {
    Material material;
    double drag;  ///< N, along the plate's motion
  };
  const Case cases[] = {{{0.5, 0, 0.2, 0.15}, 0.15 * 0.5 * k_depth}, {{0.5, 0, 0, 0, 0.01}, 0.01 * k_speed}};
  for (const Case& c : cases)
    for (const bool goes_along : {false, true}) {
      TouchScene scene = scene_of_plane();
      scene.items.clear();
      const std::vector<dvec3> corners{{-90, -90, 0}, {90, -90, 0}, {90, 90, 0}, {-90, 90, 0}};
      scene.items.push_back(mesh_item(
          "plate", std::make_shared<MeshTree>(corners, std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}),
          c.material));
      scene.items[0].mover = 0;
      ForceOptions options;
      options.smoothing_alpha = 1;
      Servo servo(std::move(scene), "scene", options);
      ServoRecord r;
      for (int i = 0; i < 1500; ++i) {
        const double x = k_speed * k_dt * i, z = std::max(-k_depth, 2 - 0.01 * i);
        servo.hand().set_placement(0, {{x, 0, 0}, {1, 0, 0, 0}});
        r = servo.step({goes_along ? x : 0, 0.3, z});
        if (i < 600) continue;
        ASSERT_TRUE(r.has_contact);
        ASSERT_NEAR(r.force_world.z, 0.5 * k_depth, 0.01);
        ASSERT_NEAR(r.force_world.x, goes_along ? 0 : c.drag, 0.02 * c.drag + 1e-6) << i;
        ASSERT_NEAR(r.force_world.y, 0, 1e-6);
      }
    }
}

TEST(ServoCore, TheLedgerTellsFrictionAndActiveForcesApart) {
  TouchScene scene = scene_of_plane();
  scene.items[0].material = {0.5, 0, 0.3, 0.3};
  Servo servo(scene);
  servo.step({0, 0, 2});
  for (double z = 2; z > -2; z -= 0.01) servo.step({0, 0, z});
  for (double x = 0; x < 20; x += 0.02) servo.step({x, 0, -2});
  EnergyLedger e = servo.core.energy();
  EXPECT_NEAR(e.contact - e.friction, -0.5 * 0.5 * 2 * 2, 0.05);  // the spring holds it
  EXPECT_NEAR(e.friction, -0.3 * 1.0 * 20, 0.8);                  // mu N over 20 mm
  EXPECT_EQ(e.active, 0);
  servo.set_laws({"constant force=0.5,0,0"});
  for (double x = 20; x < 24; x += 0.02) servo.step({x, 0, 5});
  EXPECT_NEAR(servo.core.energy().active, 2, 0.05);
  // What the guard takes away was not given.
  const EnergyLedger before = servo.core.energy();
  ServoInput lost;
  lost.faults = fault_lost_device;
  lost.pose.position_world = {24, 0, 5};
  for (int i = 0; i < 200; ++i) servo.core.step(servo.seen, lost);
  for (int i = 0; i < 500; ++i) {
    lost.pose.position_world.x += 0.02;
    servo.core.step(servo.seen, lost);
  }
  EXPECT_NEAR(servo.core.energy().active, before.active, 0.02);
  EXPECT_NEAR(servo.core.energy().contact, before.contact, 0.02);
}

TEST(ServoCore, APassiveOneGivesBackNoMoreThanItTookAndEffectsThatAreOffChangeNothing) {
  // A surface whose damper makes energy at this rate, under a trembling hand.
  TouchScene scene = scene_of_plane();
  scene.items[0].material = {4, 0, 0, 0};
  ForceOptions raw;
  raw.smoothing_alpha = 0.05;
  raw.slew_limit = 1e9;
  double most[2] = {0, 0};
  for (const bool is_passive : {false, true}) {
    raw.is_passive = is_passive;
    Servo servo(scene, "subvoxel", raw);
    servo.step({0, 0, 1});
    for (int i = 0; i < 4000; ++i) {
      const ServoRecord r = servo.step({0, 0, -0.4 + 0.3 * std::sin(0.4 * i)});
      most[is_passive] = std::max(most[is_passive], r.energy.contact);
    }
  }
  EXPECT_GT(most[0], 5);    // smoothing lags: energy from nowhere
  EXPECT_LT(most[1], 0.3);  // at most a step's
  Servo plain(scene_of_plane()), other(scene_of_plane());
  other.set_laws({});
  for (int i = 0; i < 500; ++i) {
    const dvec3 hip(0.01 * i, 0, 1 - 0.01 * i);
    EXPECT_EQ(plain.step(hip).force_world, other.step(hip).force_world);
  }
}

TEST(ServoCore, BadPlacesAndPosesWithEffectsGiveNoBadForce) {
  Servo servo(scene_of_plane());
  servo.set_laws({"constant force=1,1,1", "viscous damping=0.02", "spring stiffness=2", "line", "plane",
                  "vibration", "gravity", "texture"});
  const double bad[] = {std::nan(""), std::numeric_limits<double>::infinity(), 1e300, -1e7, 1e-310, 1e5};
  for (int i = 0; i < 3000; ++i) {
    dvec3 hip(0.01 * i, 0.3, 2 * std::sin(0.02 * i));
    if (i % 97 == 50) hip[i % 3] = bad[i / 97 % 6];
    const ServoRecord r = servo.step(hip);
    ASSERT_TRUE(std::isfinite(glm::length(r.force_world)));
    ASSERT_LE(glm::length(r.force_world), 8.000001);
    if (i % 500 == 499) servo.core.reset();
  }
}

}  // namespace
}  // namespace trephine::haptics
