// VoxMap, VoxelSampling and DepthShell: published methods for whole tools, compared with their definitions
// point by point.
#include "haptics/baselines/voxel_sampling.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

#include "apps/bench/scenes/closed_models.h"
#include "haptics/baselines/depth_shell.h"
#include "tests/haptics/servo/servo_fixture.h"

namespace trephine::haptics::baselines {
namespace {

using glm::dvec3;
using glm::ivec3;
using Voxel = VoxMap::Voxel;

constexpr double k_pi = 3.14159265358979;

/// Returns a map of the positions for which is_solid() is true, with cubic voxels around the origin.
VoxMap map_of(const std::function<bool(const dvec3&)>& is_solid, int size, double voxel, int layers = 1) {
  volume::Volume v =
      volume::make_volume(ivec3(size),
                          volume::Frame::from_spacing(dvec3(-0.5 * voxel * (size - 1)), dvec3(voxel)).value())
          .value();
  for (int z = 0; z < size; ++z)
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x)
        v.voxels[v.index(x, y, z)] = is_solid(v.frame.world_from_volume({x, y, z})) ? 1000 : -1000;
  return VoxMap::of(volume::Occupancy::build(v, volume::Shape{}), v.frame, layers);
}

SharedShell rod(double low, double high, double radius, double spacing) {
  return PointShell::of_profile({{{low, radius}, {high, radius}}, spacing}).value();
}

TEST(VoxMap, HasTheTypesOfItsDefinition) {
  const auto is_ball = [](const dvec3& p) { return glm::length(p) < 12; };
  constexpr int k_size = 70;
  const VoxMap map = map_of(is_ball, k_size, 0.7, 2);
  const auto solid = [&](const ivec3& v) {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < k_size && v.y < k_size && v.z < k_size &&
           is_ball(map.frame().world_from_volume(v));
  };
  int counts[5] = {0, 0, 0, 0, 0};
  for (int z = -1; z <= k_size; ++z)
    for (int y = -1; y <= k_size; ++y)
      for (int x = -1; x <= k_size; ++x) {
        const ivec3 v(x, y, z);
        const bool is_outside = x < 0 || y < 0 || z < 0 || x == k_size || y == k_size || z == k_size;
        bool near_solid = false, near_free = false;
        for (int n = 0; n < 125; ++n) {
          const ivec3 off(n % 5 - 2, n / 5 % 5 - 2, n / 25 - 2);
          near_solid = near_solid || solid(v + off);
          if (std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) < 2)
            near_free = near_free || !solid(v + off);
        }
        const Voxel expected = is_outside   ? Voxel::undefined
                               : solid(v)   ? (near_free ? Voxel::surface : Voxel::interior)
                               : near_solid ? Voxel::proximity
                                            : Voxel::free;
        ASSERT_EQ(map.at(v), expected) << x << ' ' << y << ' ' << z;
        ++counts[static_cast<int>(expected)];
      }
  for (const int count : counts) EXPECT_GT(count, 100);
  // Equal children are stored once: less than a tenth of a byte per voxel of the whole tree.
  EXPECT_LT(map.bytes(), std::size_t{512} * 512 * 512 / 10);
}

TEST(VoxMap, BoxesAreFreeAsTheirVoxelsAre) {
  const VoxMap map = map_of([](const dvec3& p) { return std::abs(p.z) < 3 && p.x > 0; }, 40, 0.5);
  std::mt19937 random(2);
  int free = 0;
  for (int n = 0; n < 2000; ++n) {
    ivec3 a, b;
    for (int k = 0; k < 3; ++k) {
      a[k] = static_cast<int>(random() % 50) - 5;
      b[k] = a[k] + static_cast<int>(random() % 12);
    }
    bool expected = true;
    for (int z = a.z; z <= b.z; ++z)
      for (int y = a.y; y <= b.y; ++y)
        for (int x = a.x; x <= b.x; ++x) {
          const Voxel type = map.at({x, y, z});
          expected = expected && (type == Voxel::free || type == Voxel::undefined);
        }
    ASSERT_EQ(map.is_free(a, b), expected);
    free += expected;
  }
  EXPECT_GT(free, 200);
  EXPECT_LT(free, 1800);
}

