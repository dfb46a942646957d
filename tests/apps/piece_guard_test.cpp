// PieceGuard: a held piece stops at obstacles and slides along them, against closed forms.
#include "apps/view/piece_guard.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>
#include <random>

namespace trephine::view {
namespace {

using glm::dvec3;
using haptics::Placement;

constexpr double k_radius = 5;  // mm

/// A ball of k_radius, whose vertices are on circles of latitude 0.5 mm apart.
haptics::MeshTree ball() {
  constexpr int k_rows = 32, k_columns = 48;
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  for (int row = 0; row <= k_rows; ++row)
    for (int column = 0; column < k_columns; ++column) {
      const double a = M_PI * row / k_rows, b = 2 * M_PI * column / k_columns;
      vertices.push_back(k_radius * dvec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
    }
  const auto index = [](int row, int column) {
    return static_cast<std::uint32_t>(row * k_columns + column % k_columns);
  };
  for (int row = 0; row < k_rows; ++row)
    for (int column = 0; column < k_columns; ++column)
      triangles.insert(triangles.end(),
                       {index(row, column), index(row + 1, column), index(row, column + 1),
                        index(row, column + 1), index(row + 1, column), index(row + 1, column + 1)});
  return {std::move(vertices), std::move(triangles)};
}

/// Moves the piece toward `to` in 20 frames, each of at most 30 mm.
Placement carry(PieceGuard& guard, Placement from, const Placement& to,
                const PieceGuard::Obstacle& obstacle) {
  for (int i = 0; i < 20; ++i) from = guard.move(from, to, obstacle);
  return from;
}

TEST(PieceGuard, APieceFollowsTheHandInAir) {
  PieceGuard guard(ball(), {{1, 2, 3}, {1, 0, 0, 0}});
  const Placement to{{60, -20, 5}, glm::angleAxis(0.4, dvec3(0, 0, 1))};
  const Placement reached = carry(guard, {}, to, [](const dvec3&) { return false; });
  EXPECT_LT(glm::distance(reached.position_world, to.position_world), 0.03);
  EXPECT_EQ(reached.rotation, to.rotation);
  EXPECT_EQ(guard.contacts(), 0u);
}

TEST(PieceGuard, APieceStopsAtAPlaneAndSlidesAlongIt) {
  const auto below = [](const dvec3& p) { return p.z < 0; };
  PieceGuard guard(ball(), {});
  const Placement down = carry(guard, {{0, 0, 20}, {1, 0, 0, 0}}, {{0, 0, -40}, {1, 0, 0, 0}}, below);
  EXPECT_NEAR(down.position_world.z, k_radius, 0.1);
  EXPECT_GT(guard.contacts(), 0u);
  const Placement aside = carry(guard, down, {{30, 12, -40}, {1, 0, 0, 0}}, below);
  EXPECT_NEAR(aside.position_world.x, 30, 0.5);
  EXPECT_NEAR(aside.position_world.y, 12, 0.5);
  EXPECT_NEAR(aside.position_world.z, k_radius, 0.3);
  const Placement away = carry(guard, aside, {{0, 0, 30}, {1, 0, 0, 0}}, below);
  EXPECT_NEAR(away.position_world.z, 30, 0.1) << "it does not stick";
}

/// A jump of the cursor to the other side of a thin plate does not carry the piece through it.
TEST(PieceGuard, APieceDoesNotPassAPlateInOneFrame) {
  const auto plate = [](const dvec3& p) { return std::abs(p.z) < 2 && std::hypot(p.x, p.y) < 60; };
  PieceGuard guard(ball(), {});
  const Placement reached = carry(guard, {{3, 0, 20}, {1, 0, 0, 0}}, {{3, 0, -29}, {1, 0, 0, 0}}, plate);
  EXPECT_GT(reached.position_world.z, 2 + k_radius - 0.1);
}

/// A piece in its gap in a shell touches the structure below the shell with its inner side. It can leave the
/// gap, but does not move deeper into that structure.
TEST(PieceGuard, APieceLeavesItsGapAlthoughItTouchesTheStructureBelow) {
  const auto bed = [](const dvec3& p) { return p.z < -4.6 || (p.z < 4 && std::hypot(p.x, p.y) > 6); };
  PieceGuard guard(ball(), {});
  const Placement reached = carry(guard, {}, {{14, 0, 14}, {1, 0, 0, 0}}, bed);
  EXPECT_NEAR(reached.position_world.x, 14, 0.2);
  EXPECT_NEAR(reached.position_world.z, 14, 0.2);
  const Placement held = carry(guard, {}, {{0, 0, -14}, {1, 0, 0, 0}}, bed);
  EXPECT_GT(held.position_world.z, -0.5) << "not deeper into the structure";
}

/// In random motion, the piece does not enter a shell like a skull. Without the guard it would be in the
/// shell in more than 40 of 600 frames.
TEST(PieceGuard, RandomMotionNeverEntersAShell) {
  const auto shell = [](const dvec3& p) { return glm::length(p) > 70 && glm::length(p) < 78; };
  const haptics::MeshTree piece = ball();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-110, 110), turn(-1, 1);
  int unguarded = 0;
  for (const double start : {0.0, 95.0}) {
    PieceGuard guard(piece, {});
    Placement pose{{0, 0, start}, {1, 0, 0, 0}};
    for (int frame = 0; frame < 300; ++frame) {
      const Placement to{{any(random), any(random), any(random)},
                         glm::normalize(glm::dquat(1, turn(random), turn(random), turn(random)))};
      pose = guard.move(pose, to, shell);
      const double r = glm::length(pose.position_world);
      // Between its samples, the surface of the ball may be 0.15 mm deeper.
      EXPECT_TRUE(start == 0 ? r + k_radius < 70.15 : r - k_radius > 77.85) << r;
      const double free = glm::length(to.position_world);
      unguarded += free > 70 - k_radius && free < 78 + k_radius;
    }
  }
  EXPECT_GT(unguarded, 40);
}

}  // namespace
}  // namespace trephine::view
