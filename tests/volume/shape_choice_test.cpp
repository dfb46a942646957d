#include "volume/cuts/shape_choice.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

#include "volume/surface/surface_nets.h"

namespace trephine::volume {
namespace {

Volume cube(int side, std::int16_t value) {
  Volume v = make_volume(glm::ivec3(side), Frame()).value();
  for (std::int16_t& voxel : v.voxels.span()) voxel = value;
  return v;
}

/// The threshold between two normal distributions is as good as the best one of an exhaustive search.
TEST(OtsuThreshold, EqualsExhaustiveSearch) {
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

/// A ball and a table under it; the table is the largest part.
TEST(LargestPart, IsKeptUnchangedAndOthersBecomeAir) {
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
  ShapeParts result;
  const Volume kept = keep_largest_part(scan, bone, result).value();
  EXPECT_EQ(result.largest + result.others, before.largest + before.others);
  std::int64_t changed = 0;
  for (std::size_t i = 0; i < kept.voxels.size(); ++i)
    if (kept.shape_voxels[i] != scan->voxels[i]) {
      ++changed;
      ASSERT_EQ(kept.shape_voxels[i], -900);  // the lowest intensity of the scan, which is not below air
      ASSERT_GE(scan->voxels[i], 300);
    }
  EXPECT_EQ(changed, result.others);
  EXPECT_TRUE(std::equal(kept.voxels.span().begin(), kept.voxels.span().end(), scan->voxels.span().begin()));
  const ShapeParts after =
      parts_of(std::make_shared<const Volume>(keep_largest_part(scan, bone, result).value()), bone);
  EXPECT_EQ(after.count, 1);
  EXPECT_FALSE(keep_largest_part(std::make_shared<const Volume>(cube(4, 0)), bone, result).is_ok());
}

/// Two balls: the larger one has no dense core, so that it becomes air.
TEST(SeededParts, KeepOnlyPartsConnectedToASeed) {
  auto scan = std::make_shared<Volume>(cube(40, -900));
  scan->is_hounsfield = true;
  const auto ball = [&](const glm::ivec3& at, int radius, std::int16_t value) {
    for (int z = 0; z < 40; ++z)
      for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) {
          const glm::ivec3 d = glm::ivec3(x, y, z) - at;
          if (d.x * d.x + d.y * d.y + d.z * d.z <= radius * radius)
            scan->voxels[scan->index(x, y, z)] = value;
        }
  };
  ball({10, 10, 10}, 6, 350);
  ball({10, 10, 10}, 3, 900);
  ball({29, 29, 29}, 7, 390);  // larger, and without a dense core
  const Shape bone;
  ShapeParts gone;
  const Volume kept = keep_seeded_parts(scan, bone, 700, 0, gone).value();
  EXPECT_EQ(gone.count, 1);
  std::int64_t changed = 0;
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        const std::size_t i = scan->index(x, y, z);
        const bool is_second = x > 20 && scan->voxels[i] >= 300;
        EXPECT_EQ(kept.shape_voxels[i], is_second ? -900 : scan->voxels[i]);
        changed += is_second;
      }
  EXPECT_EQ(gone.others, changed);
  EXPECT_FALSE(keep_seeded_parts(scan, bone, 901, 0, gone).is_ok());
  // Both balls contain a seed now. The smaller one has 0.65 times the voxels of the larger one.
  ASSERT_TRUE(keep_seeded_parts(scan, bone, 301, 0.6, gone).is_ok());
  EXPECT_EQ(gone.count, 0);
  ASSERT_TRUE(keep_seeded_parts(scan, bone, 301, 0.7, gone).is_ok());
  EXPECT_EQ(gone.count, 1);
}

/// Counts voxels of `filled` that differ from the definition of fill_thin_walls(). A voxel is open, and thus
/// not filled, if a ball without solid voxels contains it at least half a voxel below the ball's surface.
std::int64_t closing_errors(const Volume& v, const Shape& shape, const Volume& filled, double from, double to,
                            double reach) {
  std::vector<glm::ivec3> ball, inner;
  const int most = 8;
  const glm::dvec3& spacing = v.frame.spacing();
  const double deep = reach - 0.5 * std::min({spacing.x, spacing.y, spacing.z});
  for (int z = -most; z <= most; ++z)
    for (int y = -most; y <= most; ++y)
      for (int x = -most; x <= most; ++x) {
        const double away = glm::length(v.frame.vector_world_from_volume(glm::dvec3(x, y, z)));
        if (away <= reach) ball.emplace_back(x, y, z);
        if (away <= deep) inner.emplace_back(x, y, z);
      }
  const auto is_solid = [&](const glm::ivec3& p) {
    return v.contains(p) && shape.is_solid(v.voxels[v.index(p.x, p.y, p.z)]);
  };
  std::int64_t errors = 0;
  for (int z = 0; z < v.size.z; ++z)
    for (int y = 0; y < v.size.y; ++y)
      for (int x = 0; x < v.size.x; ++x) {
        const glm::ivec3 p(x, y, z);
        bool is_open = false;
        for (const glm::ivec3& d : inner) {
          const glm::ivec3 middle = p + d;
          if (!v.contains(middle) || is_open) continue;
          bool is_free = true;
          for (const glm::ivec3& e : ball) is_free = is_free && !is_solid(middle + e);
          is_open = is_free;
        }
        const std::size_t i = v.index(x, y, z);
        // A filled voxel is between solid voxels along a row, a diagonal or a space diagonal.
        bool is_between = false;
        for (int dz = -1; dz <= 1; ++dz)
          for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
              const glm::ivec3 d(dx, dy, dz);
              if (d == glm::ivec3(0)) continue;
              const double length = glm::length(v.frame.vector_world_from_volume(glm::dvec3(d)));
              bool sides[2] = {};
              for (int k = 1; k * length <= reach; ++k) {
                sides[0] = sides[0] || is_solid(p + k * d);
                sides[1] = sides[1] || is_solid(p - k * d);
              }
              is_between = is_between || (sides[0] && sides[1]);
            }
        // On at least three lines through a filled voxel, there is a darker voxel on both sides before the
        // first solid one. Darker means: by at least half the difference between the shape's threshold and
        // `from`.
        int lines = 0;
        const double dark = v.voxels[i] - (shape.low - from) / 2;
        for (int n = 14; n < 27; ++n) {
          const glm::ivec3 d(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
          const double length = glm::length(v.frame.vector_world_from_volume(glm::dvec3(d)));
          int dark_sides = 0;
          for (const int side : {1, -1})
            for (int k = 1; k * length <= reach; ++k) {
              const glm::ivec3 q = p + side * k * d;
              if (!v.contains(q) || is_solid(q)) break;
              if (v.voxels[v.index(q.x, q.y, q.z)] > dark) continue;
              ++dark_sides;
              break;
            }
          lines += dark_sides == 2;
        }
        const bool lifts = !is_open && is_between && lines >= 3 && !is_solid(p) && v.voxels[i] >= from;
        errors += filled.shape_voxels[i] != (lifts ? static_cast<std::int16_t>(to) : v.voxels[i]);
      }
  return errors;
}

TEST(ThinFill, EqualsTheClosingByDefinitionOnAnyGrid) {
  std::mt19937 random(5);
  const glm::dmat3 grids[] = {glm::dmat3(1.0), glm::dmat3(0.7, 0, 0, 0, 0.9, 0, 0, 0, 2.0),
                              glm::dmat3(0.8, 0, 0, 0, 0.8, 0, 0, 0.5, 1.1)};
  for (const glm::dmat3& axes : grids) {
    Volume v = make_volume({70, 13, 11}, Frame::from_axes(glm::dvec3(3), axes).value()).value();
    // Sheets with holes, and single solid or grey voxels between the sheets.
    for (std::size_t n = 0; n < v.voxels.size(); ++n) {
      const bool is_sheet = n % 70 % 8 == 3;
      const unsigned long solid = is_sheet ? 70 : 2, grey = is_sheet ? 100 : 15, dice = random() % 100;
      v.voxels[n] = static_cast<std::int16_t>(dice < solid ? 400 : dice < grey ? 200 : -50);
    }
    const Shape bone;
    std::int64_t count = 0, differing = 0;
    const Volume filled = fill_thin_walls(v, bone, 150, 350, 1.8, count).value();
    for (std::size_t i = 0; i < v.voxels.size(); ++i) differing += filled.shape_voxels[i] != v.voxels[i];
    EXPECT_EQ(count, differing);
    EXPECT_GT(count, 100);
    EXPECT_EQ(closing_errors(v, bone, filled, 150, 350, 1.8), 0);
    EXPECT_GT(closing_errors(v, bone, filled, 150, 350, 2.1), 0)
        << "the judge must reject a result for another reach";
  }
}

/// A hole with a radius of 2 mm in a sheet of 2 mm is filled: a ball with a radius of 6 mm cannot
/// enter it.
TEST(ThinFill, ClosesAHoleInAThinWall) {
  Volume v = cube(40, -50);
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y) {
      const int d = (y - 20) * (y - 20) + (z - 20) * (z - 20);
      for (int x = 20; x < 22; ++x)
        v.voxels[v.index(x, y, z)] = static_cast<std::int16_t>(d <= 4 ? 180 : 500);
    }
  std::int64_t count = 0;
  const Volume filled = fill_thin_walls(v, Shape{}, 150, 350, 6, count).value();
  EXPECT_EQ(count, 2 * 13);
  EXPECT_EQ(filled.shape_voxels[v.index(20, 20, 20)], 350);
}

