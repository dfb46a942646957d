#include "volume/shape_choice.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "volume/surface_nets.h"

namespace trephine::volume {
namespace {

Volume cube(int side, std::int16_t value) {
  Volume v = make_volume(glm::ivec3(side), Frame()).value();
  for (std::int16_t& voxel : v.voxels.span()) voxel = value;
  return v;
}

/// Two bells, and the threshold that a plain search over all thresholds finds.
TEST(OtsuThreshold, IsTheBestOfAllThresholds) {
  Volume v = cube(32, 0);
  std::mt19937 random(3);
  std::normal_distribution<double> dark(100, 30), bright(400, 60);
  for (std::size_t i = 0; i < v.voxels.size(); ++i)
    v.voxels[i] = static_cast<std::int16_t>(std::lround(i % 3 ? dark(random) : bright(random)));
  const auto between = [&](int threshold) {
    double n[2] = {}, sum[2] = {};
    for (const std::int16_t x : v.voxels.span()) ++n[x >= threshold], sum[x >= threshold] += x;
    if (n[0] == 0 || n[1] == 0) return 0.0;
    const double d = sum[0] / n[0] - sum[1] / n[1];
    return n[0] * n[1] * d * d;
  };
  double best = 0;
  for (int t = -100; t < 800; ++t) best = std::max(best, between(t));
  EXPECT_NEAR(between(otsu_threshold(v)) / best, 1, 1e-12);
}

TEST(OtsuThreshold, LiesInTheMiddleOfAGap) {
  Volume v = cube(8, -5);
  for (std::size_t i = 0; i < 100; ++i) v.voxels[i] = 95;
  EXPECT_NEAR(otsu_threshold(v), 45, 1);
  EXPECT_NO_FATAL_FAILURE(otsu_threshold(cube(4, 7)));
}

/// A ball, a table under it and a grain that touches the ball by a corner.
TEST(LargestPart, StaysAsItWasAndTheOthersAreAir) {
  auto scan = std::make_shared<Volume>(cube(40, -900));
  scan->is_hounsfield = true;
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        const double r = std::sqrt((x - 20.0) * (x - 20) + (y - 16.0) * (y - 16) + (z - 20.0) * (z - 20));
        scan->voxels[scan->index(x, y, z)] =
            static_cast<std::int16_t>(300 + 100 * std::clamp(10 - r, -12.0, 12.0));
        if (y >= 36) scan->voxels[scan->index(x, y, z)] = 700;
      }
  const Shape bone;
  const ShapeParts before = parts_of(scan, bone);
  EXPECT_EQ(before.count, 2);
  EXPECT_EQ(before.largest, 4 * 40 * 40);
  EXPECT_EQ(before.second, before.others);
  ShapeParts told;
  const Volume kept = with_largest_part(scan, bone, told).value();
  EXPECT_EQ(told.largest + told.others, before.largest + before.others);
  std::int64_t changed = 0;
  for (std::size_t i = 0; i < kept.voxels.size(); ++i)
    if (kept.voxels[i] != scan->voxels[i]) {
      ++changed;
      ASSERT_EQ(kept.voxels[i], -900);  // as low as anything there, and not lower than air
      ASSERT_GE(scan->voxels[i], 300);
    }
  EXPECT_EQ(changed, told.others);
  const ShapeParts after =
      parts_of(std::make_shared<const Volume>(with_largest_part(scan, bone, told).value()), bone);
  EXPECT_EQ(after.count, 1);
  EXPECT_FALSE(with_largest_part(std::make_shared<const Volume>(cube(4, 0)), bone, told).is_ok());
}

}  // namespace
}  // namespace trephine::volume
