// Coulomb friction on curved walls and in grooves. The force stays within the friction cone of the touched
// walls, judged by formulas, and slip generates no energy.
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "haptics/methods/methods.h"
#include "haptics/proxy/friction.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

constexpr double k_static = 0.4, k_dynamic = 0.3;

/// Returns a scene of a grey volume in voxels of 0.5 mm. Its surface is the zero set of `distance` (mm,
/// negative in matter).
TouchScene scene_of(const std::function<double(const dvec3&)>& distance, double half_width = 14) {
  TouchScene scene = scenes::scene_of(
      scenes::sampled(dvec3(-half_width), dvec3(half_width), dvec3(0.5),
                      [&](const dvec3& p) { return std::clamp(300 - 600 * distance(p), -1000.0, 3000.0); }));
  scene.items[0].material = {0.5, 0, k_static, k_dynamic};
  return scene;
}

/// Drags the HIP along `place(t)`, t in [0, 1], after pressing at place(0) from `above`. Calls see(step, hip)
/// for the second half of the path.
void drag(const TouchScene& scene, const std::string& name, const dvec3& above,
          const std::function<dvec3(double)>& place,
          const std::function<void(const ProxyStep&, const dvec3&)>& see) {
  const auto method = make_method(name).value();
  ASSERT_FALSE(method->prepare(scene)) << name;
  const auto seen = std::make_shared<const TouchState>(uncut_version(scene));
  ProxyState state;
  constexpr int k_press = 200, k_ticks = 2000;
  for (int i = 0; i <= k_press; ++i)
    method->step(scene, *seen, state, {above + i / static_cast<double>(k_press) * (place(0) - above)});
  for (int i = 1; i <= k_ticks; ++i) {
    const dvec3 hip = place(i / static_cast<double>(k_ticks));
    const ProxyStep step = method->step(scene, *seen, state, {hip});
    if (2 * i > k_ticks) see(step, hip);
  }
}

/// Returns the ratio of the tangential to the normal force, by the exact normal of the surface at the proxy.
double ratio_at(const ProxyStep& step, const dvec3& hip, const dvec3& normal) {
  const dvec3 force = step.proxy_world - hip;
  const double press = glm::dot(force, normal);
  return glm::length(force - press * normal) / press;
}

/// Returns a point on a circle about z, by its angle in rad.
dvec3 on_circle(double radius, double angle) {
  return radius * dvec3(std::cos(angle), std::sin(angle), 0.02);
}

TEST(FrictionCone, HoldsOnConvexAndConcaveBone) {
  struct Case {
    const char* name;
    double radius;
    bool is_cavity;
  };
  for (const Case& c :
       {Case{"ball", 10, false}, Case{"ball", 4, false}, Case{"cavity", 3, true}, Case{"cavity", 8, true}}) {
    const double sign = c.is_cavity ? -1 : 1;
    const TouchScene scene = scene_of([&](const dvec3& p) { return sign * (glm::length(p) - c.radius); });
    for (const char* name : {"subvoxel", "scene", "explicit", "mesh"})
      for (const double press : {0.5, 1.5, 3.0}) {
        // If the HIP is near the centre of a ball, the pull is almost normal to the surface, and nothing
        // slips.
        if (!c.is_cavity && press > 0.5 * c.radius) continue;
        double least = 1e9, most = 0;
        long count = 0;
        drag(
            scene, name, c.is_cavity ? dvec3(0.1, 0, 0) : on_circle(c.radius + 1, 0),
            [&](double t) { return on_circle(c.radius - sign * press, 2 * t); },
            [&](const ProxyStep& step, const dvec3& hip) {
              ASSERT_TRUE(step.has_contact);
              const double ratio = ratio_at(step, hip, sign * glm::normalize(step.proxy_world));
              least = std::min(least, ratio), most = std::max(most, ratio), ++count;
            });
        EXPECT_GT(count, 900);
        // The normals of facets differ from those of the ball by some degrees. The pull stays within the
        // cones of the facets, but the ratio is computed with the normal of the ball.
        const bool is_of_facets = std::string(name) == "explicit" || std::string(name) == "mesh";
        const double off = is_of_facets ? 0.13 + 0.3 / c.radius : 0.012 + 0.01;
        EXPECT_NEAR(least, k_dynamic, off) << c.name << c.radius << name << press;
        EXPECT_NEAR(most, k_dynamic, off) << c.name << c.radius << name << press;
      }
  }
}