/// A joint between two bones stays open, whatever the partial volume of bone in its voxels.
TEST(ThinFill, LeavesJointsOpen) {
  Volume v = cube(40, 40);
  for (int z = 0; z < 40; ++z)
    for (int y = 5; y < 35; ++y)
      for (int x = 10; x < 30; ++x)
        v.voxels[v.index(x, y, z)] =
            static_cast<std::int16_t>(x == 19 || x == 20 ? 200 + (7 * y + z) % 40 : 700);
  std::int64_t count = 0;
  ASSERT_TRUE(fill_thin_walls(v, Shape{}, 150, 225, 4, count).is_ok());
  EXPECT_EQ(count, 0);
}

/// The outer surface of a ball, in any direction to the grid, is unchanged, although its edge is soft.
TEST(ThinFill, LeavesOuterSurfacesUnchanged) {
  Volume v = cube(60, -50);
  for (int z = 0; z < 60; ++z)
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 60; ++x) {
        const double r =
            std::sqrt((x - 30.2) * (x - 30.2) + (y - 29.7) * (y - 29.7) + (z - 30.1) * (z - 30.1));
        v.voxels[v.index(x, y, z)] = static_cast<std::int16_t>(300 + 400 * std::clamp(20 - r, -0.9, 2.0));
      }
  std::int64_t count = 0;
  ASSERT_TRUE(fill_thin_walls(v, Shape{}, 0, 500, 4, count).is_ok());
  EXPECT_EQ(count, 0);
}

