#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <set>

#include "volume/cuts/operated_volume.h"
#include "volume/cuts/removal.h"
#include "volume/surface/part_surface.h"
#include "volume/surface/surface_nets.h"

namespace trephine::volume {
namespace {

/// A slab of bone. A burr of radius k_radius saws a disk out of it, along a circle of radius k_circle.
struct SawnSlab {
  static constexpr double k_circle = 7, k_radius = 1.2;  // mm
  double half_height;
  std::shared_ptr<Volume> volume;
  Shape shape{"bone", 300};
  Field field;
  Occupancy bits;
  std::shared_ptr<const Version> version;
  RemovalEditor editor;
  glm::dvec3 middle;

  static std::shared_ptr<Volume> slab(const Frame& frame, const glm::ivec3& size, const glm::dvec3& middle,
                                      double half_height) {
    auto result = std::make_shared<Volume>(make_volume(size, frame).value());
    for (int z = 0; z < size.z; ++z)
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
          // The faces of the slab are planes, so that the trilinear field is exact.
          const double height = std::abs(frame.world_from_volume({x, y, z}).z - middle.z);
          result->voxels[result->index(x, y, z)] =
              static_cast<std::int16_t>(std::clamp(300 + 400 * (half_height - height), -1000.0, 3000.0));
        }
    return result;
  }
  SawnSlab(const Frame& frame, const glm::ivec3& size, double burr, double half = 3)
      : half_height(half),
        volume(slab(frame, size, frame.world_from_volume(0.5 * glm::dvec3(size - 1)), half)),
        field(*volume, shape),
        bits(Occupancy::build(*volume, shape)),
        version(std::make_shared<const Version>(
            volume, burr > 0 ? CutLattice::for_burr(*volume, burr).value() : CutLattice(*volume))),
        editor(version, {field}),
        middle(frame.world_from_volume(0.5 * glm::dvec3(size - 1))) {}
  /// Saws along the fraction `turn` of the circle.
  void saw(double turn) {
    const int steps = static_cast<int>(120 * turn);
    for (const double z : {-2.4, -0.8, 0.8, 2.4, 3.6, -3.6, 4.8, -4.8})
      for (int i = 0; i < steps; ++i) {
        const auto at = [&](int k) {
          const double a = 2 * 3.14159265358979 * k / 120;
          return middle + glm::dvec3(k_circle * std::cos(a), k_circle * std::sin(a), z);
        };
        editor.remove({at(i), at(i + 1), k_radius, false});
      }
    version = editor.publish();
  }
};

std::vector<SawnSlab> slabs() {
  glm::dmat3 sheared(0.0);
  sheared[0][0] = 0.55, sheared[1][1] = 0.6, sheared[2][2] = 0.9, sheared[2][1] = 0.2;
  glm::dmat3 left(0.0);
  left[0][0] = -0.6, left[1][1] = 0.6, left[2][2] = 0.8;
  std::vector<SawnSlab> all;
  all.emplace_back(Frame::from_spacing({5, -3, 2}, {0.5, 0.5, 0.5}).value(), glm::ivec3(48, 48, 24), 0);
  all.emplace_back(Frame::from_spacing({5, -3, 2}, {0.6, 0.6, 2.0}).value(), glm::ivec3(40, 40, 9), 2.4);
  all.emplace_back(Frame::from_axes({1, 2, 3}, sheared).value(), glm::ivec3(44, 40, 14), 2.4);
  all.emplace_back(Frame::from_axes({1, 2, 3}, left).value(), glm::ivec3(40, 40, 16), 2.4);
  // The faces of these slabs are between an air voxel and a bone voxel, nearer to the air voxel.
  all.emplace_back(Frame::from_spacing({5, -3, 2}, {0.6, 0.6, 2.0}).value(), glm::ivec3(40, 40, 11), 2.4,
                   3.9);
  all.emplace_back(Frame::from_spacing({5, -3, 2}, {1, 1, 1}).value(), glm::ivec3(26, 26, 15), 2.4, 3.4);
  return all;
}

double volume_of(const PartSurface& surface) {
  double sum = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); t += 3) {
    const glm::dvec3 a(surface.vertices_world[surface.triangles[t]]),
        b(surface.vertices_world[surface.triangles[t + 1]]),
        c(surface.vertices_world[surface.triangles[t + 2]]);
    sum += glm::dot(a, glm::cross(b, c)) / 6;
  }
  return sum;
}

