#include "haptics/proxy/nearest_motion.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace trephine::haptics {
namespace {

using glm::dvec3;

double reserve(const MotionBound& b, const Twist& t) {
  return glm::dot(b.normal, t.translation) + glm::dot(b.moment, t.rotation) - b.least;
}

Twist motion_of(const Twist& request, double square, const std::vector<MotionBound>& bounds) {
  Twist t = request;
  for (const MotionBound& b : bounds) {
    t.translation += b.push * b.normal;
    t.rotation += (b.push / square) * b.moment;
  }
  return t;
}

/// Largest violation of the conditions of Karush, Kuhn and Tucker, which only the nearest motion satisfies:
/// bounds hold, pushes are not negative, and only bounds that hold with equality push.
double violation(const Twist& request, double square, const std::vector<MotionBound>& bounds) {
  const Twist t = motion_of(request, square, bounds);
  double most = 0;
  for (const MotionBound& b : bounds)
    most = std::max({most, -reserve(b, t), -b.push, std::min(b.push, std::abs(reserve(b, t)))});
  return most;
}

class Walls {
 public:
  explicit Walls(unsigned seed) : random_(seed) {}
  double number(double low, double high) { return std::uniform_real_distribution<>(low, high)(random_); }
  dvec3 vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  dvec3 direction() {
    for (;;)
      if (const dvec3 v = vector(1); glm::length(v) > 0.1) return glm::normalize(v);
  }
  /// Returns a bound at a point, which the motion `allowed` satisfies.
  MotionBound bound(const dvec3& arm, const dvec3& normal, const Twist& allowed, double most_reserve) {
    MotionBound b{normal, glm::cross(arm, normal), 0, 0};
    b.least = reserve(b, allowed) - number(0, most_reserve);
    return b;
  }

 private:
  std::mt19937 random_;
};

/// Bounds of any directions, and of many points on a plane, on two planes and on a ball.
TEST(NearestMotion, SatisfiesTheConditionsOfTheNearestMotion) {
  Walls walls(1);
  int active = 0;
  for (int run = 0; run < 20000; ++run) {
    const double square = std::pow(10, walls.number(-1, 3));
    const double arm = 3 * std::sqrt(square);
    const Twist allowed{walls.vector(0.2), walls.vector(0.02)};
    const Twist request{walls.vector(2), walls.vector(0.3)};
    const dvec3 planes[2] = {walls.direction(), walls.direction()};
    std::vector<MotionBound> bounds(static_cast<std::size_t>(walls.number(1, 40)));
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      const dvec3 at = walls.vector(arm);
      const dvec3 normal = run % 4 == 0   ? walls.direction()
                           : run % 4 == 1 ? planes[0]
                           : run % 4 == 2 ? planes[k % 2]
                                          : glm::normalize(at + walls.vector(1e-3));
      bounds[k] = walls.bound(at, normal, allowed, run % 3 == 0 ? 0 : 0.05);
    }
    ASSERT_TRUE(find_pushes(request, square, bounds)) << run;
    double strongest = 1;
    for (const MotionBound& b : bounds) strongest = std::max(strongest, b.push);
    ASSERT_LT(violation(request, square, bounds), 1e-6 * strongest) << run;
    active += std::any_of(bounds.begin(), bounds.end(), [](const MotionBound& b) { return b.push > 0; });
  }
  EXPECT_GT(active, 5000);
}

TEST(NearestMotion, TheJudgeFindsWrongPushes) {
  std::vector<MotionBound> floor{{{0, 0, 1}, {0, 0, 0}, 0, 0}};
  const Twist down{{0, 0, -1}, {0, 0, 0}};
  ASSERT_TRUE(find_pushes(down, 25, floor));
  EXPECT_DOUBLE_EQ(floor[0].push, 1);
  EXPECT_EQ(violation(down, 25, floor), 0);
  for (const double wrong : {0.0, 0.999, 1.001}) {
    floor[0].push = wrong;
    EXPECT_GT(violation(down, 25, floor), 5e-4) << wrong;
  }
}

/// A long rod lies on a plane: many similar bounds, between which sweeps converge slowly.
TEST(NearestMotion, ARodOnAPlaneMovesAlongThePlane) {
  std::vector<MotionBound> bounds;
  for (int i = -20; i <= 20; ++i) {
    const dvec3 arm(0.5 * i, 0.01 * (i % 3), -2);
    bounds.push_back({{0, 0, 1}, glm::cross(arm, dvec3(0, 0, 1)), 0, 0});
  }
  const Twist request{{0.01, 0, -1.5}, {0, 0, 0}};
  ASSERT_TRUE(find_pushes(request, 30, bounds));
  const Twist t = motion_of(request, 30, bounds);
  EXPECT_NEAR(t.translation.x, 0.01, 1e-12);
  EXPECT_NEAR(t.translation.z, 0, 1e-12);
  EXPECT_NEAR(glm::length(t.rotation), 0, 1e-12);
}

TEST(NearestMotion, ContradictionsAreReported) {
  // Two opposite walls require room between them that does not exist.
  std::vector<MotionBound> slot{{{0, 0, 1}, {0, 0, 0}, 0.1, 0}, {{0, 0, -1}, {0, 0, 0}, 0.1, 0}};
  EXPECT_FALSE(find_pushes({{0, 0, -1}, {0, 0, 0}}, 25, slot));
  for (const MotionBound& b : slot) EXPECT_TRUE(b.push >= 0 && b.push < 10);
  slot[1].least = -0.1;  // now the room is exactly as wide as the tool
  EXPECT_TRUE(find_pushes({{0, 0, -1}, {0, 0, 0}}, 25, slot));
  std::vector<MotionBound> flat{{{0, 0, 0}, {0, 0, 0}, 0, 0}};
  EXPECT_TRUE(find_pushes({{1, 2, 3}, {0, 0, 0}}, 25, flat)) << "a wall without a normal";
  EXPECT_TRUE(find_pushes({{1, 2, 3}, {0, 0, 0}}, 25, {}));
}

}  // namespace
}  // namespace trephine::haptics