/// Returns a skull and a jaw in tissue, with a cushion and a holder under the head; voxels of 1 x 1 x 2.5 mm.
/// `cushion`, `tissue`: intensities, HU.
std::shared_ptr<Volume> head_in_holder(std::int16_t cushion, std::int16_t tissue = 40) {
  const glm::dmat3 axes(glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 2.5));
  auto scan = std::make_shared<Volume>(
      make_volume({61, 71, 25}, Frame::from_axes(glm::dvec3(0), axes).value()).value());
  scan->is_hounsfield = true;
  for (int z = 0; z < 25; ++z)
    for (int y = 0; y < 71; ++y)
      for (int x = 0; x < 61; ++x) {
        const double r = glm::length(glm::dvec3(x - 30, y - 30, 2.5 * (z - 12))),
                     jaw = glm::length(glm::dvec3(x - 30, y - 50, 2.5 * (z - 12)));
        scan->voxels[scan->index(x, y, z)] = r < 16 && r > 12 ? 900
                                             : jaw < 3        ? 800
                                             : r < 28         ? tissue
                                             : y >= 69        ? 600
                                             : y > 52         ? cushion
                                                              : -1000;
      }
  return scan;
}

TEST(PartsOutsideTheBody, AreOmittedAndPartsInsideStay) {
  const auto scan = head_in_holder(-950);
  const Shape bone;
  ShapeParts removed;
  const auto kept = omit_parts_outside_body(scan, bone, removed);
  ASSERT_TRUE(kept);
  EXPECT_EQ(removed.count, 1);
  EXPECT_EQ(removed.others, 61 * 2 * 25);
  const Volume& output = *kept.value();
  EXPECT_EQ(output.window_voxels()[output.index(30, 69, 12)], -1000) << "the holder";
  EXPECT_EQ(output.window_voxels()[output.index(30, 50, 12)], 800) << "the jaw";
  EXPECT_EQ(output.window_voxels()[output.index(30, 44, 12)], 900) << "the skull";
  for (std::size_t i = 0; i < scan->voxels.size(); ++i) ASSERT_EQ(output.voxels[i], scan->voxels[i]);
}