TEST(RemoveParts, DetachesASawnDiskWithItsOwnShape) {
  for (SawnSlab& slab : slabs()) {
    slab.saw(0.93);
    EXPECT_EQ(SolidParts(slab.field, slab.bits, *slab.version).parts().size(), 1u);
    slab.saw(1.001);
    const std::int64_t removed = slab.version->ledger().total();
    const SolidParts parts(slab.field, slab.bits, *slab.version);
    int off = -1, count = 0;
    for (std::size_t p = 0; p < parts.parts().size(); ++p)
      if (parts.parts()[p].is_detached) off = static_cast<int>(p), ++count;
    ASSERT_EQ(count, 1);
    const PartSurface surface = part_surface(slab.field, slab.bits, slab.version, parts, off);

    // The surface is closed: every edge occurs once in each direction.
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (std::size_t t = 0; t < surface.triangles.size(); t += 3)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_TRUE(edges.emplace(surface.triangles[t + k], surface.triangles[t + (k + 1) % 3]).second);
    for (const auto& [a, b] : edges) EXPECT_TRUE(edges.contains({b, a}));
    ASSERT_GT(edges.size(), 100u);
    // The part is a disk as high as the slab. Ridges between the sweeps of the ball remain on its rim. So its
    // volume exceeds that of a disk within a kerf without ridges, by at most 8 %.
    const double r = SawnSlab::k_circle - SawnSlab::k_radius, h = 2 * slab.half_height;
    const double disk = 3.14159265358979 * r * r * h;
    EXPECT_GT(volume_of(surface), disk);
    EXPECT_LT(volume_of(surface), 1.08 * disk);
    for (const glm::vec3& v : surface.vertices_world) {
      const glm::dvec3 d = glm::dvec3(v) - slab.middle;
      EXPECT_LT(std::abs(d.z), slab.half_height + 0.02);
      EXPECT_LT(std::hypot(d.x, d.y), r + 0.45);
    }

    std::vector<std::uint8_t> goes(parts.parts().size(), 0);
    goes[static_cast<std::size_t>(off)] = 1;
    const RemovalReport report =
        slab.editor.remove_parts(parts, goes, parts.parts()[static_cast<std::size_t>(off)].box);
    const auto left = slab.editor.freeze();
    // The matter counts as freed, not as removed. The freed volume equals that within the surface of the
    // part, up to 2 % of the disk.
    EXPECT_EQ(left->ledger().total(), removed);
    EXPECT_EQ(left->ledger().detached_units, report.removed_units);
    EXPECT_NEAR(left->mm3_of(report.removed_units), volume_of(surface), 0.02 * disk);
    // The remainder is a single part. Its surface has the same number of triangles and the same volume as
    // before.
    const SolidParts rest(slab.field, slab.bits, *left);
    EXPECT_EQ(rest.parts().size(), 1u);
    const PartSurface before = part_surface(slab.field, slab.bits, slab.version, parts, 1 - off),
                      after = part_surface(slab.field, slab.bits, left, rest, 0);
    EXPECT_EQ(before.triangles.size(), after.triangles.size());
    EXPECT_NEAR(volume_of(before), volume_of(after), 1e-3);
    // The hole is empty: no sample at the disk's position, or near it, is solid any more.
    for (double x = -r; x <= r; x += 0.31)
      for (double y = -r; y <= r; y += 0.37)
        for (double z = -5; z <= 5; z += 0.29) {
          if (std::hypot(x, y) > r + 0.3) continue;
          const glm::dvec3 p = slab.volume->frame.volume_from_world(slab.middle + glm::dvec3(x, y, z));
          EXPECT_FALSE(slab.field.value(p) >= 0 && left->distance(p) > 0) << x << ' ' << y << ' ' << z;
        }
    // A call that selects no part changes nothing.
    EXPECT_EQ(slab.editor
                  .remove_parts(rest, std::vector<std::uint8_t>(1, 0), {glm::ivec3(0), slab.volume->size - 1})
                  .bricks_changed,
              0);
    // A tool that sweeps the hole removes nothing, so that freed matter is not counted again.
    EXPECT_EQ(slab.editor.remove({slab.middle, slab.middle + glm::dvec3(2, 0, 0), 2, false}).removed_units,
              0);
  }
}

