// Scene changes of a servo core, and forces in addition to those of surfaces.
#include <cmath>

#include "haptics/mesh/mesh_tree.h"
#include "tests/haptics/servo/servo_bench.h"
#include "volume/cuts/removal.h"

namespace trephine::haptics {
namespace {

/// Matter grows over a tool that is leaving other matter, and no escape path out of the new matter is known.
TEST(ServoCore, GrowthWithoutAnEscapePathFreesTheTool) {
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
    EscapePath way;
    way.serial = servo.seen.serial = serial;
    way.count = places;
    way.positions_volume[0] = frame.volume_from_world({0, 0, 20});
    servo.hand().state = TouchState(solid);
    servo.hand().escape_path = std::make_shared<EscapePath>(way);
  };
  grow(1000, 1);
  ServoRecord r = servo.step({0, 0, -5});
  ASSERT_TRUE(r.is_escaping);
  for (int i = 0; i < 20; ++i) r = servo.step({0, 0, -5});
  ASSERT_TRUE(r.is_escaping);
  ASSERT_GT(glm::length(r.force_world), 0.1);
  grow(1001, 0);
  for (int i = 0; i < 50; ++i) {
    r = servo.step({0, 0, -5});
    ASSERT_FALSE(r.is_escaping);
    ASSERT_FALSE(r.has_contact);
  }
  EXPECT_LT(glm::length(r.force_world), 1e-6);
  // Another tool gets this escape path before its first tick: it does not escape either.
  Servo other(scene_of_plane());
  other.hand().escape_path = servo.hand().escape_path;  // of matter that grew before the first tick
  EXPECT_FALSE(other.step({0, 0, -5}).is_escaping);
}

TEST(ServoCore, AHandMissingInTheSceneHasNoForceAndFaults) {
  Servo servo(scene_of_plane());
  servo.step({0, 0, 5});
  for (double z = 5; z > -2; z -= 0.05) servo.step({0, 0, z});
  ServoScene without_hands{7, {}};
  ServoInput input;
  input.pose.position_world = {0, 0, -2};
  ServoRecord r;
  for (int i = 0; i < 200; ++i) r = servo.core.step(without_hands, input);
  EXPECT_TRUE(r.faults & fault_stale_scene);
  EXPECT_EQ(r.force_world, dvec3(0));
  EXPECT_EQ(r.pose.buttons, 0u);
  EXPECT_EQ(r.version, 7u);
}

/// A film that was pressed through, made untouchable and has no ready voxel is missing in the next scene: the
/// hand keeps no data of it.
TEST(ServoCore, RemovedItemsAreForgotten) {
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

/// When all boxes are in use, an item still renews its own box. A further item is not ready.
TEST(ServoCore, ABoxIsRenewedWhenAllAreInUse) {
  Servo servo(scene_of_plane(), "scene");
  ServoHand& hand = servo.hand();
  const int count = static_cast<int>(ServoHand::k_max_parts);
  for (int item = 0; item <= count; ++item) hand.set_ready(item, volume::VoxelBox{{0, 0, 0}, {9, 9, 9}});
  EXPECT_TRUE(hand.not_ready.contains(count));
  hand.set_ready(0, volume::VoxelBox{{1, 1, 1}, {8, 8, 8}});
  EXPECT_EQ(hand.part_count, ServoHand::k_max_parts);
  for (int item = 0; item < count; ++item) EXPECT_FALSE(hand.not_ready.contains(item)) << item;
}

/// A scene may add a model, move it, or make it untouchable: the contact with the plane continues.
TEST(ServoCore, AdoptsChangesOfTheNextScene) {
  Servo servo(scene_of_plane(), "scene");
  servo.step({0.2, 0.1, 5});
  for (double z = 5; z > -2; z -= 0.05) servo.step({0.2, 0.1, z});
  ASSERT_TRUE(servo.step({0.2, 0.1, -2}).has_contact);
  // A model appears next to the hand: model and plane both stop the hand.
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
  // The model is moved, and then switched off.
  servo.hand().set_placement(0, {{1, 0, 0}, {1, 0, 0, 0}});
  r = servo.step({6, 0.1, -2});
  EXPECT_NEAR(r.proxy_world.x, 5, 0.01);
  servo.hand().set_touchable(1, false);
  r = servo.step({6, 0.1, -2});
  EXPECT_NEAR(r.proxy_world.x, 6, 0.01);
  EXPECT_EQ(r.shape, 0);
}

/// A plate that moves sideways under a hand at rest drags the hand. A hand that moves along with the plate is
/// not dragged.
TEST(ServoCore, FrictionAndViscosityFollowTheRelativeMotion) {
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

TEST(ServoCore, TheLedgerDistinguishesFrictionAndActiveForces) {
  TouchScene scene = scene_of_plane();
  scene.items[0].material = {0.5, 0, 0.3, 0.3};
  Servo servo(scene);
  servo.step({0, 0, 2});
  for (double z = 2; z > -2; z -= 0.01) servo.step({0, 0, z});
  for (double x = 0; x < 20; x += 0.02) servo.step({x, 0, -2});
  EnergyLedger e = servo.core.energy();
  EXPECT_NEAR(e.contact - e.friction, -0.5 * 0.5 * 2 * 2, 0.05);  // N mm, stored in the spring: K depth^2 / 2
  EXPECT_NEAR(e.friction, -0.3 * 1.0 * 20, 0.8);                  // N mm: friction of 0.3 x 1 N over 20 mm
  EXPECT_EQ(e.active, 0);
  servo.set_laws({"constant force=0.5,0,0"});
  for (double x = 20; x < 24; x += 0.02) servo.step({x, 0, 5});
  EXPECT_NEAR(servo.core.energy().active, 2, 0.05);
  // Forces that the guard suppresses do no work.
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

TEST(ServoCore, PassiveContactReturnsNoMoreEnergyThanItAbsorbedAndAnEmptyLawSetChangesNothing) {
  // The hand trembles on a stiff surface: the smoothing of the contact force generates energy.
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
  EXPECT_GT(most[0], 5);    // smoothing lags and generates energy
  EXPECT_LT(most[1], 0.3);  // at most the energy of one step
  Servo plain(scene_of_plane()), other(scene_of_plane());
  other.set_laws({});
  for (int i = 0; i < 500; ++i) {
    const dvec3 hip(0.01 * i, 0, 1 - 0.01 * i);
    EXPECT_EQ(plain.step(hip).force_world, other.step(hip).force_world);
  }
}

TEST(ServoCore, BadPosesWithEffectsGiveNoBadForce) {
  Servo servo(scene_of_plane());
  servo.set_laws({"constant force=1,1,1", "viscous damping=0.02", "spring stiffness=2", "line", "plane",
                  "vibration", "texture", "spin chatter=0.5"});
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
