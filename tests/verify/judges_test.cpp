// Judges of apps/verify: each accepts correct results, and detects planted faults.
#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <vector>

#include "apps/verify/ball_judge.h"
#include "apps/verify/exact_traversal.h"
#include "apps/verify/fall_through.h"
#include "apps/verify/force_judge.h"
#include "apps/verify/friction_judge.h"
#include "apps/verify/ideal_proxy.h"
#include "apps/verify/mesh_judge.h"
#include "apps/verify/passage_judge.h"
#include "apps/verify/smooth_judge.h"
#include "apps/verify/tool_judge.h"

namespace trephine::verify {
namespace {

using glm::dvec3;

/// Returns a judge for a grid of 10^3 voxels, of which those up to z = 4 are solid. The surface is at z
/// = 4.5.
FallThroughJudge floor_judge() {
  return FallThroughJudge({10, 10, 10}, [](int, int, int z) { return z <= 4; });
}
void judge_one(FallThroughJudge& judge, const std::vector<dvec3>& path, const dvec3& hip, bool has_contact,
               bool is_buried = false) {
  judge.judge_step({path, hip, has_contact, is_buried});
}

TEST(FallThroughJudge, AcceptsAProxyThatStaysOutside) {
  FallThroughJudge judge = floor_judge();
  judge_one(judge, {{5, 5, 8}}, {5, 5, 8}, false);
  judge_one(judge, {{5, 5, 8}, {5, 5, 6}}, {5, 5, 6}, false);
  judge_one(judge, {{5, 5, 6}, {5, 5, 4.6}}, {5, 5, 1}, true);
  EXPECT_EQ(judge.fall_throughs(), 0);
  EXPECT_EQ(judge.steps(), 3);
  EXPECT_EQ(judge.judged(), 2);  // the first step has no known previous proxy
  judge.restart();
  judge_one(judge, {{5, 5, 2}}, {5, 5, 2}, false);
  judge_one(judge, {{5, 5, 2}, {5, 5, 1}}, {5, 5, 1}, false);
  EXPECT_EQ(judge.judged(), 2);  // a proxy that started inside is not judged
}

/// A proxy without contact must be at the HIP, except for rounding by the transforms between frames.
TEST(FallThroughJudge, ToleratesOnlyRounding) {
  for (const double off : {1e-15, 1e-9}) {
    FallThroughJudge judge = floor_judge();
    judge_one(judge, {{5, 5, 8}}, {5, 5, 8}, false);
    judge_one(judge, {{5, 5, 8}, {5, 5, 7}}, {5, 5, 7 + 4 * off}, false);
    EXPECT_EQ(judge.fall_throughs(), off > 1e-12) << off;
  }
}

TEST(FallThroughJudge, FindsAPathThroughMatterEvenIfBothEndsAreFree) {
  FallThroughJudge judge = floor_judge();
  judge_one(judge, {{5, 5, 8}}, {5, 5, 8}, false);
  judge_one(judge, {{5, 5, 8}, {5, 5, -3}}, {5, 5, -3}, false);
  EXPECT_EQ(judge.fall_throughs(), 1);
}

TEST(FallThroughJudge, FindsAProxyInMatterAJumpAndALostContact) {
  FallThroughJudge in_matter = floor_judge();
  judge_one(in_matter, {{5, 5, 8}}, {5, 5, 8}, false);
  judge_one(in_matter, {{5, 5, 8}, {5, 5, 4.4}}, {5, 5, 1}, true);
  EXPECT_EQ(in_matter.fall_throughs(), 1);
  FallThroughJudge jump = floor_judge();
  judge_one(jump, {{5, 5, 8}}, {5, 5, 8}, false);
  judge_one(jump, {{2, 5, 8}, {2, 5, 7}}, {2, 5, 7}, false);
  EXPECT_EQ(jump.fall_throughs(), 1);
  FallThroughJudge lost = floor_judge();
  judge_one(lost, {{5, 5, 8}}, {5, 5, 8}, false);
  judge_one(lost, {{5, 5, 8}, {5, 5, 6}}, {5, 5, 1}, false);  // no contact, but not at the HIP
  EXPECT_EQ(lost.fall_throughs(), 1);
}

TEST(FallThroughJudge, CountsAStartBuriedByGrowthSeparately) {
  int top = 4;
  FallThroughJudge judge({10, 10, 10}, [&top](int, int, int z) { return z <= top; });
  judge_one(judge, {{5, 5, 8}}, {5, 5, 8}, false);
  top = 8;
  judge.solid_changed();
  judge_one(judge, {{5, 5, 2}}, {5, 5, 2}, false, true);
  EXPECT_EQ(judge.fall_throughs(), 0);
  EXPECT_EQ(judge.buried_starts(), 1);
}

/// A report of "buried" counts as a fall-through if the solid did not change, or if the changed solid does
/// not contain the last proxy.
TEST(FallThroughJudge, UnjustifiedReportsOfGrowthCountAsFallThroughs) {
  FallThroughJudge unchanged = floor_judge();
  judge_one(unchanged, {{5, 5, 8}}, {5, 5, 8}, false);
  for (int i = 0; i < 3; ++i) {
    judge_one(unchanged, {{5, 5, -3}}, {5, 5, -3}, false, true);
    judge_one(unchanged, {{5, 5, 8}}, {5, 5, 8}, false, true);
  }
  EXPECT_EQ(unchanged.fall_throughs(), 6);
  int top = 4;
  FallThroughJudge elsewhere({10, 10, 10}, [&top](int, int, int z) { return z <= top; });
  judge_one(elsewhere, {{5, 5, 8}}, {5, 5, 8}, false);
  top = 6;
  elsewhere.solid_changed();
  judge_one(elsewhere, {{5, 5, -3}}, {5, 5, -3}, false, true);
  EXPECT_EQ(elsewhere.fall_throughs(), 1);
}

TEST(RestingPoint, RollsToThePointAboveTheHip) {
  const dvec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const SolidVoxels floor = [](int, int, int z) { return z <= 4; };
  const dvec3 rest = resting_point_on_cubes({10, 10, 10}, floor, axes, {1, 1, 6}, {7.3, 6.2, 2});
  EXPECT_NEAR(rest.x, 7.3, 1e-9);
  EXPECT_NEAR(rest.y, 6.2, 1e-9);
  EXPECT_NEAR(rest.z, 4.5, 1e-9);
}

/// Returns the rest position of a proxy that starts at `above` with the HIP, which then moves straight to
/// `hip`.
dvec3 rest_of(const Clearance& wall, const dvec3& above, const dvec3& hip) {
  return follow_exactly(wall, 0.5, above, above, hip);
}

TEST(IdealProxy, RestsAtTheAlgebraicSolution) {
  const Clearance ball = [](const dvec3& p) { return glm::length(p) - 10; };
  EXPECT_LT(glm::length(rest_of(ball, {3, -2, 12}, {3, -2, 6}) - 10.0 / 7 * dvec3(3, -2, 6)), 1e-5);
  // V-grooves along y: rests in the groove's edge, and on one flank. Then a corner of three walls: rests in
  // the corner, and on an edge.
  for (const double half : {15.0, 45.0}) {
    const double c = std::cos(half * 0.017453292519943295), s = std::sin(half * 0.017453292519943295);
    const Clearance groove = [=](const dvec3& p) { return std::min(c * p.x + s * p.z, -c * p.x + s * p.z); };
    const dvec3 hip(3, 4, -12);
    EXPECT_LT(glm::length(rest_of(groove, {0, 1, 20}, hip) - dvec3(0, 4, 0)), 1e-4);
    const dvec3 lateral(9, 4, 1), n(-c, 0, s);
    EXPECT_LT(glm::length(rest_of(groove, {0, 1, 20}, lateral) - (lateral - glm::dot(lateral, n) * n)), 1e-4);
  }
  const Clearance corner = [](const dvec3& p) { return std::min({p.x, p.y, p.z}); };
  EXPECT_LT(glm::length(rest_of(corner, {5, 6, 7}, {-3, -1, -2})), 1e-4);
  EXPECT_LT(glm::length(rest_of(corner, {5, 6, 7}, {-3, 2, -1}) - dvec3(0, 2, 0)), 1e-4);
}

TEST(IdealProxy, StaysOnItsSideAndPassesEdges) {
  // A plate 0.5 mm thick, as long as a step of the HIP: the proxy stays above, also if the HIP is far below.
  const Clearance plate = [](const dvec3& p) { return std::abs(p.z) - 0.25; };
  EXPECT_LT(glm::length(rest_of(plate, {0, 0, 5}, {7, 3, -30}) - dvec3(7, 3, 0.25)), 1e-4);
  // A step down: the proxy is held on top until the HIP is past the edge. Then it moves freely to the HIP.
  const Clearance step = [](const dvec3& p) { return std::max(p.z, p.x); };
  const dvec3 above(-4, 0, 1), below(-1, 0, -2), past(1, 0, -2);
  const dvec3 held = follow_exactly(step, 0.5, above, above, below);
  EXPECT_LT(glm::length(held - dvec3(-1, 0, 0)), 1e-4);
  EXPECT_LT(glm::length(follow_exactly(step, 0.5, held, below, past) - past), 1e-4);
  // A proxy that starts in the plate is moved to its surface.
  EXPECT_LT(glm::length(follow_exactly(plate, 0.5, {0, 0, 0.1}, {0, 0, -1}, {0, 0, -1}) - dvec3(0, 0, 0.25)),
            1e-4);
}

TEST(MeshJudge, FindsEveryKindOfFault) {
  std::vector<glm::vec3> v{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5, 0, 0}, {5, 1, 0}, {5, 0, 1}};
  const std::vector<std::uint32_t> tetrahedron{0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  EXPECT_TRUE(judge_mesh(v, tetrahedron).is_closed_manifold());
  EXPECT_NEAR(judge_mesh(v, tetrahedron).signed_volume, 1.0 / 6, 1e-6);
  std::vector<std::uint32_t> faulty = tetrahedron;
  faulty.resize(9);
  EXPECT_EQ(judge_mesh(v, faulty).boundary_edges, 3u);
  faulty = tetrahedron;
  std::swap(faulty[0], faulty[1]);
  EXPECT_EQ(judge_mesh(v, faulty).twisted_edges, 3u);
  faulty = tetrahedron;
  faulty.insert(faulty.end(), {0, 1, 4});
  EXPECT_EQ(judge_mesh(v, faulty).non_manifold_edges, 1u);
  faulty = tetrahedron;
  faulty.insert(faulty.end(), {1, 1, 2});
  EXPECT_EQ(judge_mesh(v, faulty).degenerate_triangles, 1u);
  faulty = tetrahedron;  // a second tetrahedron is attached at vertex 0 only
  faulty.insert(faulty.end(), {0, 5, 4, 0, 4, 6, 4, 5, 6, 0, 6, 5});
  EXPECT_EQ(judge_mesh(v, faulty).pinched_vertices, 1u);
}

/// At one wall, the pull is compared with one friction cone. In a groove, the cones of both walls add up.
TEST(FrictionJudge, HandlesConesAndGrooves) {
  const double mu = 0.2;
  const glm::dvec3 up(0, 0, 1);
  for (const double share : {0.0, 0.1, 0.19, 0.21, 0.5}) {
    const double beyond = distance_from_cone({share, 0, -1}, {up}, mu);
    EXPECT_NEAR(beyond, std::max(0.0, share - mu) / std::sqrt(1 + mu * mu), 1e-6) << share;
  }
  EXPECT_NEAR(distance_from_cone({0.3, 0, 0.4}, {up}, mu), 0.5, 1e-6)
      << "friction does not resist a pull away from the wall";
  // Along a groove, friction resists at most mu / sin(half of the groove's angle) times the pull into the
  // groove.
  for (const double degrees : {90.0, 60.0}) {
    const double half = 0.5 * degrees / 57.29577951308232, most = mu / std::sin(half);
    const std::vector<glm::dvec3> walls{{std::cos(half), 0, std::sin(half)},
                                        {-std::cos(half), 0, std::sin(half)}};
    EXPECT_LT(distance_from_cone({0, 0.99 * most, -1}, walls, mu), 1e-3) << degrees;
    EXPECT_GT(distance_from_cone({0, 2 * most, -1}, walls, mu), 0.1) << degrees;
  }
  // walls_at() finds one wall on a plane and in a wide bowl. In a groove it must find both walls: the pull
  // below is outside the cone of one wall.
  const auto plane = [](const glm::dvec3& p) { return -(0.3 * p.x + p.z); };
  const auto walls = walls_at(plane, glm::dvec3(0), 0.01, 1);
  ASSERT_EQ(walls.size(), 1u);
  EXPECT_NEAR(walls[0].x / walls[0].z, 0.3, 1e-6);
  const auto bowl = [](const glm::dvec3& p) { return glm::length(p - glm::dvec3(0, 0, 5)) - 5; };
  EXPECT_EQ(walls_at(bowl, glm::dvec3(0), 0.01, 1).size(), 1u);
  const auto groove = [](const glm::dvec3& p) { return std::abs(p.x) - p.z; };
  EXPECT_LT(
      distance_from_cone({0, 0.99 * mu * std::sqrt(2.0), -1}, walls_at(groove, {1e-3, 0, 0}, 1e-4, 1), mu),
      1e-3);
}

/// A thin plate with a sharp rim: a path may graze its rim and dip into its faces, but not pass through.
TEST(PassageJudge, DistinguishesThroughFromAround) {
  // A lens of two pyramids over a square, 0.1 thick in its middle.
  const std::vector<glm::dvec3> corners{{-5, -5, 0}, {5, -5, 0},   {5, 5, 0},
                                        {-5, 5, 0},  {0, 0, 0.05}, {0, 0, -0.05}};
  const std::vector<std::uint32_t> triangles{0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4,
                                             1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5};
  PassageJudge judge(MeshWall(corners, triangles, 1.0), 0.2);
  EXPECT_FALSE(judge.passes({1, 1.1, 1}, {1, 1.1, 0.2}));
  EXPECT_TRUE(judge.passes({1, 1.1, 0.2}, {1, 1.1, -0.2}));
  EXPECT_FALSE(judge.passes({1, 1.1, -0.2}, {1, 1.1, -1}));
  judge.restart();
  EXPECT_FALSE(judge.passes({1, 1.1, 0.2}, {1, 1.1, 0.01})) << "within the tolerance";
  EXPECT_TRUE(judge.passes({1, 1.1, 0.01}, {1, 1.1, -0.2})) << "it leaves below";
  judge.restart();
  EXPECT_FALSE(judge.passes({1, 1.1, 0.2}, {1, 1.1, 0.03}));
  EXPECT_FALSE(judge.passes({1, 1.1, 0.03}, {2, 1.1, 0.03})) << "within the tolerance, on one side";
  EXPECT_FALSE(judge.passes({2, 1.1, 0.03}, {4, 1.1, 0.1}));
  judge.restart();
  EXPECT_FALSE(judge.passes({4.9, 1.1, 0.1}, {4.9, 1.1, -0.1})) << "a graze at the rim";
  judge.restart();
  EXPECT_FALSE(judge.passes({6, 1.1, 0.3}, {6, 1.1, -0.3})) << "next to it";
  // Thick matter: a path that enters it deeper than the tolerance is reported once.
  const std::vector<glm::dvec3> cube{{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {9, 9, 0},
                                     {0, 0, 9}, {9, 0, 9}, {0, 9, 9}, {9, 9, 9}};
  PassageJudge thick(
      MeshWall(cube, std::vector<std::uint32_t>{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                                2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5},
               1.0),
      0.2);
  EXPECT_FALSE(thick.passes({-1, 4, 4.1}, {0.2, 4, 4.1}));
  EXPECT_TRUE(thick.passes({0.2, 4, 4.1}, {0.5, 4, 4.1}));
  EXPECT_FALSE(thick.passes({0.5, 4, 4.1}, {4, 4, 4.1})) << "reported once";
  thick.restart();
  EXPECT_FALSE(thick.passes({4, 4, 4.1}, {-1, 4, 4.1})) << "a path from inside";
}

TEST(ExactTraversal, FollowsTheRuleOfThePerturbedLine) {
  // At corners the line is perturbed by (e, e^2, e^3). With increasing coordinates, it crosses x planes
  // before y planes and y planes before z planes; with decreasing coordinates, in the reverse order.
  const auto up = exact_traversal({0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {3, 3, 3});
  ASSERT_EQ(up.size(), 4u);
  EXPECT_EQ(up[1].voxel, (std::array<int, 3>{1, 0, 0}));
  EXPECT_EQ(up[2].voxel, (std::array<int, 3>{1, 1, 0}));
  const auto down = exact_traversal({1, 1, 1}, {0, 0, 0}, {0, 0, 0}, {3, 3, 3});
  ASSERT_EQ(down.size(), 4u);
  EXPECT_EQ(down[1].voxel, up[2].voxel);
  EXPECT_EQ(down[2].voxel, up[1].voxel);
}

/// The judge accepts forces of the law (`wrong` 0), and detects a wrong force (1) and a wrong ledger (2).
TEST(ForceJudge, AcceptsTheLawAndDetectsAWrongForceOrLedger) {
  for (const int wrong : {0, 1, 2}) {
    ForceLaw law;
    ForceJudge judge(law);
    double smoothed = 0, last = 0, energy = 0, last_x = 0, last_stretch = 0;
    for (int i = 0; i < 300; ++i) {
      const double x = -0.01 * i, stretch = -x, k = 0.5, b = 0.001;
      const double spring = k * stretch + (i > 0 ? b / law.dt * (stretch - last_stretch) : 0);
      smoothed = law.alpha * spring + (1 - law.alpha) * smoothed;
      double force = smoothed;
      if (std::abs(force - last) > law.slew * law.dt)
        force = last + (force > last ? 1 : -1) * law.slew * law.dt;
      if (i > 0) energy += last * (x - last_x);
      ForceTick tick;
      tick.position = {x, 0, 0}, tick.proxy = {0, 0, 0};
      tick.force = {wrong == 1 && i == 200 ? force + 0.01 : force, 0, 0};
      tick.stiffness = k, tick.damping = b, tick.has_contact = true;
      tick.contact_energy = energy + (wrong == 2 && i > 100 ? 0.001 : 0);
      judge.judge_tick(tick);
      last = force, last_x = x, last_stretch = stretch;
      if (wrong == 1 && i == 200) energy += 0.01 * -0.01;
    }
    EXPECT_EQ(judge.ticks(), 300);
    EXPECT_EQ(judge.wrong_forces(), wrong == 1 ? 1 : 0) << wrong;
    EXPECT_EQ(judge.worst_energy_nmm() > 1e-4, wrong == 2) << wrong << " " << judge.worst_energy_nmm();
  }
}

/// The tool moves along a wall at a constant depth. Viscosity pulls it back, and the work of this force
/// counts as friction. `wrong` 1: too small a force; 2: the ledger lacks the friction.
TEST(ForceJudge, HandlesViscosityAndTheLedgerOfFriction) {
  for (const int wrong : {0, 1, 2}) {
    ForceLaw law;
    law.alpha = 1;
    ForceJudge judge(law);
    double friction = 0, last = 0;
    for (int i = 0; i < 100; ++i) {
      const double speed = 20, viscosity = 0.004;  // mm/s, N s/mm
      const double drag = i > 0 ? -viscosity * speed : 0;
      if (i > 0) friction += last * speed * law.dt;
      ForceTick tick;
      tick.position = {speed * law.dt * i, 0, -1}, tick.proxy = {speed * law.dt * i, 0, 0};
      tick.normal = {0, 0, 1};
      tick.force = {wrong == 1 ? 0.9 * drag : drag, 0, 0.5};
      tick.stiffness = 0.5, tick.viscosity = viscosity, tick.has_contact = true;
      tick.contact_energy = friction;
      tick.friction_energy = wrong == 2 ? 0 : friction;
      judge.judge_tick(tick);
      last = drag;
    }
    EXPECT_EQ(judge.wrong_forces() > 0, wrong == 1) << judge.worst_force_n();
    EXPECT_EQ(judge.worst_energy_nmm() > 1e-5, wrong > 0) << judge.worst_energy_nmm();
  }
}

/// The tool moves into a spring and out of it in steps of equal length. Forces that are held for a tick would
/// return more energy than they received; the passivity controller limits them at the end. `wrong`: without
/// the controller.
TEST(ForceJudge, HandlesThePassivityController) {
  for (const int wrong : {0, 1}) {
    ForceLaw law;
    law.alpha = 1, law.slew = 1e9, law.is_passive = true;
    ForceJudge judge(law);
    const double step = 0.02, k = 0.5;
    double taken = 0, last = 0, depth = 0;
    long cut = 0;
    for (int i = 0; i < 200; ++i) {
      const bool is_out = i > 100;
      const double before = depth;
      depth += i == 0 ? 0 : is_out ? -step : step;
      taken += last * (depth - before);
      double force = k * depth;
      // If the tool moves out by another step, the force held during that tick returns force * step.
      if (is_out && force * step > std::max(0.0, taken)) force = std::max(0.0, taken) / step, ++cut;
      ForceTick tick;
      tick.position = {0, 0, -depth}, tick.normal = {0, 0, 1};
      tick.force = {0, 0, wrong ? k * depth : force};
      tick.stiffness = k, tick.has_contact = true;
      tick.contact_energy = -taken;
      judge.judge_tick(tick);
      last = force;
    }
    EXPECT_GT(cut, 0);
    EXPECT_EQ(judge.wrong_forces() > 0, wrong == 1) << judge.worst_force_n();
  }
}

/// A push and a spring act in free space. The judge detects a missing effect (`wrong` 1), and energy in the
/// wrong entry of the ledger (2).
TEST(ForceJudge, HandlesEffects) {
  for (const int wrong : {0, 1, 2}) {
    ForceLaw law;
    law.slew = 1e9;
    law.effects.resize(2);
    law.effects[0].position = {0.5, 0, 0};
    law.effects[1].kind = EffectLaw::Kind::spring;
    law.effects[1].strength = 0.1;
    ForceJudge judge(law);
    double active = 0, contact = 0, last_spring = 0;
    for (int i = 0; i < 100; ++i) {
      const double x = 0.01 * i, spring = -0.1 * x;
      if (i > 0) active += 0.5 * 0.01, contact += last_spring * 0.01;
      ForceTick tick;
      tick.position = tick.proxy = {x, 0, 0};
      tick.force = {wrong == 1 ? 0.5 : 0.5 + spring, 0, 0};
      tick.contact_energy = wrong == 2 ? active + contact : contact;
      tick.active_energy = wrong == 2 ? 0 : active;
      judge.judge_tick(tick);
      last_spring = spring;
    }
    EXPECT_EQ(judge.wrong_forces() > 0, wrong == 1) << judge.worst_force_n();
    EXPECT_EQ(judge.worst_energy_nmm() > 1e-4, wrong > 0) << judge.worst_energy_nmm();
  }
}

/// A path through a wall one voxel thick is blocked, and a path in front of the wall is free. A cut in the
/// wall frees the path through it.
TEST(SmoothSolid, BlocksPathsThroughMatterHoweverThin) {
  const Samples wall = [](int x, int, int) { return x == 5 ? 1.0 : -1.0; };
  const SmoothSolid solid(wall);
  EXPECT_TRUE(solid.is_solid({5, 0.3, 0.2}));
  EXPECT_FALSE(solid.is_free({0, 0, 0}, {10, 0.4, 0.7}));
  EXPECT_TRUE(solid.is_free({0, 0, 0}, {4, 3, 2}));
  EXPECT_FALSE(solid.is_free({5, 0, 0}, {5, 0, 0}));
  const SmoothSolid cut(std::vector<SampledField>{{wall}, {[](int, int y, int) { return y - 10.0; }}});
  EXPECT_TRUE(cut.is_free({0, 0, 0}, {10, 0.4, 0.7}));
  EXPECT_FALSE(cut.is_free({0, 14, 0}, {10, 14.4, 0.7}));
}

TEST(ToolJudge, ReportsHowDeepMatterEntersATool) {
  ToolJudge rod;
  const glm::dvec2 rings[] = {{-2, 1.5}, {20, 1.5}};
  rod.add_revolution(rings, 0.25);
  const glm::dmat3 upright(1);
  for (const double deep : {-0.5, 0.0, 0.1, 0.4, 1.2}) {
    const double truth = std::max(0.0, deep);
    // A wall at the side, and a floor at the tip.
    const auto wall = [](const dvec3& p) { return p.x >= 0; };
    EXPECT_NEAR(rod.penetration_mm({deep - 1.5 - 1e-9, 3, 4}, upright, wall), truth, 0.011);
    const auto floor = [](const dvec3& p) { return p.z <= 0; };
    EXPECT_NEAR(rod.penetration_mm({5, 6, 2 + 1e-9 - deep}, upright, floor), truth, 0.011);
    // The rod lies along x.
    const glm::dmat3 lying(dvec3(0, 0, -1), dvec3(0, 1, 0), dvec3(1, 0, 0));
    EXPECT_NEAR(rod.penetration_mm({7, 8, 1.5 + 1e-9 - deep}, lying, floor), truth, 0.011);
    ToolJudge balls;
    balls.add_ball({0, 0, 10}, 2, 0.1);
    EXPECT_NEAR(balls.penetration_mm({1, 2, -8 + 1e-9 - deep}, upright, floor), truth, 0.02);
  }
  // Thin matter across the rod is found to its full depth inside the rod.
  EXPECT_NEAR(rod.penetration_mm({0, 0, 0}, upright,
                                 [](const dvec3& p) { return std::abs(p.z - 9) < 0.2 && p.y < -0.5; }),
              1, 0.03);
}

TEST(BallJudge, ReportsHowFarABallReachesIntoMatter) {
  const BallJudge judge(2);
  const auto floor = [](const dvec3& p) { return p.z <= 0; };
  const auto slab = [](const dvec3& p) { return p.z <= 0 && p.z > -0.2; };
  // The reported depth is at most 0.001 mm above the true depth, and at most 0.015 mm below it.
  for (const double deep : {-0.5, 0.0, 0.05, 0.2, 1.0, 1.9}) {
    const double found = judge.penetration_mm({3, 4, 2 - deep}, floor), truth = std::max(0.0, deep);
    EXPECT_LE(found, truth + 1e-3);
    EXPECT_GE(found, truth - 0.015);
    EXPECT_NEAR(judge.penetration_mm({3, 4, 2 - deep}, slab), found, 0.015);
  }
  EXPECT_EQ(judge.penetration_mm({0, 0, -5}, floor), 2);
  // A small solid entirely inside the ball, and an edge that enters it.
  EXPECT_GT(
      judge.penetration_mm({0, 0, 0}, [](const dvec3& p) { return glm::length(p - dvec3(0.8, 0, 0)) < 0.3; }),
      1);
  EXPECT_NEAR(judge.penetration_mm({0, 0, 0}, [](const dvec3& p) { return p.x > 1 && p.y > 1; }),
              2 - std::sqrt(2.0), 0.05);
}

}  // namespace
}  // namespace trephine::verify