/// Two blocks with a layer of weak bone between them, one voxel thick, are joined by a bridge, which is then
/// cut. If one block is freed, the other block does not change.
TEST(RemoveParts, KeepsNeighbouringParts) {
  const auto volume = std::make_shared<Volume>(make_volume({24, 14, 14}, Frame()).value());
  for (int z = 0; z < 14; ++z)
    for (int y = 0; y < 14; ++y)
      for (int x = 0; x < 24; ++x) {
        const bool is_bridge = x == 9 && std::abs(y - 7) <= 1 && std::abs(z - 7) <= 1,
                   is_inside = x >= 2 && x < 22 && y >= 2 && y < 12 && z >= 2 && z < 12;
        volume->voxels[volume->index(x, y, z)] = static_cast<std::int16_t>(!is_inside             ? -1000
                                                                           : x == 9 && !is_bridge ? 290
                                                                                                  : 1000);
      }
  const Shape shape{"bone", 300};
  const Field field(*volume, shape);
  const Occupancy bits = Occupancy::build(*volume, shape);
  RemovalEditor editor(std::make_shared<const Version>(volume), {field});
  editor.remove({{9, 6, 7}, {9, 8, 7}, 1.4, false});
  editor.remove({{9, 6, 6}, {9, 8, 6}, 1.4, false});
  editor.remove({{9, 6, 8}, {9, 8, 8}, 1.4, false});
  const auto cut = editor.publish();
  const SolidParts parts(field, bits, *cut);
  ASSERT_EQ(parts.parts().size(), 2u);
  ASSERT_TRUE(parts.parts()[0].is_detached);
  const auto before = part_surface(field, bits, cut, parts, 1);
  editor.remove_parts(parts, {1, 0}, parts.parts()[0].box);
  const auto left = editor.freeze();
  const SolidParts rest(field, bits, *left);
  ASSERT_EQ(rest.parts().size(), 1u);
  EXPECT_EQ(rest.parts()[0].samples, parts.parts()[1].samples);
  const auto after = part_surface(field, bits, left, rest, 0);
  ASSERT_EQ(before.vertices_world.size(), after.vertices_world.size());
  double farthest = 0;
  for (const glm::vec3& a : before.vertices_world) {
    double nearest = 1e9;
    for (const glm::vec3& b : after.vertices_world)
      nearest = std::min(nearest, static_cast<double>(glm::length(a - b)));
    farthest = std::max(farthest, nearest);
  }
  EXPECT_LT(farthest, 1e-5);
  // Far from the cut, the surface is that of the field, between a voxel of 1000 and one of 290.
  int faced = 0;
  for (const glm::vec3& v : after.vertices_world)
    if (v.x < 12 && v.y > 3 && v.y < 4 && v.z > 3 && v.z < 11) {
      EXPECT_NEAR(v.x, 9 + 10.0 / 710, 1e-4);
      ++faced;
    }
  EXPECT_GT(faced, 5);
}

TEST(RemoveParts, NeighbouringDistancesDifferByAtMostTheirSpacing) {
  for (SawnSlab& slab : slabs()) {
    slab.saw(1.001);
    const SolidParts parts(slab.field, slab.bits, *slab.version);
    std::vector<std::uint8_t> goes;
    VoxelBox box;
    for (const SolidParts::Part& part : parts.parts()) {
      goes.push_back(part.is_detached);
      if (part.is_detached) box = part.box;
    }
    slab.editor.remove_parts(parts, goes, box);
    const auto left = slab.editor.publish();
    const CutLattice& lattice = left->lattice();
    int near = 0;
    for (int z = 1; z < lattice.size().z; ++z)
      for (int y = 1; y < lattice.size().y; ++y)
        for (int x = 1; x < lattice.size().x; ++x)
          for (int a = 0; a < 3; ++a) {
            glm::ivec3 to(x, y, z), by(0);
            by[a] = 1;
            const double change = std::abs(left->sample_distance(to) - left->sample_distance(to - by));
            ASSERT_LE(change, 1.0001 * glm::length(lattice.frame().vector_world_from_volume(by)) + 0.05);
            near += change > 0;
          }
    EXPECT_GT(near, 1000);
  }
}

}  // namespace
}  // namespace trephine::volume