TEST(FrictionCone, StaticFrictionHoldsUpToItsCone) {
  const TouchScene scene = scene_of([](const dvec3& p) { return glm::length(p) - 10; });
  for (const char* name : {"subvoxel", "scene", "explicit", "mesh"}) {
    const auto method = make_method(name).value();
    ASSERT_FALSE(method->prepare(scene));
    const auto seen = std::make_shared<const TouchState>(uncut_version(scene));
    ProxyState state;
    for (int i = 0; i <= 400; ++i) method->step(scene, *seen, state, {on_circle(11 - 0.005 * i, 0.3)});
    const dvec3 at = method->step(scene, *seen, state, {on_circle(9, 0.3)}).proxy_world;
    double most = 0;
    for (int i = 1; i <= 400; ++i) {
      const dvec3 hip = on_circle(9, 0.3 + 2e-4 * i);
      const ProxyStep step = method->step(scene, *seen, state, {hip});
      if (glm::length(step.proxy_world - at) > 1e-6) break;
      most = std::max(most, ratio_at(step, hip, glm::normalize(step.proxy_world)));
    }
    EXPECT_NEAR(most, k_static, name[0] == 's' ? 0.01 : 0.05) << name;
  }
}

TEST(FrictionCone, BothWallsOfAGrooveCount) {
  for (const double degrees : {90.0, 60.0, 30.0}) {
    const double half = 0.5 * degrees * 3.14159265358979 / 180;
    // A V-shaped groove along z that opens toward +y.
    const dvec3 left(-std::cos(half), -std::sin(half), 0), right(std::cos(half), -std::sin(half), 0);
    const TouchScene scene =
        scene_of([&](const dvec3& p) { return -std::max(glm::dot(p, left), glm::dot(p, right)) - 0.0; });
    for (const char* name : {"subvoxel", "scene"}) {
      double least = 1e9, most = 0;
      drag(
          scene, name, dvec3(0, 5, -8), [&](double t) { return dvec3(0, -1.5, -8 + 16 * t); },
          [&](const ProxyStep& step, const dvec3& hip) {
            const dvec3 force = step.proxy_world - hip;
            const double ratio = std::abs(force.z) / force.y;
            least = std::min(least, ratio), most = std::max(most, ratio);
          });
      const double expected = k_dynamic / std::sin(half);
      EXPECT_NEAR(least, expected, 0.12 * expected) << degrees << name;
      EXPECT_NEAR(most, expected, 0.12 * expected) << degrees << name;
    }
  }
}

/// With the HIP fixed, a slip of the proxy never increases the energy of the spring.
TEST(FrictionCone, SlipsMakeNoEnergy) {
  for (const bool is_cavity : {false, true}) {
    const double radius = is_cavity ? 3 : 8, sign = is_cavity ? -1 : 1;
    TouchScene scene = scene_of([&](const dvec3& p) { return sign * (glm::length(p) - radius); });
    for (const char* name : {"subvoxel", "scene"}) {
      const auto method = make_method(name).value();
      ASSERT_FALSE(method->prepare(scene));
      const auto seen = std::make_shared<const TouchState>(uncut_version(scene));
      ProxyState state;
      const double stiffness = scene.items[0].material.stiffness;
      double most = 0, stored = 0;
      dvec3 last_hip(0), last_proxy(0);
      bool had_contact = false;
      for (int i = 0; i < 6000; ++i) {
        const double press = 1.5 + 1.2 * std::sin(0.013 * i), angle = 1.5 * std::sin(0.004 * i);
        const dvec3 hip = on_circle(radius - sign * std::min(press, 0.01 * i - 1), angle);
        const ProxyStep step = method->step(scene, *seen, state, {hip});
        // `stored`: energy with the HIP at its new position and the proxy at its old one. A slip may only
        // lower it.
        const double now = 0.5 * stiffness * glm::dot(step.proxy_world - hip, step.proxy_world - hip);
        if (had_contact && step.has_contact) {
          stored = 0.5 * stiffness * glm::dot(last_proxy - hip, last_proxy - hip);
          most = std::max(most, now - stored);
        }
        had_contact = step.has_contact, last_proxy = step.proxy_world, last_hip = hip;
      }
      EXPECT_LT(most, 1e-9) << name << is_cavity;
    }
  }
}

TEST(FrictionCone, LoadsAreSplitAmongWalls) {
  HoldingWalls one;
  one.add({0, 0, -1}, 0.3);
  const FrictionLoad flat = friction_load(one, {0.5, 0, -2});
  EXPECT_NEAR(flat.along, 0.5, 1e-12);
  EXPECT_NEAR(flat.limit, 0.6, 1e-12);
  HoldingWalls groove;
  const double c = std::sqrt(0.5);
  groove.add({c, 0, -c}, 0.3);
  groove.add({-c, 0, -c}, 0.1);
  const FrictionLoad both = friction_load(groove, {0, 1, -2});
  EXPECT_NEAR(both.along, 1, 1e-12);
  EXPECT_NEAR(both.limit, 0.4 * std::sqrt(2.0), 1e-12);
  // A pull away from the second wall loads the first wall only.
  const FrictionLoad left = friction_load(groove, {3, 0, -2});
  EXPECT_NEAR(left.limit, 0.3 * 5 * c, 1e-12);
  HoldingWalls corner = groove;
  corner.add({0, -1, 0}, 0.2);
  EXPECT_EQ(friction_load(corner, {0, -1, -2}).along, 0);
  EXPECT_FALSE(friction_load(one, {0, 0, 1}).is_held());
}

}  // namespace
}  // namespace trephine::haptics
