// ShellProxy: whole tools against solids whose distance has a formula. The judge samples the tool densely and
// independently of the method.
#include "haptics/proxy/shell_proxy.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

#include "apps/bench/scenes/guaranteed_solid.h"
#include "haptics/methods/methods.h"
#include "haptics/tool/point_shell.h"
#include "tests/haptics/proxy/shell_fixture.h"
#include "tests/whole.h"
#include "volume/cuts/removal.h"

namespace trephine::haptics {
namespace {

using glm::dquat;
using glm::dvec3;

/// Returns the largest depth (mm) of the rod in a solid, from samples of the rod's surface that are
/// independent of the points of the shell.
double depth_of(const Rod& rod, const Placement& tool, const std::function<double(const dvec3&)>& distance) {
  double deepest = -1e300;
  for (int i = 0; i <= 300; ++i)
    for (int k = 0; k < 72; ++k) {
      const double angle = k * 2 * 3.14159265358979 / 72, z = rod.low + (rod.high - rod.low) * i / 300;
      for (const double share : {1.0, 0.5})
        if (share == 1 || i == 0 || i == 300)
          deepest =
              std::max(deepest, -distance(tool.world_from_local({share * rod.radius * std::cos(angle),
                                                                 share * rod.radius * std::sin(angle), z})));
    }
  return deepest;
}

/// Returns the number of the shell's points in a solid, by an evaluation that shares no code with the method.
int points_in(const verify::SmoothSolid& solid, const TouchScene& scene, const Placement& tool) {
  int count = 0;
  for (const PointShell::Point& point : scene.tool->shell()->points())
    count += solid.is_solid(scene.base->frame.volume_from_world(tool.world_from_local(point.position)));
  return count;
}

struct Solid {
  const char* phantom;
  std::map<std::string, double> parameters;
};
const std::vector<Solid>& solids() {
  static const std::vector<Solid> all{{"plane", {{"angle", 0}}},
                                      {"sphere", {{"radius", 20}}},
                                      {"torus", {{"major", 25}, {"minor", 10}}},
                                      {"plate", {{"thickness", 6}, {"angle", 20}}}};
  return all;
}

TEST(ShellProxy, StaysOutsideUnderAnyMotion) {
  double deepest[2] = {0, 0};
  int touching = 0, entered = 0, followed = 0;
  for (const Solid& solid : solids())
    for (const bool is_thick : {false, true}) {
      const double spacing = is_thick ? 0.9 : 0.5;
      const TouchScene scene = scene_with(solid.phantom, solid.parameters, shell_of(k_shaft, spacing),
                                          [&](data_tools::PhantomOptions& o) {
                                            if (!is_thick) return;
                                            o.size.reset();
                                            o.spacing_mm = dvec3(1, 1, 2.5);
                                            o.shear_degrees = 15;
                                          });
      const verify::SmoothSolid smooth = scenes::touched_smooth_solid(scene, nullptr);
      const auto distance = [&](const dvec3& p) {
        return data_tools::phantom_distance(solid.phantom, solid.parameters, p);
      };
      std::mt19937 random(is_thick ? 5 : 4);
      const auto between = [&](double a, double b) {
        return a + (b - a) * (double(random()) / 4294967296.0);
      };
      ShellPlay run(scene);
      Placement hand{{0, 0, 40}, {1, 0, 0, 0}};
      dvec3 motion(0), spin(0);  // per tick
      for (int tick = 0; tick < 3000; ++tick) {
        if (tick % 40 == 0) {
          const dvec3 target(between(-25, 25), between(-25, 25), between(-15, 30));
          motion = (target - hand.position_world) / 40.0;  // up to 2 m/s
          spin = 0.005 * dvec3(between(-2, 2), between(-2, 2), between(-2, 2));
        }
        hand = {hand.position_world + motion, glm::normalize(rotation_of(spin) * hand.rotation)};
        const ProxyStep r = run.step(hand);
        touching += r.has_contact;
        ASSERT_TRUE(std::isfinite(r.proxy_world.x + r.turn_world.x));
        if (tick % 5 != 0) continue;
        const Placement tool = run.tool(r);
        entered += points_in(smooth, scene, tool);
        followed += points_in(smooth, scene, hand);  // planted fault: a tool that follows the hand
        deepest[is_thick] = std::max(deepest[is_thick], depth_of(k_shaft, tool, distance));
      }
    }
  EXPECT_GT(touching, 2000);
  EXPECT_EQ(entered, 0);
  EXPECT_GT(followed, 1000);
  // Tolerances: error of the smooth solid (cubic voxels of 1.25 mm, sheared slices of 2.5 mm) plus the gaps
  // between the points of the shell.
  EXPECT_LT(deepest[false], 0.2) << "mm";
  EXPECT_LT(deepest[true], 0.6) << "mm";
  RecordProperty("deepest_mm", std::to_string(deepest[false]));
  RecordProperty("deepest_thick_mm", std::to_string(deepest[true]));
}

// Statics of a lever: a rod lies on a plane, and is pressed and tilted.
TEST(ShellProxy, ARodOnAPlaneIsALever) {
  const Rod rod{-15, 15, 1.5};
  const TouchScene frictionless = [&] {
    TouchScene scene = scene_with("plane", {{"angle", 0}}, shell_of(rod, 0.4));
    scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = 0;
    return scene;
  }();
  const double square = frictionless.tool->gyration_square(), quarter = 0.5 * 3.14159265358979;
  double worst_height = 0, worst_turn = 0;
  for (const double tilt : {0.0, 0.05, 0.2, -0.2})
    for (const double z : {1.0, 0.0, -4.0}) {
      ShellPlay run(frictionless);
      ProxyStep r;
      for (int i = 0; i < 1500; ++i)
        r = run.step({{0, 0, std::max(z, 30 - 0.05 * i)},
                      rotation_of({0, -std::min(1.0, i / 300.0) * tilt, 0}) * rotation_of({0, quarter, 0})});
      // Height of the axis: radius cos|a| + half sin|a|; at rest, the sum of the energies of both springs is
      // least.
      double best = 0, least = 1e300;
      for (double a = 0; a <= std::abs(tilt); a += 1e-5) {
        const double height = std::max(z, 1.5 * std::cos(a) + 15 * std::sin(a));
        const double e = std::pow(height - z, 2) + 8 * square * (1 - std::cos(0.5 * (std::abs(tilt) - a)));
        if (e < least) least = e, best = a;
      }
      const double height = std::max(z, 1.5 * std::cos(best) + 15 * std::sin(best));
      worst_height = std::max(worst_height, std::abs(r.proxy_world.z - height));
      worst_turn = std::max(worst_turn, std::abs(glm::length(r.turn_world) - (std::abs(tilt) - best)));
      ASSERT_GT(r.contacts.size(), 0u);
    }
  EXPECT_LT(worst_height, 0.06) << "mm";
  EXPECT_LT(worst_turn, 0.005) << "rad";
  RecordProperty("height_mm", std::to_string(worst_height));
  RecordProperty("turn_rad", std::to_string(worst_turn));
}

// A peg in a hole that is 1 mm wider on each side, turned off the axes of the voxels: pressed sideways, it
// leans against the wall; tilted, its lower end and the rim of the hole stop it. The equilibrium of the
// springs is known.
TEST(ShellProxy, APegInAHoleHasTheForceAndTheTorqueOfItsClearance) {
  constexpr double k_hole = 6, k_peg = 5,
                   k_below = 8.5;  // mm; the hand holds the peg in the middle of its contact
  const Rod peg{-k_below, 12, k_peg};
  TouchScene scene = scene_with("hole", {{"radius", k_hole}, {"depth", 20}}, shell_of(peg, 0.5),
                                [](data_tools::PhantomOptions& o) {
                                  o.size = glm::ivec3(192);
                                  o.psf_sigma_voxels = 0;  // a scanner's blur would narrow the hole
                                });
  scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = 0;
  const double square = scene.tool->gyration_square();
  const dvec3 up(0.055787151254673206, -0.18247154975911864, 0.981627183447664),
      across(0.9563047559630354, 0.29237170472273677, 0.0);  // of the phantom "hole"
  const dquat upright(dvec3(0, 0, 1), up);
  const dvec3 middle = -k_below * up;
  const auto settle = [&](const dvec3& aside, double tilt) {
    ShellPlay run(scene);
    ProxyStep r;
    for (int i = 0; i < 900; ++i) {
      const double down = std::max(0.0, 30 - 0.1 * i), share = std::clamp((i - 350) / 300.0, 0.0, 1.0);
      const dvec3 axis = glm::cross(up, across);
      r = run.step({middle + down * up + share * aside, rotation_of(share * tilt * axis) * upright});
    }
    return std::pair(r.proxy_world, glm::length(r.turn_world));
  };
  double worst_force = 0, worst_torque = 0;
  for (const double press : {2.5, 4.0}) {
    const dvec3 hand = middle + press * across;
    const auto [at, turn] = settle(press * across, 0);
    const double exact = press - (k_hole - k_peg);
    worst_force = std::max(worst_force, std::abs(glm::length(hand - at) - exact));
    EXPECT_LT(turn, 0.01);
  }
  for (const double tilt : {0.3, 0.4}) {
    const auto [at, turn] = settle(dvec3(0), tilt);
    // `a`: tilt of the peg; `out`: its motion out of the hole; `s`: its motion aside. The energy of both
    // springs is least.
    double best = 0, least = 1e300;
    for (double a = 0; a <= tilt; a += 1e-4)
      for (double out = -0.5; out <= 1.5; out += 0.01) {
        const double low = k_below * std::sin(a) + k_peg * std::cos(a) - k_hole,
                     high = k_hole - (k_below - out) * std::tan(a) - k_peg / std::cos(a);
        if (low > high) continue;
        const double s = std::clamp(0.0, low, high);
        const double e = s * s + out * out + 8 * square * (1 - std::cos(0.5 * (tilt - a)));
        if (e < least) least = e, best = a;
      }
    worst_torque = std::max(worst_torque, std::abs(turn - (tilt - best)) / (tilt - best));
  }
  EXPECT_LT(worst_force, 0.07) << "mm of the spring: a ninth of a voxel";
  EXPECT_LT(worst_torque, 0.02);
  RecordProperty("force_mm", std::to_string(worst_force));
  RecordProperty("torque_percent", std::to_string(100 * worst_torque));
}

// A rod in a hole that was drilled in the same session: the hole guides the rod, which cannot be levered out
// through the wall.
TEST(ShellProxy, ARodInADrilledHoleIsHeldByIt) {
  const Rod rod{0, 40, 1.2};
  TouchScene scene =
      scene_with("plane", {{"angle", 0}}, shell_of(rod, 0.3), [](data_tools::PhantomOptions& o) {
        o.size.reset();
        o.spacing_mm = dvec3(0.6);
      });
  ASSERT_FALSE(set_smallest_burr(scene, 4));
  std::shared_ptr<volume::Version> version = uncut_version(scene);
  volume::RemovalEditor editor(version, solids_of(scene));
  editor.remove(volume::Sweep{.start_world = {0, 0, 5}, .end_world = {0, 0, -15}, .radius_mm = 2});
  editor.end_stroke();
  ShellPlay run(scene);
  run.touch_state = TouchState(std::shared_ptr<const volume::Version>(editor.publish()));
  // Distance to the bone, negative in bone. The hole is a cylinder of 2 mm radius around z with a round
  // bottom.
  const auto distance = [](const dvec3& p) {
    const double off = std::hypot(p.x, p.y);
    const double from_hole = p.z > -15 ? 2 - off : 2 - glm::length(p - dvec3(0, 0, -15));
    return std::max(p.z, from_hole);
  };
  ProxyStep r;
  double deepest = 0;
  const auto step = [&](const Placement& hand) {
    r = run.step(hand);
    deepest = std::max(deepest, depth_of(rod, run.tool(r), distance));
  };
  for (int i = 0; i <= 400; ++i) step({{0, 0, 20 - 0.1 * i}, {1, 0, 0, 0}});  // 3 mm below the bottom
  EXPECT_NEAR(run.tool(r).position_world.z, -15 - (2 - 2 * (1 - std::sqrt(1 - 0.36))), 0.1);
  // The hand is tilted by 30 degrees as a lever, and moved 16 mm to the side.
  for (int i = 0; i <= 300; ++i) {
    const double share = std::min(1.0, i / 200.0);
    step({{16 * share, 0, -15}, rotation_of({0, 0.52 * share, 0})});
  }
  const Placement tool = run.tool(r);
  // Between two opposite contacts, the rod can tilt by at most (2 * 2 - 2 * 1.2) / 15 = 0.11 rad.
  const dvec3 axis = tool.rotation * dvec3(0, 0, 1);
  EXPECT_GT(axis.z, std::cos(0.13));
  EXPECT_LT(std::hypot(tool.position_world.x, tool.position_world.y), 1.2);
  EXPECT_LT(deepest, 0.15);
  // Nothing else holds the rod: it can be drawn out.
  for (int i = 0; i <= 600; ++i) step({{0, 0, -15 + 0.1 * i}, {1, 0, 0, 0}});
  EXPECT_NEAR(r.proxy_world.z, 45, 0.5);
  EXPECT_FALSE(r.has_contact);
  RecordProperty("deepest_mm", std::to_string(deepest));
}

// A thin plate is not passed at 1 m/s and 10 rad/s.
TEST(ShellProxy, NoPlateIsPassed) {
  const Rod rod{-2, 28, 1.2};
  const std::map<std::string, double> parameters{{"thickness", 2}, {"angle", 20}};
  const TouchScene scene = scene_with("plate", parameters, shell_of(rod, 0.6));
  const dvec3 normal(std::sin(20 * 3.14159265358979 / 180), 0, std::cos(20 * 3.14159265358979 / 180));
  std::mt19937 random(8);
  const auto between = [&](double a, double b) { return a + (b - a) * (double(random()) / 4294967296.0); };
  const int passes = runs_all_cases() ? 20000 : 40;
  for (int pass = 0; pass < passes; ++pass) {
    ShellPlay run(scene);
    const dvec3 from = 45.0 * normal + dvec3(between(-10, 10), between(-10, 10), 0);
    const dvec3 spin(between(-1, 1), between(-1, 1), between(-1, 1));
    Placement hand{from, rotation_of({between(-1.5, 1.5), between(-1.5, 1.5), 0})};
    ProxyStep r = run.step(hand);
    for (int i = 0; i < 90; ++i) {
      hand = {hand.position_world - normal,
              glm::normalize(rotation_of(0.01 * glm::normalize(spin)) * hand.rotation)};
      r = run.step(hand);
    }
    const Placement tool = run.tool(r);
    for (const double z : {rod.low, 0.0, rod.high})
      EXPECT_GT(glm::dot(tool.world_from_local({0, 0, z}), normal), 0) << pass;
  }
}

// A rod that moves toward a wall of a sheared volume, in random poses at random speeds, does not enter it.
TEST(ShellProxy, ShearedVolumesAreNotEntered) {
  for (const double shear : {-45.0, 30.0, 45.0}) {
    data_tools::PhantomOptions o;
    o.spacing_mm = dvec3(2);
    o.shear_degrees = shear;
    volume::Volume v = data_tools::make_phantom("sphere", o).value();
    const int half = v.size.y / 2;
    for (int z = 0; z < v.size.z; ++z)
      for (int y = 0; y < v.size.y; ++y)
        for (int x = 0; x < v.size.x; ++x) v.voxels[v.index(x, y, z)] = y < half ? 1000 : 0;
    volume::Shape low;
    low.low = 40;
    TouchScene scene = scenes::scene_of(std::move(v), {}, low);
    ASSERT_FALSE(set_tool(scene, shell_of({0, 20, 1.5}, 1)));
    const verify::SmoothSolid solid = scenes::touched_smooth_solid(scene, nullptr);
    const volume::Frame& frame = scene.base->frame;
    const dvec3 wall = frame.world_from_volume(0.5 * dvec3(scene.base->size.x, 2 * half, scene.base->size.z)),
                normal = glm::normalize(frame.gradient_world_from_volume(dvec3(0, 1, 0)));
    const dquat upright =
        rotation_of(std::acos(normal.z) * glm::normalize(glm::cross(dvec3(0, 0, 1), normal)));
    std::mt19937 random(1);
    const auto between = [&](double a, double b) { return a + (b - a) * (double(random()) / 4294967296.0); };
    int entered = 0, touching = 0;
    for (int pass = 0; pass < 150; ++pass) {
      ShellPlay run(scene);
      const double speed = between(0.1, 4);  // mm per tick
      Placement hand{wall + between(8, 12) * normal + dvec3(between(-3, 3), between(-3, 3), between(-3, 3)),
                     rotation_of(0.2 * dvec3(between(-1, 1), between(-1, 1), between(-1, 1))) * upright};
      ProxyStep r = run.step(hand);
      for (int i = 0; i < std::min(60.0, 14 / speed + 2); ++i) {
        hand.position_world -= speed * normal;
        r = run.step(hand);
        entered += points_in(solid, scene, run.tool(r));
      }
      touching += r.has_contact;
    }
    EXPECT_EQ(entered, 0) << shear;
    EXPECT_GT(touching, 100) << shear;
  }
}

TEST(ShellProxy, GrownMatterReleasesTheTool) {
  TouchScene scene = scene_with("plane", {{"angle", 0}}, shell_of({0, 40, 1.2}, 0.4));
  ASSERT_FALSE(set_smallest_burr(scene, 6));
  std::shared_ptr<volume::Version> version = uncut_version(scene);
  const TouchState before{std::shared_ptr<const volume::Version>(uncut_version(scene))};
  volume::RemovalEditor editor(version, solids_of(scene));
  editor.remove(volume::Sweep{.start_world = {0, 0, 5}, .end_world = {0, 0, -15}, .radius_mm = 3});
  editor.end_stroke();
  ShellPlay run(scene);
  run.touch_state = TouchState(std::shared_ptr<const volume::Version>(editor.publish()));
  ProxyStep r;
  for (int i = 0; i <= 300; ++i) r = run.step({{0, 0, 20 - 0.1 * i}, {1, 0, 0, 0}});
  EXPECT_LT(r.proxy_world.z, -9);
  run.touch_state = before;
  r = run.step({{0, 0, -10}, {1, 0, 0, 0}});
  EXPECT_TRUE(r.is_buried);
  for (int i = 0; i <= 600; ++i) r = run.step({{0, 0, -10 + 0.1 * i}, {1, 0, 0, 0}});
  EXPECT_NEAR(r.proxy_world.z, 50, 1e-6);
  for (int i = 0; i <= 600; ++i) r = run.step({{0, 0, 50 - 0.1 * i}, {1, 0, 0, 0}});
  EXPECT_GT(r.proxy_world.z, -0.2);
}

TEST(ShellProxy, OtherMethodsRefuseShells) {
  TouchScene scene = scene_with("plane", {}, shell_of(k_shaft, 0.5));
  for (const MethodInfo& info : method_catalogue()) {
    const Status refused = make_method(info.name).value()->prepare(scene);
    EXPECT_EQ(refused.has_value(), !info.takes_shells) << info.name;
  }
  EXPECT_STREQ(general_method(*scene.tool).name, "shell");
  ASSERT_FALSE(set_tool_radius(scene, 0));
  EXPECT_TRUE(ShellProxy().prepare(scene).has_value());
}

}  // namespace
}  // namespace trephine::haptics
