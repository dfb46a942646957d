// ShellProxy: whole tools against models. The judge is the winding number, which shares no code with the
// method.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "apps/bench/scenes/closed_models.h"
#include "tests/haptics/proxy/shell_fixture.h"
#include "tests/whole.h"
#include "volume/cuts/removal.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

/// A ring with an uneven surface, a thin plate, a ball with few facets, and a star at whose ends many facets
/// meet.
std::vector<std::pair<const char*, depth::Model>> models() {
  constexpr double k_turn = 6.283185307179586;
  constexpr int k_around = 36, k_across = 14;
  depth::Model ring, star;
  for (int i = 0; i < k_around; ++i)
    for (int k = 0; k < k_across; ++k) {
      const double u = i * k_turn / k_around, v = k * k_turn / k_across;
      const double minor = 5 + 0.7 * std::sin(7 * u + 3 * v);
      ring.vertices.push_back({(9 + minor * std::cos(v)) * std::cos(u),
                               (9 + minor * std::cos(v)) * std::sin(u), minor * std::sin(v)});
      const auto at = [&](int a, int b) {
        return static_cast<std::uint32_t>((i + a) % k_around * k_across + (k + b) % k_across);
      };
      for (const std::uint32_t index : {at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)})
        ring.triangles.push_back(index);
    }
  star.vertices = {{0, 0, 5}, {0, 0, -5}};
  constexpr std::uint32_t k_corners = 24;
  for (std::uint32_t i = 0; i < k_corners; ++i) {
    const double angle = i * k_turn / k_corners, radius = i % 2 == 0 ? 5 : 2.5;
    star.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    const std::uint32_t here = 2 + i, next = 2 + (i + 1) % k_corners;
    for (const std::uint32_t index : {0u, here, next, 1u, next, here}) star.triangles.push_back(index);
  }
  return {{"ring", ring},
          {"plate", depth::box({-9, -9, -0.1}, {9, 9, 0.1})},
          {"ball", depth::ball({0, 0, 0}, 6, 8)},
          {"star", star}};
}
TouchScene scene_of_model(const char* name, const depth::Model& model) {
  TouchScene scene = scene_with("sphere", {{"radius", 1}}, std::make_shared<const ToolShape>());
  scene.items.erase(scene.items.begin());
  scene.items.push_back(mesh_item(name, std::make_shared<MeshTree>(model.vertices, model.triangles)));
  return scene;
}
/// Numbers of one sequence, for positions and rotations.
struct Dice {
  std::mt19937 random{3};
  double between(double a, double b) { return a + (b - a) * (double(random()) / 4294967296.0); }
  dvec3 anywhere(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }
};

