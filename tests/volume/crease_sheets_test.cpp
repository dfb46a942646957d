// Sheets of offset fields at creases: balls in grooves against closed forms, no sheets on smooth or convex
// shapes, and updates that add no matter.
#include "volume/fields/crease_sheets.h"

#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

#include "volume/cuts/removal.h"
#include "volume/fields/offset_field.h"

namespace trephine::volume {
namespace {

using glm::dvec3;
using glm::ivec3;

constexpr double k_degree = 0.017453292519943295;

/// A V groove oblique to the grid. Its flanks meet in the line through the origin along `axis`, and it opens
/// along `up`. `degrees`: angle between the flanks; `half_angle`: half of it, in radians.
struct Groove {
  double half_angle;
  dvec3 axis, up, across;
  std::shared_ptr<const Volume> base;
  Field field;
  Occupancy bits;

  Groove(double degrees, const glm::dmat3& axes)
      : half_angle(0.5 * degrees * k_degree),
        axis(glm::normalize(dvec3(0.9, 0.37, 0.21))),
        up(glm::normalize(dvec3(-0.1, 0.2, 1) - glm::dot(dvec3(-0.1, 0.2, 1), axis) * axis)),
        across(glm::cross(axis, up)),
        base(std::make_shared<const Volume>(made(axes))),
        field(*base, Shape{}),
        bits(Occupancy::build(*base, Shape{})) {}

  /// Distance (mm) of a point to the nearer flank's plane; negative in the solid.
  double height(const dvec3& p) const {
    return glm::dot(p, up) * std::sin(half_angle) - std::abs(glm::dot(p, across)) * std::cos(half_angle);
  }
  Volume made(const glm::dmat3& axes) const {
    const ivec3 size(
        glm::ceil(26.0 / dvec3(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2]))));
    const dvec3 origin = -0.5 * (axes * (dvec3(size) - 1.0));
    Volume v = make_volume(size, Frame::from_axes(origin, axes).value()).value();
    for (int z = 0; z < size.z; ++z)
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
          const double depth = -height(v.frame.world_from_volume({x, y, z}));
          v.voxels[v.index(x, y, z)] =
              static_cast<std::int16_t>(std::lround(std::clamp(300 + 300 * depth, -1000.0, 3000.0)));
        }
    return v;
  }
};

/// Returns the value of the solid at p (world), >= 0 inside: the largest value of the sheets of the cube. In
/// cubes without sheets, or without `has_sheets`, returns the value of the field itself.
double solid_at(const OffsetField& f, const dvec3& p_world, bool has_sheets) {
  const dvec3 p = f.frame().volume_from_world(p_world);
  const ivec3 v = voxel_of(p);
  QuadraticPatch patch;
  const CreaseSheets::Mask sheets = has_sheets ? f.sheets_at(v) : 0;
  if (sheets == 0) {
    f.load(v, patch);
    return patch.value_and_gradient(p - dvec3(v)).value;
  }
  double most = -1e9;
  for (CreaseSheets::Mask rest = sheets; rest != 0; rest &= rest - 1) {
    f.load_sheet(std::countr_zero(rest), v, patch);
    most = std::max(most, patch.value_and_gradient(p - dvec3(v)).value);
  }
  return most;
}

/// Returns the largest error (mm) of the height at which a ball rests in a groove, along 8 mm of the groove.
double worst_rest(const Groove& g, const OffsetField& f, bool has_sheets) {
  const double exact = f.radius_mm() / std::sin(g.half_angle);
  double worst = 0;
  for (double along = -4; along <= 4; along += 0.13) {
    double low = exact - 3, high = exact + 3;  // solid, free
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (solid_at(f, along * g.axis + middle * g.up, has_sheets) >= 0 ? low : high) = middle;
    }
    worst = std::max(worst, std::abs(high - exact));
  }
  return worst;
}

TEST(CreaseSheets, BallsRestInNarrowGroovesWhereTheClosedFormSays) {
  const glm::dmat3 fine(0.25), thick(dvec3(0.25, 0, 0), dvec3(0, 0.25, 0), dvec3(0, 0, 0.5)),
      sheared(dvec3(0.25, 0, 0), dvec3(0.04, 0.24, 0), dvec3(0.05, 0.06, 0.3));
  for (const glm::dmat3& axes : {fine, thick, sheared})
    for (const double degrees : {20.0, 40.0, 60.0}) {
      const Groove groove(degrees, axes);
      OffsetField::Work work;
      const auto field = OffsetField::build(groove.field, groove.bits, nullptr, 1.0, 2, &work).value();
      EXPECT_GT(work.creased, 0u);
      const double with = worst_rest(groove, *field, true), without = worst_rest(groove, *field, false);
      std::printf("groove of %2.0f degrees: ball within %.3f mm; without sheets %.3f mm\n", degrees, with,
                  without);
      EXPECT_LT(with, 0.04 / std::tan(groove.half_angle) * 0.25 + 0.02);
      // Planted fault: without sheets, the error must be much larger.
      EXPECT_GT(without, 4 * with);
    }
}

TEST(CreaseSheets, AreNotMadeForSmoothOrConvexShapes) {
  Volume v = make_volume(ivec3(64), Frame::from_axes(dvec3(-8), glm::dmat3(0.25)).value()).value();
  const auto fill = [&](const auto& depth) {
    for (int z = 0; z < 64; ++z)
      for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
          v.voxels[v.index(x, y, z)] = static_cast<std::int16_t>(std::lround(
              std::clamp(300 + 300 * depth(v.frame.world_from_volume({x, y, z})), -1000.0, 3000.0)));
  };
  const auto creased = [&] {
    const auto base = std::make_shared<const Volume>(copy_of(v).value());
    const Field field(*base, Shape{});
    OffsetField::Work work;
    EXPECT_TRUE(OffsetField::build(field, Occupancy::build(*base, Shape{}), nullptr, 1.0, 1, &work));
    return work.creased;
  };
  fill([](const dvec3& p) { return 4 - glm::length(p); });
  EXPECT_EQ(creased(), 0u) << "ball";
  fill([](const dvec3& p) { return glm::length(p) - 5; });
  EXPECT_EQ(creased(), 0u) << "cavity";
  fill([](const dvec3& p) { return std::min(p.x, 0.8 * p.x + 0.6 * p.y); });
  EXPECT_EQ(creased(), 0u) << "edge";
}

TEST(CreaseSheets, UpdateAddsNoMatter) {
  const Groove groove(40, glm::dmat3(0.3));
  const auto before = OffsetField::build(groove.field, groove.bits, nullptr, 1.2, 1).value();
  RemovalEditor editor(std::make_shared<Version>(groove.base, CutLattice::for_burr(*groove.base, 1).value()),
                       {groove.field});
  const dvec3 flank = 3.0 * groove.up + 3.0 * std::tan(groove.half_angle) * groove.across;
  const RemovalReport report = editor.remove({flank, flank + 2.0 * groove.axis, 1.0});
  const auto version = editor.freeze();
  const auto after = before->updated(groove.field, groove.bits, *version, report.box, 1);
  int freed = 0;
  for (double along = -3; along <= 5; along += 0.21)
    for (double high = 1.5; high <= 6; high += 0.17)
      for (double side = -1; side <= 1; side += 0.19) {
        const dvec3 p = along * groove.axis + high * groove.up + side * groove.across;
        const double was = solid_at(*before, p, true), is = solid_at(*after, p, true);
        ASSERT_LE(is, was + 1e-6);
        freed += was >= 0 && is < 0;
      }
  EXPECT_GT(freed, 50);
}

}  // namespace
}  // namespace trephine::volume