MeshTree tree_of(const depth::Model& model) { return {model.vertices, model.triangles}; }

TEST(VoxMap, MeshesAreClosedByVoxels) {
  const double voxel = 0.6;
  const MeshTree mesh = tree_of(depth::ball({1, 2, 3}, 8, 48));
  const VoxMap by_walls = VoxMap::of(mesh, voxel, VoxMap::Interior::walls),
               by_parity = VoxMap::of(mesh, voxel, VoxMap::Interior::parity);
  int surface = 0, interior = 0;
  for (int z = 0; z < by_walls.size().z; ++z)
    for (int y = 0; y < by_walls.size().y; ++y)
      for (int x = 0; x < by_walls.size().x; ++x) {
        const ivec3 v(x, y, z);
        ASSERT_EQ(by_walls.at(v), by_parity.at(v));  // a convex body has no bays
        const double depth = 8 - glm::length(by_walls.frame().world_from_volume(v) - dvec3(1, 2, 3));
        const Voxel type = by_walls.at(v);
        if (type == Voxel::surface) {
          EXPECT_LT(std::abs(depth), 0.9 * voxel + 0.05);
        } else if (type == Voxel::interior) {
          EXPECT_GT(depth, 0);
        } else {
          EXPECT_LT(depth, 0.1);
        }
        surface += type == Voxel::surface, interior += type == Voxel::interior;
      }
  EXPECT_GT(surface, 1000);
  EXPECT_NEAR(interior * voxel * voxel * voxel, 4.0 / 3 * k_pi * std::pow(8 - 0.5 * voxel, 3), 150);
  // Every point of every triangle is in a surface voxel.
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    for (const dvec3& p : {a, (a + b + c) / 3.0, 0.5 * (a + b)})
      EXPECT_EQ(by_walls.at(volume::voxel_of(by_walls.frame().volume_from_world(p))), Voxel::surface);
  }
}

