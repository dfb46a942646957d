#include "volume/scan/traversal.h"

#include <gtest/gtest.h>
#include <random>

#include "apps/verify/traversal_audit.h"
#include "volume/scan/occupancy.h"

namespace trephine::volume {
namespace {

TEST(Traversal, MillionAdversarialRaysEqualTheExactJudge) {
  const verify::TraversalAudit audit = verify::audit_traversal(0, 1'000'000, 7);
  EXPECT_EQ(audit.rays, 1'000'000u);
  EXPECT_GT(audit.voxels, 2'500'000u);
  EXPECT_EQ(audit.mismatches, 0u) << audit.first_mismatch;
  EXPECT_EQ(audit.reverse_mismatches, 0u) << audit.first_mismatch;
  EXPECT_LE(audit.worst_t_ulp, 2.0);
}

TEST(Traversal, HalfBelongsToTheHigherVoxel) {
  EXPECT_EQ(voxel_of({0.5, 0, 0}), glm::ivec3(1, 0, 0));
  EXPECT_EQ(voxel_of({-0.5, 0, 0}), glm::ivec3(0, 0, 0));
  EXPECT_EQ(voxel_of({std::nextafter(0.5, 0.0), 0, 0}), glm::ivec3(0, 0, 0));
  EXPECT_EQ(voxel_of({std::nextafter(-0.5, -1.0), 0, 0}), glm::ivec3(-1, 0, 0));
  EXPECT_EQ(voxel_of({1e6 + 0.5, 0, 0}).x, 1000001);
}

TEST(Traversal, DiagonalThroughCornersIsSixConnected) {
  std::vector<glm::ivec3> seen;
  traverse({0, 0, 0}, {3, 3, 3}, {{0, 0, 0}, {5, 5, 5}},
           [&](const VoxelVisit& v) { return seen.push_back(v.voxel), true; });
  ASSERT_EQ(seen.size(), 10u);
  for (std::size_t i = 1; i < seen.size(); ++i) {
    const glm::ivec3 d = glm::abs(seen[i] - seen[i - 1]);
    EXPECT_EQ(d.x + d.y + d.z, 1);
  }
}

// Skipping empty boxes must not change the first solid voxel, or the parameter and axis of entry into it.
TEST(Traversal, SkippingEmptySpaceReportsTheSameFirstSolidVoxel) {
  std::mt19937_64 random(5);
  Volume volume = make_volume({70, 45, 52}, Frame()).value();
  for (auto& v : volume.voxels.span()) v = random() % 900 == 0 ? 1000 : -1000;
  const Occupancy bits = Occupancy::build(volume, Shape{});
  const VoxelBox grid{glm::ivec3(0), volume.size - 1};
  std::uniform_real_distribution<double> anywhere(-20, 90);
  std::uniform_int_distribution<int> lattice(-20, 180);
  int hits = 0;
  std::int64_t steps = 0, skips = 0;
  for (int n = 0; n < 20000; ++n) {
    glm::dvec3 a, b;
    for (int i = 0; i < 3; ++i) {
      a[i] = n % 2 ? anywhere(random) : 0.5 * lattice(random);
      b[i] = n % 2 ? anywhere(random) : 0.5 * lattice(random);
    }
    VoxelWalk plain(Segment(a, b), grid);
    for (; !plain.is_done() && !bits.is_solid(plain.voxel()); plain.advance()) ++steps;
    VoxelWalk skipping(Segment(a, b), grid);
    while (!skipping.is_done() && !bits.is_solid(skipping.voxel())) {
      ++skips;
      const int far = bits.empty_distance(skipping.voxel());
      if (far == 0) {
        skipping.advance();
        continue;
      }
      const glm::ivec3 block = skipping.voxel() / 4;
      skipping.advance_past({4 * (block - (far - 1)), 4 * (block + far) - 1});
    }
    ASSERT_EQ(plain.is_done(), skipping.is_done()) << n;
    if (plain.is_done()) continue;
    ++hits;
    ASSERT_EQ(plain.voxel(), skipping.voxel()) << n;
    ASSERT_EQ(plain.t_enter(), skipping.t_enter()) << n;
    ASSERT_EQ(plain.face().axis, skipping.face().axis) << n;
  }
  EXPECT_GT(hits, 500);
  EXPECT_LT(2 * skips, steps);
}

TEST(Occupancy, DistanceIsTheChessboardDistanceByBruteForce) {
  std::mt19937_64 random(11);
  Volume volume = make_volume({37, 26, 30}, Frame()).value();
  for (auto& v : volume.voxels.span()) v = random() % 4000 == 0 ? 1000 : -1000;
  const Occupancy bits = Occupancy::build(volume, Shape{});
  std::vector<glm::ivec3> solid_blocks;
  std::size_t count = 0;
  for (int z = 0; z < volume.size.z; ++z)
    for (int y = 0; y < volume.size.y; ++y)
      for (int x = 0; x < volume.size.x; ++x) {
        const bool is_solid = volume.voxels[volume.index(x, y, z)] >= 300;
        ASSERT_EQ(bits.is_solid({x, y, z}), is_solid);
        if (is_solid) solid_blocks.push_back(glm::ivec3(x, y, z) / 4), ++count;
      }
  EXPECT_EQ(bits.count_solid(), count);
  ASSERT_FALSE(solid_blocks.empty());
  for (int z = 0; z < volume.size.z; ++z)
    for (int y = 0; y < volume.size.y; ++y)
      for (int x = 0; x < volume.size.x; ++x) {
        int nearest = 64;
        for (const glm::ivec3& b : solid_blocks) {
          const glm::ivec3 d = glm::abs(b - glm::ivec3(x, y, z) / 4);
          nearest = std::min(nearest, std::max({d.x, d.y, d.z}));
        }
        ASSERT_EQ(bits.empty_distance({x, y, z}), nearest);
      }
}

}  // namespace
}  // namespace trephine::volume
