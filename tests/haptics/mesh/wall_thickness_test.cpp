// walls_of(): number of shells, share of thin walls and thinnest wall of solids with known walls.
#include "haptics/mesh/wall_thickness.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "volume/surface/lathe.h"

namespace trephine::haptics {
namespace {

/// Adds a box from `low` to `high`; `is_hollow`: its triangles face inward.
void add_box(std::vector<glm::dvec3>& vertices, std::vector<std::uint32_t>& triangles, const glm::dvec3& low,
             const glm::dvec3& high, bool is_hollow = false) {
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (int i = 0; i < 8; ++i)
    vertices.emplace_back(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
  constexpr std::uint32_t k_faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                           {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& f : k_faces)
    for (const std::uint32_t corner : {f[0], f[1], f[2], f[0], f[2], f[3]})
      triangles.push_back(first + corner);
  if (is_hollow)
    for (std::size_t t = triangles.size() - 36; t < triangles.size(); t += 3)
      std::swap(triangles[t], triangles[t + 1]);
}

TEST(WallThickness, OfAPlateIsItsHeight) {
  std::vector<glm::dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  add_box(vertices, triangles, {0, 0, 0}, {40, 30, 1.5});
  const MeshTree plate(vertices, triangles);
  const WallFacts facts = walls_of(plate, 2);
  EXPECT_EQ(facts.shells, 1u);
  EXPECT_NEAR(facts.thinnest, 1.5, 1e-4);
  const double faces = 2 * 40 * 30, edges = 2 * 1.5 * (40 + 30);
  EXPECT_NEAR(facts.thin_share, faces / (faces + edges), 1e-12);
  EXPECT_EQ(walls_of(plate, 1.4).thin_share, 0);  // no wall is thinner than 1.4 mm
}

TEST(WallThickness, OfAHollowBoxIsThatOfItsThinWall) {
  std::vector<glm::dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  add_box(vertices, triangles, {0, 0, 0}, {20, 20, 20});
  add_box(vertices, triangles, {2, 3, 0.6}, {17, 16, 15}, true);
  add_box(vertices, triangles, {40, 0, 0}, {45, 5, 5});
  const WallFacts facts = walls_of(MeshTree(vertices, triangles), 1);
  EXPECT_EQ(facts.shells, 3u);
  EXPECT_NEAR(facts.thinnest, 0.6, 1e-4);
  EXPECT_NEAR(facts.thinnest_at.z, 0.3, 0.31);
}

/// The ball is a turned solid of flat triangles. Its wall is measured along a chord that starts at the middle
/// of a triangle, so the thickness is slightly less than the diameter.
TEST(WallThickness, OfASolidBallIsItsDiameter) {
  std::vector<volume::TurnedRing> rings;
  constexpr int k_steps = 60;
  for (int i = 1; i < k_steps; ++i) {
    const double angle = std::numbers::pi * i / k_steps;
    rings.push_back({-10 * std::cos(angle), 10 * std::sin(angle)});
  }
  const volume::TurnedSolid ball = volume::turned_solid(-10, rings, 10, 120);
  const WallFacts facts = walls_of(MeshTree(ball.vertices, ball.triangles), 1);
  EXPECT_EQ(facts.shells, 1u);
  EXPECT_EQ(facts.thin_share, 0);
  EXPECT_NEAR(facts.thinnest, 20, 0.1);
}

}  // namespace
}  // namespace trephine::haptics