TEST(PartsOutsideTheBody, StayIfTheyTouchItOrIfThereIsNoTissue) {
  ShapeParts removed;
  const auto touching = head_in_holder(-200);  // a dense cushion connects holder and skin
  EXPECT_EQ(omit_parts_outside_body(touching, Shape{}, removed).value(), touching);
  EXPECT_EQ(removed.count, 0);
  const auto specimen = head_in_holder(-950, -1000);
  EXPECT_EQ(omit_parts_outside_body(specimen, Shape{}, removed).value(), specimen);
  const auto uncalibrated = head_in_holder(-950);
  uncalibrated->is_hounsfield = false;
  EXPECT_EQ(omit_parts_outside_body(uncalibrated, Shape{}, removed).value(), uncalibrated);
}

/// A long part, such as the edge of a table, is omitted although it has few voxels. A short splinter stays.
TEST(PartsOutsideTheBody, AreOmittedIfTheyAreLong) {
  for (const int slices : {24, 16}) {  // length of the part: 60 and 40 mm
    const auto scan = head_in_holder(-950);
    for (int z = 0; z < 25; ++z)
      for (int y = 0; y < 71; ++y)
        for (int x = 0; x < 61; ++x) {
          std::int16_t& value = scan->voxels[scan->index(x, y, z)];
          if (y >= 60) value = y == 70 && x == 30 && z < slices ? 600 : -1000;
          if (glm::length(glm::dvec3(x - 30, y - 30, 2.5 * (z - 12))) <= 12) value = 900;  // no cavity
        }
    ShapeParts removed;
    const auto kept = omit_parts_outside_body(scan, Shape{}, removed).value();
    EXPECT_LT(200 * slices, parts_of(scan, Shape{}).largest) << "few voxels";
    EXPECT_EQ(removed.count, slices == 24);
    EXPECT_EQ(kept->window_voxels()[kept->index(30, 70, 5)], slices == 24 ? -1000 : 600);
  }
}

/// An ear connects a second part of the holder to the body. Planted bone of the same size in air, but
/// enclosed by the body, stays.
TEST(PartsOutsideTheBody, AreOmittedIfOnlyAnEarTouchesThem) {
  for (const bool is_enclosed : {false, true}) {
    const auto scan = head_in_holder(-950);
    const int x = is_enclosed ? 30 : 1;  // in the cavity of the skull, or next to the head
    for (int z = 8; z < 17; ++z)
      for (int y = 24; y < 36; ++y) {
        if (is_enclosed)
          for (int around = -4; around <= 4; ++around) scan->voxels[scan->index(x + around, y, z)] = -1000;
        else
          for (int around = 0; around <= 6; ++around) scan->voxels[scan->index(around, y, z)] = -1000;
        scan->voxels[scan->index(x, y, z)] = 600;
      }
    for (int ear = x; ear < x + 7; ++ear)  // a bridge of tissue
      if (scan->voxels[scan->index(ear, 30, 12)] < -300) scan->voxels[scan->index(ear, 30, 12)] = 50;
    ShapeParts removed;
    const auto kept = omit_parts_outside_body(scan, Shape{}, removed).value();
    EXPECT_EQ(removed.count, is_enclosed ? 1 : 2);
    EXPECT_EQ(kept->window_voxels()[kept->index(x, 30, 12)], is_enclosed ? 600 : -1000);
  }
}

TEST(PartsOutsideTheBody, OfAnySizeAreOmittedOnRequest) {
  const auto scan = head_in_holder(-950);
  for (int y = 60; y < 71; ++y)
    for (int z = 0; z < 25; ++z)
      for (int x = 0; x < 61; ++x)
        if (x != 30 || z != 12) scan->voxels[scan->index(x, y, z)] = -1000;  // leaves a splinter
  Shape skull;
  ShapeParts removed;
  EXPECT_EQ(omit_parts_outside_body(scan, skull, removed).value(), scan);
  const auto kept = omit_parts_outside_body(scan, skull, removed, PartSize::any).value();
  EXPECT_EQ(removed.count, 1);
  EXPECT_EQ(kept->window_voxels()[kept->index(30, 70, 12)], -1000);
  EXPECT_EQ(kept->window_voxels()[kept->index(30, 50, 12)], 800) << "the jaw";
}

}  // namespace
}  // namespace trephine::volume