/// Rows of voxel centres run exactly through edges and corners of this cube, whose faces have diagonals.
TEST(VoxMap, RowsThroughEdgesOfTheMeshKeepTheirInterior) {
  const double voxel = 0.5;
  // The map has its origin 3.37 voxels below the mesh; 0.185 mm shift the planes of centres to the corners.
  for (const dvec3& shift : {dvec3(0), dvec3(0.1, 0.1, 0.1)}) {
    std::vector<dvec3> vertices;
    for (int i = 0; i < 8; ++i)
      vertices.push_back(4.0 * dvec3(i & 1, i >> 1 & 1, i >> 2) + shift + 0.37 * voxel * dvec3(0, 1, 1));
    // Faces with outward normals; those of x have their diagonals along rows.
    const std::vector<std::uint32_t> triangles{0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                               2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    const MeshTree mesh(vertices, triangles);
    const VoxMap by_walls = VoxMap::of(mesh, voxel, VoxMap::Interior::walls),
                 by_parity = VoxMap::of(mesh, voxel, VoxMap::Interior::parity);
    int interior = 0;
    for (int z = 0; z < by_walls.size().z; ++z)
      for (int y = 0; y < by_walls.size().y; ++y)
        for (int x = 0; x < by_walls.size().x; ++x) {
          ASSERT_EQ(by_walls.at({x, y, z}), by_parity.at({x, y, z})) << x << ' ' << y << ' ' << z;
          interior += by_parity.at({x, y, z}) == Voxel::interior;
        }
    EXPECT_GT(interior, 200);
  }
}

TEST(VoxMap, WallsLoseTheInteriorOfALeakingMesh) {
  const auto interior_of = [](const VoxMap& map) {
    int count = 0;
    for (int z = 0; z < map.size().z; ++z)
      for (int y = 0; y < map.size().y; ++y)
        for (int x = 0; x < map.size().x; ++x) count += map.at({x, y, z}) == Voxel::interior;
    return count;
  };
  depth::Model ball = depth::ball({0, 0, 0}, 8, 16);
  const int whole = interior_of(VoxMap::of(tree_of(ball), 0.5, VoxMap::Interior::parity));
  ball.triangles.resize(ball.triangles.size() - 3 * 48);  // a hole of some voxels
  EXPECT_LT(interior_of(VoxMap::of(tree_of(ball), 0.5, VoxMap::Interior::walls)), 0.5 * whole);
  EXPECT_GT(interior_of(VoxMap::of(tree_of(ball), 0.5, VoxMap::Interior::parity)), 0.9 * whole);
}

TEST(VoxelSampling, ForcesAreThoseOfTheTangentPlanes) {
  const VoxMap map = map_of([](const dvec3& p) { return p.z < 0; }, 64, 0.5);
  const SharedShell shell = rod(0, 10, 2, 0.4);
  std::mt19937 random(3);
  const auto between = [&](double a, double b) { return a + (b - a) * (double(random()) / 4294967296.0); };
  int touching = 0;
  for (int n = 0; n < 300; ++n) {
    const Placement tool{{between(-3, 3), between(-3, 3), between(-1, 1)},
                         glm::normalize(glm::dquat(1, between(-0.3, 0.3), between(-0.3, 0.3), 0.2))};
    VoxelSampling::Options options{0.7, n % 2 == 0 ? 0 : 10};
    const VoxelSampling sampling(map, *shell, options);
    const PoseForce fast = sampling.contact(tool), slow = sampling.contact(tool, false);
    ASSERT_EQ(fast.on_tool.force_world, slow.on_tool.force_world);  // to the bit
    ASSERT_EQ(fast.on_tool.torque_world, slow.on_tool.torque_world);
    ASSERT_EQ(fast.points, slow.points);
    // The forces by the equations of the method (eq. 3.1 to 3.5), with the voxel types of a half space.
    dvec3 force(0), torque(0);
    int count = 0;
    for (const PointShell::Point& point : shell->points()) {
      const dvec3 p = tool.world_from_local(point.position), inward = tool.rotation * point.inward;
      const int layer = static_cast<int>(std::floor(p.z / 0.5));  // voxel centres at odd quarters
      if (layer != 0 && layer != -1) continue;
      const double depth = layer == -1
                               ? 0.25
                               : std::clamp(glm::dot(inward, dvec3(0.5 * std::floor(p.x / 0.5) + 0.25,
                                                                   0.5 * std::floor(p.y / 0.5) + 0.25, 0.25) -
                                                                 p),
                                            0.0, 0.25);
      if (!(depth > 0)) continue;
      ++count;
      force += 0.7 * depth * inward;
      torque += glm::cross(p - tool.position_world, 0.7 * depth * inward);
    }
    const double scale = options.averaging_threshold > 0 && count >= 10 ? 10.0 / count : 1;
    ASSERT_EQ(fast.points, count);
    EXPECT_LT(glm::length(fast.on_tool.force_world - scale * force), 1e-9);
    EXPECT_LT(glm::length(fast.on_tool.torque_world - scale * torque), 1e-8);
    touching += count > 0;
    if (count > 0) {
      EXPECT_LT(fast.tests, slow.tests + 200);
    }
  }
  EXPECT_GT(touching, 100);
}

/// Turns a rod between two plates by 0.6 rad. Returns the largest number of points of the tool in the
/// interior of the plates.
int points_through_plates(bool limits_missing_torque) {
  // Plates of 4 mm above and below a gap of 6 mm.
  const VoxMap map = map_of([](const dvec3& p) { return std::abs(p.z) > 3 && std::abs(p.z) < 7; }, 128, 0.5);
  const SharedShell shell = rod(-25, 25, 1.5, 0.4);
  const VoxelSampling sampling(map, *shell, {0.5, 10});
  DynamicTool::Options options;
  options.limits_missing_torque = limits_missing_torque;
  DynamicTool tool(sampling, options, 1e-3);
  int most = 0;
  const glm::dquat along(std::sqrt(0.5), 0, std::sqrt(0.5), 0);  // the rod lies along x
  for (int i = 0; i < 3000; ++i) {
    const double angle = 0.6 * std::min(1.0, i / 2000.0);
    tool.step({dvec3(0), glm::dquat(std::cos(0.5 * angle), 0, std::sin(0.5 * angle), 0) * along});
    most = std::max(most, tool.contact().interior);
    EXPECT_TRUE(std::isfinite(tool.pose().position_world.x));
  }
  return most;
}

// The lever task: on a device without torque the hand turns the tool through its contacts, unless the torque
// of the coupling is limited.
TEST(VoxelSampling, ALimitedCouplingHoldsALever) {
  EXPECT_GT(points_through_plates(false), 10);
  EXPECT_EQ(points_through_plates(true), 0);
}

// Explicit integration adds energy, which appears as noise of the force (Kadlecek 2013, master thesis, eq.
// 3.20).
TEST(DynamicTool, SemiImplicitIntegrationIsCalmer) {
  const VoxMap map = map_of([](const dvec3& p) { return p.z < 0; }, 32, 0.5);
  const SharedShell shell = rod(0, 10, 2, 0.6);
  const VoxelSampling sampling(map, *shell);
  const auto noise_of = [&](Integrator integrator) {
    DynamicTool::Options options;
    options.integrator = integrator;
    options.coupling = {0.59, 0.6 * 0.00768};
    DynamicTool tool(sampling, options, 1e-3);
    double sum = 0;
    std::array<double, 20> block;
    for (int i = 0; i < 4000; ++i) {
      tool.step({{0, 0, 6 + 0.5 * std::sin(0.01 * i)}, {1, 0, 0, 0}});  // free motion
      block[static_cast<std::size_t>(i) % 20] = glm::length(tool.on_hand().force_world);
      if (i % 20 != 19) continue;
      double mean = 0, square = 0;
      for (const double f : block) mean += f / 20;
      for (const double f : block) square += (f - mean) * (f - mean) / 20;
      sum += square;
    }
    return sum;
  };
  const double by_explicit = noise_of(Integrator::explicit_euler),
               by_semi = noise_of(Integrator::semi_implicit), by_implicit = noise_of(Integrator::implicit);
  EXPECT_GT(by_explicit, 1.02 * by_semi);
  EXPECT_LT(by_implicit, 1.5 * by_semi);
  RecordProperty("explicit", std::to_string(by_explicit));
  RecordProperty("semi", std::to_string(by_semi));
}

// The published tool of points on depth images: over a flat box each point is pushed out by its depth.
TEST(DepthShell, PointsArePushedOutByTheirDepth) {
  const depth::Model box = depth::box({-10, -10, -10}, {10, 10, 10});
  glm::ivec3 size;
  const volume::Frame frame = depth::lattice_around(dvec3(-10), dvec3(10), 0.2, size).value();
  const auto images = depth::DepthCube::of_triangles(box.vertices, box.triangles, frame, size).value();
  const SharedShell shell = rod(-5, 5, 2, 0.5);
  const DepthShell contact(images, *shell, {.stiffness = 0.5});
  std::mt19937 random(6);
  const auto between = [&](double a, double b) { return a + (b - a) * (double(random()) / 4294967296.0); };
  double worst = 0;
  for (int n = 0; n < 100; ++n) {
    const Placement tool{{between(-3, 3), between(-3, 3), 10 + between(0.8, 1.6)},
                         glm::normalize(glm::dquat(1, between(-0.1, 0.1), 1, between(-0.1, 0.1)))};
    const PoseForce found = contact.contact(tool);
    dvec3 force(0);
    double torque = 0;
    int count = 0;
    for (const PointShell::Point& point : shell->points()) {
      const dvec3 p = tool.world_from_local(point.position);
      if (!(p.z < 10)) continue;
      ++count;
      force.z += 0.5 * (10 - p.z);
      torque += glm::length(glm::cross(p - tool.position_world, dvec3(0, 0, 0.5 * (10 - p.z))));
    }
    ASSERT_GT(count, 3);
    EXPECT_NEAR(found.points, count,
                0.2 * count + 2);  // points at the surface are decided by the nearest pixel
    worst = std::max(worst, glm::length(found.on_tool.force_world - force) / force.z);
    EXPECT_LT(glm::length(found.on_tool.torque_world), torque);
  }
  // The search along the normal of a tilted tool can end too far from the nearest free position.
  EXPECT_LT(worst, 0.35);
  RecordProperty("worst_percent", std::to_string(100 * worst));
  EXPECT_EQ(contact.contact({{0, 0, 40}, {1, 0, 0, 0}}).points, 0);
  EXPECT_GT(contact.contact({{0, 0, 0}, {1, 0, 0, 0}}).interior, 0) << "deep points do not push";
}

}  // namespace
}  // namespace trephine::haptics::baselines
