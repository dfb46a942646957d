// Lomi: the published method of touching depth images, unchanged.
#include "haptics/baselines/lomi.h"

#include <cmath>
#include <set>
#include <tuple>

#include "haptics/baselines/depth_parts.h"
#include "haptics/baselines/lomi_proxy.h"
#include "haptics/depth/depth_items.h"
#include "haptics/depth/depth_rules.h"
#include "tests/haptics/depth/model_play.h"

namespace trephine::haptics::depth {
namespace {

using namespace baselines;

using glm::dvec3;
using glm::ivec3;

TEST(Lomi, QueriesNoVoxelTwiceAndStoresNone) {
  std::set<std::tuple<int, int, int>> queried;
  const LomiOptions options{0.2, 31, 0, false};
  const dvec3 middle(0);
  long walks = 0, longest = 0;
  for (std::uint64_t n = 0; n < 300; ++n) {
    queried.clear();
    // An inclined surface with a bend at x = 0, and a hand deep below it.
    const dvec3 slope = glm::normalize(dvec3(number(4 * n) - 0.5, number(4 * n + 1) - 0.5, 1.2));
    const auto inside = [&](const dvec3& p) {
      const auto voxel = [&](double x) { return static_cast<int>(std::lround(x / 0.2)); };
      EXPECT_TRUE(queried.insert({voxel(p.x), voxel(p.y), voxel(p.z)}).second) << n;
      return glm::dot(slope, p) + 0.3 * std::abs(p.x) < -0.05;
    };
    LomiRest rest;
    const dvec3 hip = dvec3(4 * number(4 * n + 2) - 2, 4 * number(4 * n + 3) - 2, -2);
    const dvec3 position = walk_abstract_lomi(middle, hip, options, inside, rest);
    EXPECT_EQ(rest.stored, 0);
    walks += position != middle, longest = std::max(longest, static_cast<long>(rest.queries));
    EXPECT_LT(rest.queries, 500);
  }
  EXPECT_GT(walks, 200);
  EXPECT_GT(longest, 60);
}

/// On a ball, with the abstract and the physical map: the proxy is outside, within a voxel of the surface.
TEST(Lomi, RestsOnABallToTheAccuracyOfItsVoxels) {
  const auto inside = [](const dvec3& p) { return glm::length(p) < 20; };
  for (const bool is_physical : {false, true})
    for (const double resolution : {0.7, 0.4, 0.2}) {
      double worst = 0, aside = 0;
      int queried = 0;
      for (std::uint64_t n = 0; n < 200; ++n) {
        const double a = 6.283 * number(5 * n), z = 2 * number(5 * n + 1) - 1, r = std::sqrt(1 - z * z);
        const dvec3 out(r * std::cos(a), r * std::sin(a), z);
        const LomiOptions options{resolution, lomi_voxels(2, resolution), 4, is_physical};
        const LomiRest rest = find_rest(20.5 * out, 19.6 * out, options, inside, inside);
        ASSERT_TRUE(rest.is_blocked());
        worst = std::max(worst, glm::length(rest.position) - 20);
        ASSERT_GE(glm::length(rest.position), 20 - 1e-9);
        aside = std::max(aside, glm::length(rest.position - glm::dot(rest.position, out) * out));
        queried = std::max(queried, rest.queries);
        EXPECT_EQ(rest.stored, is_physical ? options.voxels * options.voxels * options.voxels : 0);
      }
      EXPECT_LT(worst, resolution) << is_physical;
      EXPECT_LT(aside, 2 * resolution) << is_physical;
      if (!is_physical) {
        EXPECT_LT(queried, 250);
      }
    }
}

/// The three cases of the published method, on a plate of 1 mm.
TEST(Lomi, HoldsInsideReleasesOutsideAndHoldsBeyondThinMatter) {
  const auto inside = [](const dvec3& p) { return std::abs(p.z) < 0.5; };
  const LomiOptions options;
  const dvec3 from(0, 0, 0.6);
  const LomiRest in = find_rest(from, dvec3(0.3, 0, -0.2), options, inside, inside);
  EXPECT_EQ(in.hip_case, HipCase::stays_inside);
  EXPECT_NEAR(in.position.z, 0.5, 0.2);
  EXPECT_NEAR(in.position.x, 0.3, 0.1);
  const LomiRest out = find_rest(from, dvec3(0.3, 0, 0.7), options, inside, inside);
  EXPECT_EQ(out.hip_case, HipCase::moves_out);
  EXPECT_EQ(out.position, dvec3(0.3, 0, 0.7));
  const LomiRest through = find_rest(from, dvec3(0.3, 0, -1.2), options, inside, inside);
  EXPECT_EQ(through.hip_case, HipCase::passes_thin_part);
  EXPECT_GT(through.position.z, 0.4);  // the first collision counts
}

TEST(Lomi, RunsAsAMethodOnAScan) {
  Play play("lomi", scenes::phantom_scene("sphere", phantom_options(128, 1.5)));
  play.no_friction();
  double worst = 0;
  long count = 0;
  const PosePath path = scenes::sphere_slide(45, 1.0, 100, 2);
  for (const auto& sample : path.samples()) {
    const ProxyStep s = play.step(sample.pose.position_world);
    ASSERT_TRUE(std::isfinite(glm::length(s.proxy_world)));
    if (!s.has_contact || sample.t < 0.1) continue;
    worst = std::max(worst, std::abs(glm::length(s.proxy_world) - 45));
    ++count;
  }
  EXPECT_GT(count, 1800);
  EXPECT_LT(worst, 0.2);  // the requested resolution
}

TEST(Lomi, FarHandsAreHarmless) {
  Play play("lomi", scenes::phantom_scene("sphere", phantom_options(32, 1.5)));
  for (const double far : {1e3, 1e9, 1e150, -1e150, 1e300}) {
    play.state = {};
    play.method->step(play.scene, *play.touch_state, play.state, {dvec3(70, 0, 0)});
    for (const dvec3& hip : {dvec3(far, 0, 0), dvec3(0), dvec3(0, far, far)}) {
      const ProxyStep s = play.method->step(play.scene, *play.touch_state, play.state, {hip});
      ASSERT_TRUE(std::isfinite(s.proxy_world.x)) << far;
    }
  }
}

/// A hand slides along a plate. The published friction moves the end of the spring from the true (final)
/// position back to the temporary position. It grows with the path per tick up to the edge of the friction
/// cone, and vanishes for a hand at rest.
TEST(Lomi, FrictionIsTheOffsetFromTheTrueToTheTemporaryPosition) {
  Model plate = box({-30, -30, -4}, {30, 30, 0});
  const auto slide = [&](double friction, double mm_per_tick, double& behind, double& at_rest) {
    TouchScene scene = models({plate});
    scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = friction;
    ModelPlay play("lomi", std::move(scene));
    for (int i = 0; i < 100; ++i) play.step({-10, 0.05, 1 - 0.02 * i});  // 1 mm deep
    double sum = 0, last = 0;
    int count = 0;
    for (int i = 1; i <= 60; ++i) {
      const dvec3 hip(-10 + mm_per_tick * i, 0.05, -1);
      const ProxyStep s = play.step(hip);
      EXPECT_TRUE(s.has_contact);
      last = s.proxy_world.x - hip.x;
      EXPECT_NEAR(s.proxy_world.z, 0, 0.2);
      if (i > 20) sum += last, ++count;
    }
    behind = -sum / count;
    ProxyStep s;
    const dvec3 rest(-10 + 60 * mm_per_tick, 0.05, -1);
    for (int i = 0; i < 20; ++i) s = play.step(rest);
    at_rest = -(s.proxy_world.x - rest.x);
  };
  double behind = 0, at_rest = 0;
  slide(0, 0.3, behind, at_rest);
  EXPECT_NEAR(behind, 0, 0.02);
  slide(0.4, 0.1, behind, at_rest);  // 100 mm/s: the path of one tick
  EXPECT_NEAR(behind, 0.1, 0.05);
  EXPECT_NEAR(at_rest, 0, 0.02);
  slide(0.2, 0.4, behind, at_rest);  // 400 mm/s: the cone's edge at 1 mm
  EXPECT_NEAR(behind, 0.2, 0.05);
  EXPECT_NEAR(at_rest, 0, 0.02);
}

/// The face of the box passes through lattice points. Half a pixel below the face the nearest pixel changes,
/// and the rounding decides whether a position is inside.
TEST(Lomi, AHandBetweenTwoPixelsIsHeld) {
  for (const double step : {0.02, 0.05, 0.1}) {
    ModelPlay play("lomi", models({box({-5, -5, -4}, {5, 5, 0})}));
    ProxyStep s;
    for (int i = 0; i * step < 2; ++i) s = play.step({-1, 0.05, 1 - step * i});
    EXPECT_TRUE(s.has_contact) << step;
    EXPECT_NEAR(s.proxy_world.z, 0, 0.2) << step;
  }
}

/// Compares the parts of an object with all layers of its images, voxel by voxel. Without parts, the
/// outermost layers of a calabash (a hollow ball) miss its cavity.
TEST(Lomi, PartsOfAConcaveObjectMissNothing) {
  Model calabash = ball(dvec3(0), 10, 90);
  calabash.add(ball(dvec3(0.3, -0.2, 0.1), 7, 90).inward());
  // Six plates with open edges between them; still, no camera sees all of the interior.
  Model crate;
  for (const double at : {-6.0, 5.0}) {
    crate.add(box({at, -4, -4}, {at + 1, 4, 4}));
    crate.add(box({-4, at, -4}, {4, at + 1, 4}));
    crate.add(box({-4, -4, at}, {4, 4, at + 1}));
  }
  const Model full = ball(dvec3(0), 10, 90);
  for (const auto& [model, hides] :
       {std::pair(calabash, true), std::pair(crate, true), std::pair(full, false)}) {
    const TouchScene scene = models({model});
    const DepthCube cube = std::move(cubes_of(scene, {0.2, 1}).value()[0]);
    const DepthParts parts(cube);
    EXPECT_EQ(parts.count() > 1, hides);
    EXPECT_LT(parts.count(), 300u);
    long hidden = 0, inside = 0, differ = 0;
    ivec3 v;
    for (v.z = 0; v.z < cube.size().z; ++v.z)
      for (v.y = 0; v.y < cube.size().y; ++v.y)
        for (v.x = 0; v.x < cube.size().x; ++v.x) {
          const bool is_matter = cube.is_inside(dvec3(v), Layers::all);
          inside += is_matter;
          differ += parts.is_inside(cube, dvec3(v)) != is_matter;
          hidden += cube.is_inside(dvec3(v), Layers::outermost) != is_matter;
        }
    EXPECT_GT(inside, 1000);
    EXPECT_EQ(differ, 0);
    EXPECT_EQ(hidden > 0, hides);  // planted fault: without parts, positions are misjudged
  }
}

TEST(Lomi, OnlyLomiPartsTouchesTheCavityOfACalabash) {
  Model calabash = ball(dvec3(0), 20, 300);
  calabash.add(ball(dvec3(0), 15, 300).inward());
  for (const bool is_whole : {true, false}) {
    ModelPlay play(is_whole ? "lomi" : "lomi-parts", models({calabash}));
    play.step(dvec3(0));
    long contacts = 0;
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
      const double a = 0.0031 * i, z = 0.8 * std::sin(0.0017 * i), r = std::sqrt(1 - z * z);
      const dvec3 out(r * std::cos(a), r * std::sin(a), z);
      const ProxyStep s = play.step((i < 160 ? 0.1 * i : 16) * out);
      contacts += s.has_contact;
      if (i > 200) worst = std::max(worst, std::abs(glm::length(s.proxy_world) - 15));
    }
    if (is_whole) {
      EXPECT_EQ(contacts, 0);  // to six cameras around the calabash it is solid
    } else {
      EXPECT_GT(contacts, 1800);
      EXPECT_LT(worst, 0.2);
    }
  }
}

}  // namespace
}  // namespace trephine::haptics::depth
