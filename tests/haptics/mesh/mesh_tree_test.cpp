#include "haptics/mesh/mesh_tree.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "haptics/mesh/god_object.h"
#include "volume/base/deterministic_math.h"
#include "volume/scan/frame.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

double random(std::uint64_t i) { return static_cast<double>(hash_bits(i) >> 11) * 0x1p-53; }

/// Returns a ball of radius r (mm) with n x 2n quadrilaterals of two triangles.
MeshTree ball(int n, double r, const dvec3& middle = dvec3(0)) {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j < 2 * n; ++j) {
      const double a = 3.14159265358979323846 * i / n, b = 3.14159265358979323846 * j / n;
      vertices.push_back(middle +
                         r * dvec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
    }
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(2 * n * i + j % (2 * n)); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2 * n; ++j) {
      for (const std::uint32_t v : {at(i, j), at(i + 1, j), at(i + 1, j + 1)}) triangles.push_back(v);
      for (const std::uint32_t v : {at(i, j), at(i + 1, j + 1), at(i, j + 1)}) triangles.push_back(v);
    }
  return MeshTree(std::move(vertices), std::move(triangles));
}

TEST(MeshTree, FindsTheFirstTriangleOfABruteForceSearch) {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  for (std::uint32_t i = 0; i < 900; ++i) {
    const dvec3 c(random(20 * i), random(20 * i + 1), random(20 * i + 2));
    for (std::uint32_t k = 0; k < 3; ++k) {
      vertices.push_back(c + 0.1 * dvec3(random(20 * i + 3 * k + 4), random(20 * i + 3 * k + 5),
                                         random(20 * i + 3 * k + 6)));
      triangles.push_back(3 * i + k);
    }
  }
  const MeshTree tree(vertices, triangles);
  long hits = 0, looked_all = 0;
  for (std::uint64_t n = 0; n < 4000; ++n) {
    const dvec3 a(random(9000000 + 6 * n), random(9000001 + 6 * n), random(9000002 + 6 * n)),
        b(random(9000003 + 6 * n), random(9000004 + 6 * n), random(9000005 + 6 * n));
    const bool is_front = n % 3 != 1, is_back = n % 3 != 2;
    double nearest = 2;
    for (std::size_t i = 0; i < triangles.size(); i += 3) {
      double t = 0, direction_dot_normal = 0;
      if (TriangleCrossing(a, b - a).crosses(vertices[i], vertices[i + 1], vertices[i + 2], t,
                                             direction_dot_normal) &&
          (direction_dot_normal < 0 ? is_front : is_back))
        nearest = std::min(nearest, t);
    }
    FacetHit hit;
    int visited = 0;
    const bool is_hit = tree.cast(a, b, is_front, is_back, hit, visited);
    ASSERT_EQ(is_hit, nearest <= 1);
    if (is_hit) {
      ASSERT_EQ(hit.t, nearest);
      ASSERT_LE(glm::dot(hit.normal_world, b - a), 0);
      ++hits;
    }
    looked_all += visited;
  }
  EXPECT_GT(hits, 500);
  EXPECT_LT(looked_all / 4000, 300);
}

/// Paths into and out of closed balls with radii of 0.01, 10 and 500 mm always hit, also at vertices and
/// edges.
TEST(MeshTree, IsWatertightAtEdgesAndVerticesAtAnyScale) {
  for (const double scale : {1.0, 1e-3, 50.0}) {
    const MeshTree tree = ball(60, 10 * scale);
    int visited = 0;
    for (std::uint64_t n = 0; n < 20000; ++n) {
      // Half of the rays pass through vertices and midpoints of edges, the others through random points.
      const double i = n % 2 ? 60 * random(3 * n) : std::floor(120 * random(3 * n)) / 2,
                   j = n % 2 ? 120 * random(3 * n + 1) : std::floor(240 * random(3 * n + 1)) / 2;
      const double a = 3.14159265358979323846 * i / 60, b = 3.14159265358979323846 * j / 60;
      const dvec3 u(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
      FacetHit hit;
      ASSERT_TRUE(tree.cast(12 * scale * u, dvec3(0), true, false, hit, visited)) << n << " " << scale;
      ASSERT_NEAR(hit.t, 2.0 / 12, 0.01);
      ASSERT_FALSE(tree.cast(dvec3(0), 12 * scale * u, true, false, hit, visited));
      ASSERT_TRUE(tree.cast(dvec3(0), 12 * scale * u, false, true, hit, visited));
    }
  }
}

TEST(MeshTree, NothingFallsIntoABallWithTenMicrometreEdgesOrAMovedOne) {
  // Edges of about 10 um at a radius of 0.4 mm, and the same ball a thousand times smaller, as after reading
  // metres as mm. The tree is built around (3, 0, 0), and refit() moves the ball to the origin.
  for (const double r : {0.4, 0.0004}) {
    MeshTree tree = ball(120, r, dvec3(3, 0, 0));
    std::vector<dvec3> moved;
    for (int i = 0; i <= 120; ++i)
      for (int j = 0; j < 240; ++j) {
        const double a = 3.14159265358979323846 * i / 120, b = 3.14159265358979323846 * j / 120;
        moved.push_back(r * dvec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
      }
    tree.refit(moved);
    const volume::Frame frame;
    dvec3 proxy(0, 0, 1.5 * r);
    long contacts = 0;
    for (std::uint64_t n = 0; n < 20000; ++n) {
      // A hand that moves through the ball.
      const dvec3 hip =
          1.3 * r *
          dvec3(std::sin(0.011 * static_cast<double>(n)), std::sin(0.017 * static_cast<double>(n) + 1),
                std::sin(0.023 * static_cast<double>(n) + 1.6));
      ProxyStep step;
      PathFacets facets;
      int visited = 0;
      move_god_object(
          frame, hip, proxy, tree.gap(),
          [&](const dvec3& a, const dvec3& b, FacetHit& hit) {
            return tree.cast(a, b, true, false, hit, visited);
          },
          facets, step);
      proxy = step.path_volume[static_cast<std::size_t>(step.waypoint_count - 1)];
      ASSERT_GT(glm::length(proxy), r * std::cos(3.15 / 120) - tree.gap())
          << n;  // no deeper than the middle of a facet
      contacts += step.has_contact;
    }
    EXPECT_GT(contacts, 1000);
  }
}

}  // namespace
}  // namespace trephine::haptics
