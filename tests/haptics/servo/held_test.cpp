// An object held by one hand moves with it and is touched by the other hand; a new object is touched from its
// front.
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/proxy/scene_proxy.h"
#include "haptics/servo/servo_core.h"
#include "tests/haptics/servo/servo_fixture.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

/// A cube of 20 mm about its own centre, faces outward.
std::shared_ptr<const MeshTree> cube() {
  std::vector<dvec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 10 : -10, i & 2 ? 10 : -10, i & 4 ? 10 : -10);
  return std::make_shared<MeshTree>(
      std::move(corners), std::vector<std::uint32_t>{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                                     2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5});
}

TouchScene with_cube() {
  TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  scene.items.push_back(mesh_item("cube", cube(), {.static_friction = 0, .dynamic_friction = 0}));
  scene.items.back().mover = 2;
  return scene;
}

struct Held {
  TouchScene scene = with_cube();
  SceneProxy method;
  Placement rest{{0, 0, 100}, {1, 0, 0, 0}};
  Held() { EXPECT_FALSE(method.prepare(scene)); }
  /// Scene in which the second hand holds the cube; grip null: no hand holds it.
  ServoScene scene_of(std::uint64_t serial, const Placement* grip) const {
    ServoHand hand(borrowed(scene), borrowed(method),
                   TouchState(std::shared_ptr<const volume::Version>(uncut_version(scene))));
    hand.set_placement(2, rest);
    ServoScene all{serial, {hand, hand}, grip != nullptr};
    if (grip) all.hands[0].set_held(2, 1, *grip);
    all.hands[1].set_touchable(1, false);
    return all;
  }
};

TEST(Held, AHeldObjectFollowsThePreviousPoseOfItsHand) {
  const Held bench;
  Pose second{{30, 0, 100}};
  const Placement grip = placement_of(second).inverse() * bench.rest;
  const ServoScene not_held = bench.scene_of(1, nullptr), held = bench.scene_of(2, &grip);
  std::vector<ServoCore> cores{ServoCore({}, 1e-3, 0), ServoCore({}, 1e-3, 1)};
  Placement before = bench.rest;
  const auto top = [&](const dvec3& p) { return before.local_from_world(p).z - 10; };
  int pressed = 0;
  for (int i = 0; i < 3000; ++i) {
    const ServoScene& current = i < 200 ? not_held : held;
    // The first hand presses down on the cube and stays there. The second hand turns the cube, and moves it
    // sideways, up and down.
    const Pose first{{0, 0, std::max(106.0, 120 - 0.1 * i)}};
    const double t = i < 300 ? 0 : 1e-3 * (i - 300);
    Pose next = second;
    next.position_world += dvec3(3 * std::sin(2 * t), 0, 4 * std::sin(3 * t));
    const double half = 0.1 * std::sin(2.5 * t),
                 length = 1 + 0.3 * std::sin(t);  // a device may report non-unit quaternions
    next.orientation = {length * std::cos(half), 0, length * std::sin(half), 0};
    const HandPlacements hand_placements =
        current.has_held ? placements_before(cores, cores[0].next_tick()) : HandPlacements{};
    EXPECT_EQ(hand_placements[1].has_value(), i > 200);
    if (hand_placements[1]) before = *hand_placements[1] * grip;
    const ServoRecord rests = cores[0].step(current, {.pose = first, .hand_placements = &hand_placements});
    const ServoRecord holds = cores[1].step(current, {.pose = next, .hand_placements = &hand_placements});
    EXPECT_FALSE(holds.has_contact);
    EXPECT_NEAR(glm::length(before.rotation), 1, 1e-12);
    // The proxy of the first hand rests on the cube in the cube's pose of the previous tick, and never
    // penetrates it.
    ASSERT_GT(top(rests.proxy_world), -1e-6) << i;
    if (i > 200 && rests.has_contact) {
      EXPECT_EQ(rests.shape, 1);
      EXPECT_LT(top(rests.proxy_world), 1e-3) << i;
      ++pressed;
    }
  }
  EXPECT_GT(pressed, 1900);
  // No object is held: poses are not recorded.
  const HandPlacements none;
  for (ServoCore& core : cores) core.step(not_held, {.pose = second, .hand_placements = &none});
  EXPECT_FALSE(cores[0].pose_before(1 << 20) || cores[1].pose_before(1 << 20));
}

TEST(Held, AFaultOfTheHolderLeavesTheObjectInPlace) {
  const Held bench;
  const Pose second{{30, 0, 100}};
  const Placement grip = placement_of(second).inverse() * bench.rest;
  const ServoScene held = bench.scene_of(1, &grip);
  ServoCore core({}, 1e-3, 1);
  for (int i = 0; i < 5; ++i) core.step(held, {.pose = second});
  for (int i = 0; i < 3; ++i) {
    core.step(held, {.pose = {{std::nan(""), 0, 0}}});
    ASSERT_TRUE(core.pose_before(core.next_tick()));
    EXPECT_EQ(core.pose_before(core.next_tick())->position_world, second.position_world);
  }
}