// If the facets near a point are complete, no motion in front of their planes enters the model.
TEST(ShellProxy, CompleteFacetsBoundTheMotionsNearby) {
  for (const auto& [name, model] : models()) {
    SCOPED_TRACE(name);
    const TouchScene scene = scene_of_model(name, model);
    const SceneLayout layout = SceneLayout::of(scene).value();
    const TouchState touch_state(std::shared_ptr<const volume::Version>(uncut_version(scene)));
    const ProxyState state;
    ProxyCounters counters;
    SceneWalls walls(scene, layout, touch_state, state, {}, counters);
    Dice dice;
    int complete = 0, incomplete = 0, moved = 0;
    for (int n = 0; n < (runs_all_cases() ? 20'000 : 3000); ++n) {
      // A point near a facet, on either side.
      const std::size_t t = 3 * (dice.random() % (model.triangles.size() / 3));
      double u = dice.between(0, 1), v = dice.between(0, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const auto corner = [&](std::size_t k) { return model.vertices[model.triangles[t + k]]; };
      const dvec3 p =
          corner(0) + u * (corner(1) - corner(0)) + v * (corner(2) - corner(0)) + dice.anywhere(0.3);
      if (std::abs(depth::winding(model, p)) > 0.5) continue;
      const double within = dice.between(0.2, 4);
      SceneWalls::WallList list;
      SceneWalls::NearFacets facets;
      const int count = walls.walls_at(0, {}, layout.frame().volume_from_world(p), within, list, &facets);
      ++(facets.is_complete ? complete : incomplete);
      for (int k = 0; facets.is_complete && k < 20; ++k) {
        const dvec3 motion = dice.anywhere(1), end = p + dice.between(0, within) * glm::normalize(motion);
        const bool is_before = std::all_of(list.begin(), list.begin() + count, [&](const Wall& wall) {
          return walls.value_and_gradient(wall, layout.frame().volume_from_world(end)).value < -1e-6;
        });
        if (!is_before) continue;
        ++moved;
        ASSERT_LT(std::abs(depth::winding(model, end)), 0.5) << n;
      }
    }
    EXPECT_GT(complete, 500);
    EXPECT_GT(moved, 2000);
    if (std::string(name) == "star") {
      EXPECT_GT(incomplete, 20);
    }
  }
}

// Bounds from the planes of facets prove motions near models free. No point of the tool enters the model.
TEST(ShellProxy, NoPointEntersAModel) {
  for (const auto& [name, model] : models()) {
    SCOPED_TRACE(name);
    TouchScene scene = scene_of_model(name, model);
    ASSERT_FALSE(set_tool(scene, shell_of({-6, 6, 1.5}, 0.8)));
    Dice dice;
    int touching = 0;
    for (int play = 0; play < (runs_all_cases() ? 40 : 6); ++play) {
      ShellPlay run(scene);
      Placement hand{{dice.between(-4, 4), dice.between(-4, 4), 20}, rotation_of(dice.anywhere(1))};
      dvec3 target(0), turn(0);
      for (int i = 0; i < 120; ++i) {
        if (i % 15 == 0) target = dice.anywhere(8), turn = dice.anywhere(0.15);
        hand.position_world += dice.between(0.02, 0.3) * (target - hand.position_world);
        hand.rotation = glm::normalize(rotation_of(turn) * hand.rotation);
        const ProxyStep r = run.step(hand);
        touching += r.has_contact;
        const Placement tool = run.tool(r);
        for (const PointShell::Point& point : scene.tool->shell()->points())
          ASSERT_LT(std::abs(depth::winding(model, tool.world_from_local(point.position))), 0.5)
              << play << ' ' << i;
      }
    }
    EXPECT_GT(touching, 100);
  }
}

// The end of a thick rod is pressed flat on a model: thousands of points touch at once.
TEST(ShellProxy, AModelUnderThousandsOfPointsReleasesAndCarriesTheTool) {
  for (const bool is_moving : {false, true}) {
    TouchScene scene = scene_with("sphere", {{"radius", 5}}, std::make_shared<const ToolShape>());
    const depth::Model plate = depth::box({-20, -20, 36}, {20, 20, 40});
    TouchItem item = mesh_item("plate", std::make_shared<MeshTree>(plate.vertices, plate.triangles));
    if (is_moving) item.mover = 0;
    scene.items.push_back(item);
    ASSERT_FALSE(set_tool(scene, shell_of({0, 20, 8}, 0.25)));
    ShellPlay run(scene);
    Placement place;
    const std::span<const Placement> movers(&place, is_moving);
    ProxyStep r;
    for (int i = 0; i < 150; ++i) r = run.step({{0, 0, std::max(39.0, 50 - 0.1 * i)}, {1, 0, 0, 0}}, movers);
    EXPECT_NEAR(r.proxy_world.z, 40, 0.01);
    EXPECT_TRUE(r.has_contact);
    for (int i = 0; is_moving && i < 50; ++i) {
      place.position_world.z += 0.02;
      r = run.step({{0, 0, 39}, {1, 0, 0, 0}}, movers);
      EXPECT_FALSE(r.is_buried);
    }
    EXPECT_NEAR(r.proxy_world.z, is_moving ? 41 : 40, 0.01);
    for (int i = 0; i < 40; ++i) r = run.step({{0, 0, 39 + 0.5 * i}, {1, 0, 0, 0}}, movers);
    EXPECT_NEAR(r.proxy_world.z, 58.5, 1e-6);
  }
}

// Matter is cut and the model moves in the same tick: near points are found with the model's new pose.
TEST(ShellProxy, AModelThatMovesWhileMatterIsCutIsNotEntered) {
  const auto tool = shell_of({0, 20, 4}, 0.5);
  TouchScene scene = scene_with("sphere", {{"radius", 5}}, std::make_shared<const ToolShape>());
  const depth::Model plate = depth::box({-20, -20, 36}, {20, 20, 40});
  TouchItem item = mesh_item("plate", std::make_shared<MeshTree>(plate.vertices, plate.triangles));
  item.mover = 0;
  scene.items.push_back(item);
  ASSERT_FALSE(set_tool(scene, tool));
  volume::RemovalEditor editor(uncut_version(scene), solids_of(scene));
  int touching = 0;
  for (int phase = 0; phase < 20; ++phase) {
    ShellPlay run(scene);
    Placement place;
    const std::span<const Placement> movers(&place, 1);
    for (int i = 0; i < 16; ++i) {
      const dvec3 cut(0, 0, 5 - 0.02 * (16 * phase + i));
      editor.remove(volume::Sweep{.start_world = cut, .end_world = cut, .radius_mm = 1});
      run.touch_state = TouchState(std::shared_ptr<const volume::Version>(editor.publish()));
      place.position_world.z = 0.6 * i;
      const ProxyStep r = run.step({{0, 0, 48 + 0.05 * phase - 0.4 * i}, {1, 0, 0, 0}}, movers);
      ASSERT_FALSE(r.is_buried) << phase << ", " << i;
      ASSERT_GT(r.proxy_world.z, 40 + place.position_world.z - 0.01) << phase << ", " << i;
      touching += r.has_contact;
    }
  }
  EXPECT_GT(touching, 100);
}

}  // namespace
}  // namespace trephine::haptics
