// PointShell: coverage, spacing, mass and tree of sampled surfaces, against closed forms and brute force.
#include "haptics/tool/point_shell.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

#include "apps/bench/scenes/closed_models.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

struct Mesh {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
};
Mesh mesh_of(const depth::Model& model) { return {model.vertices, model.triangles}; }
Mesh box(const dvec3& low, const dvec3& high) { return mesh_of(depth::box(low, high)); }

double nearest(const PointShell& shell, const dvec3& p) {
  double least = 1e300;
  for (const PointShell::Point& point : shell.points())
    least = std::min(least, glm::length(point.position - p));
  return least;
}

TEST(PointShell, CoversTheSurfaceWithItsSpacing) {
  std::mt19937 random(3);
  const auto share = [&] { return double(random()) / 4294967296.0; };
  for (const Mesh& mesh : {box({-3, -2, -1}, {3, 2, 1}), mesh_of(depth::ball({1, 2, 3}, 4, 48))})
    for (const double spacing : {0.3, 0.7, 1.9}) {
      const SharedShell shell = PointShell::of_mesh(mesh.vertices, mesh.triangles, spacing).value();
      for (int n = 0; n < 2000; ++n) {
        const std::size_t t = 3 * (random() % (mesh.triangles.size() / 3));
        double u = share(), v = share();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const dvec3 &a = mesh.vertices[mesh.triangles[t]], &b = mesh.vertices[mesh.triangles[t + 1]],
                    &c = mesh.vertices[mesh.triangles[t + 2]];
        EXPECT_LE(nearest(*shell, a + u * (b - a) + v * (c - a)), spacing);
      }
      double closest = 1e300;
      for (std::size_t i = 0; i < shell->points().size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
          closest = std::min(closest, glm::length(shell->points()[i].position - shell->points()[j].position));
      EXPECT_GE(closest, 0.5 * spacing * (1 - 1e-12));
    }
}

TEST(PointShell, ContainsCornersAndTheirNormalsPointInward) {
  const Mesh mesh = box({-3, -2, -1}, {3, 2, 1});
  const SharedShell shell = PointShell::of_mesh(mesh.vertices, mesh.triangles, 0.4).value();
  for (const dvec3& corner : mesh.vertices) EXPECT_LT(nearest(*shell, corner), 1e-12);
  for (const PointShell::Point& point : shell->points()) {
    EXPECT_NEAR(glm::length(point.inward), 1, 1e-12);
    const dvec3 inside = point.position + 0.1 * point.inward;
    EXPECT_TRUE(std::abs(inside.x) < 3 && std::abs(inside.y) < 2 && std::abs(inside.z) < 1);
  }
}

// The areas of the points are weights of an integral over the surface.
TEST(PointShell, AreasIntegrateOverTheSurface) {
  const Mesh mesh = box({1, 2, 3}, {5, 8, 6});  // 4 x 6 x 3 mm
  for (const double spacing : {0.2, 0.5}) {
    const SharedShell shell =
        PointShell::of_mesh(mesh.vertices, mesh.triangles, spacing, PointShell::Areas::computed).value();
    EXPECT_EQ(PointShell::of_mesh(mesh.vertices, mesh.triangles, spacing).value()->points()[0].area, 0);
    double area = 0, largest = 0;
    dvec3 first(0), second(0);
    for (const PointShell::Point& point : shell->points()) {
      area += point.area, largest = std::max(largest, point.area);
      first += point.area * point.position, second += point.area * point.position * point.position;
      EXPECT_GE(point.area, 0);
    }
    EXPECT_NEAR(area, 108, 1e-9);
    EXPECT_LT(largest, 2 * spacing * spacing);
    EXPECT_LT(glm::length(first / area - dvec3(3, 5, 4.5)), 0.05 * spacing);
    // The integral of (x - 3)^2 over the box: 2 faces of 18 mm2 at 2 mm, 4 faces with the mean 4/3 mm2.
    EXPECT_NEAR(second.x - 2 * 3 * first.x + 9 * area, 2 * 18 * 4 + 72 * 4.0 / 3, 0.1 * area * spacing);
  }
}

TEST(PointShell, HasTheMassOfItsSolid) {
  const Mesh mesh = box({1, 2, 3}, {5, 8, 6});  // 4 x 6 x 3 mm
  const PointShell::Solid solid = PointShell::of_mesh(mesh.vertices, mesh.triangles, 1).value()->solid();
  EXPECT_NEAR(solid.volume, 72, 1e-9);
  EXPECT_LT(glm::length(solid.centre - dvec3(3, 5, 4.5)), 1e-9);
  EXPECT_NEAR(solid.inertia[0][0], 72.0 / 12 * (36 + 9), 1e-8);
  EXPECT_NEAR(solid.inertia[1][1], 72.0 / 12 * (16 + 9), 1e-8);
  EXPECT_NEAR(solid.inertia[2][2], 72.0 / 12 * (16 + 36), 1e-8);
  EXPECT_NEAR(solid.inertia[0][1], 0, 1e-8);
  // The cross-section of a cylinder is sampled as a polygon, so that the values are approximate.
  const PointShell::Solid rod = PointShell::of_profile({{{-2, 1.2}, {18, 1.2}}, 0.3}).value()->solid();
  EXPECT_NEAR(rod.volume, 20 * 3.14159265 * 1.44, 0.02 * rod.volume);
  EXPECT_NEAR(rod.centre.z, 8, 1e-9);
  EXPECT_NEAR(rod.inertia[0][0] / rod.volume, 1.44 / 4 + 400.0 / 12, 0.02);
}

// Each traversal of the tree finds the points that a test of all points finds, in the same order.
TEST(PointShell, TreeFindsWhatBruteForceFinds) {
  const SharedShell shell = PointShell::of_profile({{{-2, 0.5}, {0, 2}, {2, 1.2}, {60, 1.2}}, 0.4}).value();
  std::mt19937 random(7);
  const auto between = [&](double a, double b) { return a + (b - a) * (double(random()) / 4294967296.0); };
  std::size_t found = 0;
  for (int n = 0; n < 300; ++n) {
    const dvec3 p(between(-4, 4), between(-4, 4), between(-5, 65));
    const double reach = between(0, 5);
    const auto is_near = [&](std::uint32_t i) {
      return glm::length(shell->points()[i].position - p) <= reach;
    };
    std::vector<std::uint32_t> all, by_tree;
    for (std::uint32_t i = 0; i < shell->points().size(); ++i)
      if (is_near(i)) all.push_back(i);
    shell->visit(
        [&](const PointShell::Node& node) { return glm::length(node.centre - p) > reach + node.radius; },
        [&](std::uint32_t i) {
          if (is_near(i)) by_tree.push_back(i);
          return true;
        });
    EXPECT_EQ(all, by_tree);
    found += all.size();
  }
  EXPECT_GT(found, 1000u);
}

TEST(PointShell, SamplesTheSameInEveryRun) {
  const Mesh mesh = mesh_of(depth::ball({0, 0, 0}, 3, 32));
  EXPECT_EQ(PointShell::of_mesh(mesh.vertices, mesh.triangles, 0.3).value()->hash(),
            PointShell::of_mesh(mesh.vertices, mesh.triangles, 0.3).value()->hash());
  EXPECT_NE(PointShell::of_mesh(mesh.vertices, mesh.triangles, 0.3).value()->hash(),
            PointShell::of_mesh(mesh.vertices, mesh.triangles, 0.31).value()->hash());
}

TEST(PointShell, RefusesMeshesThatAreNoSolid) {
  Mesh mesh = box({-1, -1, -1}, {1, 1, 1});
  Mesh open = mesh;
  open.triangles.resize(open.triangles.size() - 3);
  const auto not_closed = PointShell::of_mesh(open.vertices, open.triangles, 0.5);
  ASSERT_FALSE(not_closed);
  EXPECT_EQ(not_closed.error().what, "the mesh of the tool is not closed");
  EXPECT_NE(not_closed.error().where.find("edge from (1, 1, "), std::string::npos)
      << not_closed.error().where;
  Mesh turned = mesh;
  for (std::size_t t = 0; t < turned.triangles.size(); t += 3)
    std::swap(turned.triangles[t], turned.triangles[t + 1]);
  EXPECT_EQ(PointShell::of_mesh(turned.vertices, turned.triangles, 0.5).error().what,
            "the mesh of the tool encloses no volume");
  EXPECT_FALSE(PointShell::of_mesh(mesh.vertices, mesh.triangles, 0.001));
  EXPECT_FALSE(PointShell::of_mesh(mesh.vertices, mesh.triangles, std::nan("")));
  using Rings = std::vector<ToolProfile::Ring>;
  for (const Rings& rings :
       {Rings{{0, 1}, {-1, 1}}, Rings{{0, 1}}, Rings{{0, 1}, {0, 2}}, Rings{{0, 0}, {1, 1}},
        Rings{{0, 1}, {400, 1}}, Rings{{0, std::nan("")}, {1, 1}}})
    EXPECT_EQ(PointShell::of_profile({rings, 0.5}).error().where, "profile");
  EXPECT_EQ(PointShell::of_profile({{{0, 1}, {1, 1}}, 0}).error().where, "spacing");
  EXPECT_EQ(PointShell::check({{{0, 90}, {200, 90}}, 0.1})->what, "the tool needs too many points");
  const Mesh large = box({-100, -100, -100}, {100, 100, 100});
  EXPECT_EQ(PointShell::of_mesh(large.vertices, large.triangles, 0.1).error().what,
            "the tool needs too many points");
}

}  // namespace
}  // namespace trephine::haptics