// A model appears whose face is slightly in front of a proxy that rests on another item.
TEST(Held, ANewModelOverTheProxyIsTouchedFromItsFront) {
  for (const double over : {1e-6, 0.05, 0.4}) {  // voxels
    Held bench;
    TouchScene without = scenes::phantom_scene("sphere", phantom_options(32));
    SceneProxy before;
    ASSERT_FALSE(before.prepare(without));
    const double spacing = without.base->frame.spacing().x;
    const auto version = std::shared_ptr<const volume::Version>(uncut_version(without));
    ServoHand hand(borrowed(without), borrowed(before), TouchState(version));
    const ServoScene first{1, {hand}};
    ServoCore core({}, 1e-3);
    const auto at = [](double z) { return ServoInput{.pose = {{0.3, 0.2, z}}}; };
    double z = 120;
    ServoRecord r;
    do r = core.step(first, at(z -= 0.1));
    while (!r.has_contact);
    for (int i = 0; i < 100; ++i) r = core.step(first, at(z - 1));
    ASSERT_TRUE(r.has_contact);
    // The cube's top is slightly above the sphere's.
    const double top = r.proxy_world.z + over * spacing;
    bench.scene.items.back().first_layout = hand.layout + 1;
    hand.set_scene(borrowed(bench.scene), borrowed(bench.method));
    hand.set_placement(2, {{0, 0, top - 10}, {1, 0, 0, 0}});
    const ServoScene second{2, {hand}};
    for (int i = 0; i < 300; ++i) {
      r = core.step(second, at(z - 1 - 0.01 * i));
      ASSERT_TRUE(r.has_contact);
      ASSERT_NEAR(r.proxy_world.z, top, 1e-3) << over;
    }
  }
}

// A proxy is moved to the front of a model only if the model is new, touchable from its front alone, and not
// behind a wall.
TEST(Held, AProxyIsNotMovedThroughExistingWalls) {
  Held bench;
  const auto version = std::shared_ptr<const volume::Version>(uncut_version(bench.scene));
  const double spacing = bench.scene.base->frame.spacing().x;
  for (const bool is_new : {false, true})
    for (const bool is_two_sided : {false, true}) {
      if (is_new && !is_two_sided) continue;  // the previous test tests this case
      bench.scene.items.back().sides = is_two_sided ? Side::both : Side::front;
      ServoHand hand(borrowed(bench.scene), borrowed(bench.method), TouchState(version));
      hand.set_placement(2, {{0, 0, 90}, {1, 0, 0, 0}});  // its top at 100
      ServoCore core({}, 1e-3);
      const ServoScene first{1, {hand}};
      ServoRecord r;
      for (int i = 0; i < 50; ++i) r = core.step(first, {.pose = {{0.3, 0.2, 100 - 0.3 * spacing}}});
      const double before = r.proxy_world.z;
      bench.scene.items.back().first_layout = is_new ? hand.layout + 1 : 0;
      hand.set_scene(borrowed(bench.scene), borrowed(bench.method));
      const ServoScene second{2, {hand}};
      for (int i = 0; i < 50; ++i) r = core.step(second, {.pose = {{0.3, 0.2, 100 - 0.3 * spacing}}});
      EXPECT_NEAR(r.proxy_world.z, before, 1e-9) << is_new << is_two_sided;
      bench.scene.items.back().first_layout = 0;
    }
  // The lower face of a new cube is just below the surface of bone. The path from the proxy to this face
  // crosses the surface.
  Held sunk;
  const TouchScene without = scenes::phantom_scene("sphere", phantom_options(32));
  SceneProxy alone;
  ASSERT_FALSE(alone.prepare(without));
  ServoHand hand(borrowed(without), borrowed(alone), TouchState(version));
  ServoCore core({}, 1e-3);
  const ServoScene first{1, {hand}};
  ServoRecord r;
  for (int i = 0; i < 900; ++i) r = core.step(first, {.pose = {{0.3, 0.2, std::max(40.0, 120 - 0.1 * i)}}});
  ASSERT_TRUE(r.has_contact);
  const double surface = r.proxy_world.z;
  sunk.scene.items.back().first_layout = hand.layout + 1;
  hand.set_scene(borrowed(sunk.scene), borrowed(sunk.method));
  // The cube is upside down: its local top faces down, slightly below the surface.
  hand.set_placement(2, {{0, 0, surface - 0.3 * spacing + 10}, {0, 1, 0, 0}});
  const ServoScene second{2, {hand}};
  for (int i = 0; i < 100; ++i) {
    r = core.step(second, {.pose = {{0.3, 0.2, 40}}});
    ASSERT_GT(r.proxy_world.z, surface - 1e-3);
  }
}

}  // namespace
}  // namespace trephine::haptics
