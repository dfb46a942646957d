// Bodies of revolution and their sweeps, against definitions that share no code with them.
#include "volume/cuts/tool_body.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "volume/cuts/removal.h"
#include "volume/cuts/removal_kernels.h"

namespace trephine::volume {
namespace {

using glm::dvec3;
constexpr double k_pi = std::numbers::pi;

struct NamedBody {
  const char* name;
  ToolBody body;
};
std::vector<NamedBody> bodies() {
  return {{"cylinder", ToolBody::cylinder(1.5, 4, 0.3)},
          {"sharp cylinder", ToolBody::cylinder(2, 3, 0)},
          {"barrel", ToolBody::barrel(2, 1.4, 4, 0.25)},
          {"match head", ToolBody::cone(1.5, 0.9, 3)},
          {"widening", ToolBody::cone(0.8, 1.6, 4)},
          {"capsule", ToolBody::cone(1, 1, 5)},
          {"ball", ToolBody::ball(2)}};
}

/// Returns the radius of a body at `along` (mm) on its axis, by definition: the hull of two balls, or an arc
/// between two caps whose edges are rounded by a rolling ball. Negative: outside.
double profile(const ToolBody& b, double along) {
  double off = -1;
  if (b.form == ToolBody::Form::cone) {
    for (int i = 0; i <= 400; ++i) {
      const double t = i / 400.0, at = t * b.length, r = b.radius + t * (b.end_radius - b.radius);
      const double left = r * r - (along - at) * (along - at);
      if (left >= 0) off = std::max(off, std::sqrt(left));
    }
    return off;
  }
  // All positions of the rolling ball inside the sharp body: a union of balls.
  const double half = 0.5 * b.length, sagitta = b.radius - b.end_radius;
  const double arc = sagitta > 0 ? (half * half + sagitta * sagitta) / (2 * sagitta) : 0;
  const auto room = [&](double s) {  // largest distance of the rolling ball's centre from the axis, mm
    return sagitta > 0 ? std::sqrt((arc - b.edge) * (arc - b.edge) - s * s) - (arc - b.radius)
                       : b.radius - b.edge;
  };
  if (b.edge == 0) return along >= 0 && along <= b.length ? room(along - half) : -1;
  for (int i = 0; i <= 400; ++i) {
    const double s = (2.0 * i / 400 - 1) * (half - b.edge), from_centre = along - half - s;
    const double left = b.edge * b.edge - from_centre * from_centre;
    if (left >= -1e-12) off = std::max(off, room(s) + std::sqrt(std::max(0.0, left)));
  }
  return off;
}

/// Returns the volume of a body, mm^3, as a sum over disks.
double volume_of(const ToolBody& b) {
  double sum = 0;
  constexpr int k_slices = 1000;
  const double low = b.low(), high = b.high();
  for (int i = 0; i < k_slices; ++i) {
    const double off = std::max(0.0, profile(b, low + (i + 0.5) / k_slices * (high - low)));
    sum += k_pi * off * off;
  }
  return sum * (high - low) / k_slices;
}

TEST(ToolBody, DistanceEqualsThatToItsOutline) {
  for (const auto& [name, body] : bodies()) {
    ASSERT_FALSE(check(body).has_value()) << name;
    std::vector<glm::dvec2> outline;
    for (int i = 0; i <= 6000; ++i) {
      const double along = body.low() + i / 6000.0 * (body.high() - body.low());
      const double off = profile(body, along);
      if (off < 0) continue;
      outline.push_back({along, off});
      if (body.form == ToolBody::Form::drum && (i == 0 || i == 6000))  // the caps
        for (int k = 0; k < 600; ++k) outline.push_back({along, k / 600.0 * off});
    }
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> where(-3, 8), off_axis(0, 5);
    double worst = 0;
    for (int i = 0; i < 400; ++i) {
      const double along = where(random), off = off_axis(random);
      double nearest = 1e9;
      for (const glm::dvec2& p : outline) nearest = std::min(nearest, std::hypot(p.x - along, p.y - off));
      const bool is_inside = along >= body.low() && along <= body.high() && off <= profile(body, along);
      worst = std::max(worst, std::abs(body.distance(along, off) - (is_inside ? -nearest : nearest)));
    }
    EXPECT_LT(worst, 4e-3) << name;  // mm, due to the spacing of the outline's points
  }
}

TEST(ToolBody, RefusesInvalidBodies) {
  for (const ToolBody& bad :
       {ToolBody::ball(0), ToolBody::ball(NAN), ToolBody::cone(2, 0.5, 1), ToolBody::cylinder(1, 2, 1),
        ToolBody::cylinder(1, 4, 1.2), ToolBody::barrel(1, 1.2, 4, 0.1), ToolBody::barrel(4, 1, 4, 0.1),
        ToolBody::cylinder(1, -3, 0)})
    EXPECT_TRUE(check(bad).has_value());
}

TEST(ToolBody, MovesSteadilyBetweenPosesHoweverItTurns) {
  for (const dvec3& to :
       {dvec3(1, 0, 0), dvec3(0, 0, -1), glm::normalize(dvec3(0.1, 0.2, -1)), dvec3(0, 0, 1)}) {
    const ToolPose a{{0, 0, 0}, {0, 0, 1}}, b{{3, 0, 1}, to};
    EXPECT_EQ(between(a, b, 0).axis_world, a.axis_world);
    EXPECT_LT(glm::length(between(a, b, 1).axis_world - to), 1e-12);
    ToolPose last = a;
    for (int i = 1; i <= 1000; ++i) {
      const ToolPose next = between(a, b, i / 1000.0);
      EXPECT_NEAR(glm::length(next.axis_world), 1, 1e-12);
      EXPECT_LT(glm::length(next.axis_world - last.axis_world), 0.005);
      last = next;
    }
  }
}

struct Grid {
  const char* name;
  dvec3 spacing;
};
// Spacings (mm) of three isotropic grids and two clinical ones.
const Grid k_grids[] = {{"0.3", {0.3, 0.3, 0.3}},
                        {"0.45", {0.45, 0.45, 0.45}},
                        {"0.6", {0.6, 0.6, 0.6}},
                        {"head CT", {0.45, 0.45, 1.25}},
                        {"thick", {0.4, 0.4, 3}}};

std::shared_ptr<const Volume> block(const dvec3& spacing, double edge_mm) {
  const glm::ivec3 size(glm::ceil(dvec3(edge_mm) / spacing));
  auto v = std::make_shared<Volume>(
      make_volume(size, Frame::from_spacing(-0.5 * spacing * dvec3(size - 1), spacing).value()).value());
  for (auto& x : v->voxels.span()) x = 1000;
  return v;
}

RemovalEditor editor_of(const std::shared_ptr<const Volume>& base, double finest,
                        const RemovalKernels& kernels = best_removal_kernels()) {
  const CutLattice lattice = CutLattice::for_burr(*base, finest).value();
  return RemovalEditor(std::make_shared<Version>(base, lattice), {Field(*base, Shape{})}, kernels);
}

dvec3 direction(std::mt19937_64& random) {
  std::normal_distribution<double> one;
  return glm::normalize(dvec3(one(random), one(random), one(random)));
}

TEST(ToolSweep, AStampHasTheBodysVolumeAtAnyPose) {
  double worst = 0;
  for (const Grid& grid : k_grids) {
    const auto base = block(grid.spacing, 14);
    for (const auto& [name, body] : bodies()) {
      const double exact = volume_of(body), finest = 2 * std::min(body.radius, body.end_radius);
      std::mt19937_64 random(11);
      std::uniform_real_distribution<double> shift(-0.5, 0.5);
      for (int i = 0; i < 3; ++i) {
        RemovalEditor editor = editor_of(base, finest);
        const dvec3 axis = direction(random);
        const dvec3 at = dvec3(shift(random), shift(random), shift(random)) - body.middle() * axis;
        const auto report = editor.remove(ToolSweep{body, {at, axis}, {at, axis}});
        const double found = editor.working().mm3_of(report.removed_units);
        worst = std::max(worst, std::abs(found / exact - 1));
        EXPECT_NEAR(found / exact, 1, 2e-3) << name << " " << grid.name;
      }
    }
  }
  RecordProperty("worst_percent", std::to_string(100 * worst));
}

TEST(ToolSweep, ACapsuleEqualsItsClosedFormAtAnyPoseAndRate) {
  // The radius is 2 and 4 times the largest step of the lattice. The ball moves 4 mm in 20 to 2000 parts, as
  // at 20 mm/s with 100 Hz to 10 kHz.
  for (const Grid& grid : k_grids) {
    const auto base = block(grid.spacing, 16);
    std::mt19937_64 random(21);
    std::uniform_real_distribution<double> shift(-0.5, 0.5);
    for (const auto& [steps, most] : {std::pair(2.0, 0.01), std::pair(4.0, 0.001)})
      for (const int parts : {20, 200, 2000}) {
        if (parts == 2000 && &grid != &k_grids[1]) continue;  // takes seconds
        const CutLattice lattice = CutLattice::for_burr(*base, 2).value();
        const dvec3& h = lattice.frame().spacing();
        const double r = steps * std::max({h.x, h.y, h.z}), path_length = 4;
        RemovalEditor editor(std::make_shared<Version>(base, lattice), {Field(*base, Shape{})});
        const dvec3 along = direction(random);
        const dvec3 start = dvec3(shift(random), shift(random), shift(random)) - 0.5 * path_length * along;
        for (int i = 0; i < parts; ++i)
          editor.remove(Sweep{start + path_length * i / parts * along,
                              start + path_length * (i + 1) / parts * along, r, i > 0});
        const double found = editor.working().mm3_of(editor.working().ledger().total());
        const double exact = k_pi * r * r * path_length + 4.0 / 3 * k_pi * r * r * r;
        EXPECT_NEAR(found / exact, 1, most) << grid.name << " " << steps << " " << parts;
      }
  }
}

TEST(ToolSweep, EachLabelGetsItsShare) {
  // Two labels that meet in a plane between voxels, through the body's centre, and a third label that the
  // body does not touch.
  auto base = std::make_shared<Volume>(
      make_volume(glm::ivec3(40, 24, 24), Frame::from_spacing({-9.75, -5.75, -5.75}, dvec3(0.5)).value(),
                  true)
          .value());
  base->label_names = {"none", "left", "right", "far"};
  for (int z = 0; z < 24; ++z)
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 40; ++x) {
        base->voxels[base->index(x, y, z)] = 1000;
        base->labels[base->index(x, y, z)] = static_cast<std::uint8_t>(x >= 38 ? 3 : x < 20 ? 1 : 2);
      }
  for (const auto& [name, body] : bodies()) {
    RemovalEditor editor = editor_of(base, 1.6);
    const dvec3 axis = glm::normalize(dvec3(0, 0.3, 1));  // along the plane x = 0
    const auto report =
        editor.remove(ToolSweep{body, {-body.middle() * axis, axis}, {-body.middle() * axis, axis}});
    const std::vector<std::int64_t>& units = editor.working().ledger().units_by_label;
    ASSERT_EQ(units.size(), 4u);
    EXPECT_EQ(units[1] + units[2], report.removed_units) << name;
    EXPECT_EQ(units[0] + units[3], 0) << name;
    EXPECT_NEAR(editor.working().mm3_of(units[1]) / (0.5 * volume_of(body)), 1, 4e-3) << name;
    // Density statistics: every voxel is 1000.
    EXPECT_EQ(report.intensity_sum, 1e3 * static_cast<double>(report.removed_units));
    EXPECT_EQ(report.intensity_square_sum, 1e6 * static_cast<double>(report.removed_units));
  }
}

TEST(ToolSweep, SidewaysEqualsTheBodyAndItsShadow) {
  // Across its axis a convex body sweeps its own volume plus the area of its outline times the path length.
  double worst = 0;
  for (const Grid& grid : k_grids) {
    const auto base = block(grid.spacing, 20);
    for (const auto& [name, body] : bodies()) {
      double area = 0;
      for (int i = 0; i < 1000; ++i) {
        const double along = body.low() + (i + 0.5) / 1000 * (body.high() - body.low());
        area += 2 * std::max(0.0, profile(body, along));
      }
      area *= (body.high() - body.low()) / 1000;
      const double exact_body = volume_of(body);
      std::mt19937_64 random(12);
      for (const int parts : {1, 9}) {  // number of sweeps: fast and slow motion
        RemovalEditor editor = editor_of(base, 2 * std::min(body.radius, body.end_radius));
        const dvec3 axis = direction(random), side = glm::normalize(glm::cross(axis, direction(random)));
        const double path_length = 3;
        const dvec3 start = dvec3(0.1, -0.2, 0.15) - body.middle() * axis - 0.5 * path_length * side;
        for (int i = 0; i < parts; ++i)
          editor.remove(ToolSweep{body,
                                  {start + path_length * i / parts * side, axis},
                                  {start + path_length * (i + 1) / parts * side, axis},
                                  i > 0});
        const double found = editor.working().mm3_of(editor.working().ledger().total());
        const double exact = exact_body + area * path_length;
        worst = std::max(worst, std::abs(found / exact - 1));
        EXPECT_NEAR(found / exact, 1, 1e-3) << name << " " << grid.name << " " << parts;
      }
    }
  }
  RecordProperty("worst_percent", std::to_string(100 * worst));
}

/// Returns the number of random points more than 0.1 mm inside the swept volume that are still solid.
int left_on_the_way(const Version& version, const ToolBody& body, const ToolPose& a, const ToolPose& b) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> share(0, 1);
  int left = 0, queried = 0;
  for (int i = 0; i < 20000; ++i) {
    const ToolPose at = between(a, b, share(random));
    const dvec3 side = glm::normalize(glm::cross(at.axis_world, direction(random)));
    const double along = body.low() + share(random) * (body.high() - body.low());
    const double off = share(random) * body.radius;
    if (body.distance(along, off) > -0.1) continue;
    const dvec3 p = at.at_world + along * at.axis_world + off * side;
    ++queried;
    left += version.distance(version.base().frame.volume_from_world(p)) > 0;
  }
  EXPECT_GT(queried, 1000);
  return left;
}

TEST(ToolSweep, LeavesNoGapHoweverFastItMovesAndTurns) {
  const auto base = block(dvec3(0.5, 0.5, 1.5), 30);
  const ToolPose a{{-4, -2, 1}, glm::normalize(dvec3(0.2, 0.1, 1))},
      b{{3, 2, -1}, glm::normalize(dvec3(1, -0.3, -0.4))};
  for (const auto& [name, body] : bodies()) {
    RemovalEditor whole = editor_of(base, 1.6), ends = editor_of(base, 1.6);
    whole.remove(ToolSweep{body, a, b});
    EXPECT_EQ(left_on_the_way(whole.working(), body, a, b), 0) << name;
    for (const ToolPose& end : {a, b}) ends.remove(ToolSweep{body, end, end});
    EXPECT_GT(left_on_the_way(ends.working(), body, a, b), 1000) << name;  // gaps are detected
  }
}

/// Nothing changes outside the reported box: the distances at all voxel centres are compared before and
/// after. The box must be little larger than the swept volume, since fields are rebuilt in the whole box.
TEST(ToolSweep, ChangesNothingBeyondItsBoxAndThatIsTight) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> one;
  for (const Grid& grid : k_grids) {
    const auto base = block(grid.spacing, 24);
    for (const ToolBody& body : {ToolBody::cylinder(1.15, 14, 0.05), ToolBody::cone(0.8, 1.2, 9)})
      for (int i = 0; i < 2; ++i) {
        RemovalEditor editor = editor_of(base, 1.6);
        const dvec3 axis = direction(random),
                    to = glm::normalize(axis + 0.1 * dvec3(one(random), one(random), one(random)));
        const ToolPose a{-body.middle() * axis, axis}, b{a.at_world + 0.5 * direction(random), to};
        const std::shared_ptr<const Version> before = editor.freeze();
        const RemovalReport report = editor.remove(ToolSweep{body, a, b});
        const std::shared_ptr<const Version> after = editor.freeze();
        // Larger distances are not compared: versions store distances only up to about this limit.
        const double far = after->lattice().frame().diagonal_mm();
        dvec3 low(1e9), high(-1e9);
        long changed = 0;
        for (int z = 0; z < base->size.z; ++z)
          for (int y = 0; y < base->size.y; ++y)
            for (int x = 0; x < base->size.x; ++x) {
              const dvec3 p(x, y, z);
              if (std::min(before->distance(p), far) == std::min(after->distance(p), far)) continue;
              ++changed;
              low = glm::min(low, p), high = glm::max(high, p);
            }
        ASSERT_GT(changed, 50);
        for (int k = 0; k < 3; ++k) {
          EXPECT_GE(low[k], report.box.low[k]) << grid.name;
          EXPECT_LE(high[k], report.box.high[k]) << grid.name;
          // The box may exceed the changed voxels by a band, and by one voxel.
          const double band = 1.5 + 2.5 * editor.working().lattice().frame().diagonal_mm();
          EXPECT_GE(report.box.low[k], low[k] - band / grid.spacing[k] - 1) << grid.name;
          EXPECT_LE(report.box.high[k], high[k] + band / grid.spacing[k] + 1) << grid.name;
        }
      }
  }
}

TEST(ToolSweep, SamplesEqualTheLeastDistanceOverAllPoses) {
  // A brute-force twin in double precision over a path that turns, on a sheared grid.
  glm::dmat3 sheared(0.0);
  sheared[0][0] = 0.5, sheared[1][1] = 0.6, sheared[2][2] = 0.9, sheared[2][1] = 0.3;
  auto base = std::make_shared<Volume>(
      make_volume(glm::ivec3(24), Frame::from_axes({1, 2, 3}, sheared).value()).value());
  for (auto& x : base->voxels.span()) x = 1000;
  for (const auto& [name, body] : bodies()) {
    if (body.is_ball()) continue;
    RemovalEditor editor = editor_of(base, 1.6);
    const dvec3 middle = base->frame.world_from_volume(dvec3(11.5));
    const ToolPose a{middle + dvec3(-1, -0.4, -2), glm::normalize(dvec3(0.2, 0.1, 1))},
        b{middle + dvec3(1.2, 0.5, -1), glm::normalize(dvec3(0.6, -0.3, 0.8))};
    editor.remove(ToolSweep{body, a, b});
    const auto version = editor.publish();
    const CutLattice& lattice = version->lattice();
    double worst = 0, deepest = 0;
    for (int z = 0; z < lattice.size().z; z += 5)
      for (int y = 0; y < lattice.size().y; y += 4)
        for (int x = 0; x < lattice.size().x; x += 3) {
          const dvec3 p = lattice.frame().world_from_volume({x, y, z});
          double d = 1e9;
          for (int i = 0; i <= 160; ++i) {
            const ToolPose at = between(a, b, i / 160.0);
            const dvec3 w = p - at.at_world;
            const double along = glm::dot(w, at.axis_world);
            d = std::min(d, body.distance(along, glm::length(w - along * at.axis_world)));
          }
          const double found = version->sample_distance({x, y, z});
          d = std::clamp(d, -version->band_mm(), version->band_mm());
          worst = std::max(worst, std::abs(found - d));
          deepest = std::min(deepest, found);
        }
    EXPECT_LT(deepest, -0.25) << name;
    EXPECT_LT(worst, 0.02 * 1.6 / 2 / 3 + 0.006) << name;  // mm: the allowance, and the gap between poses
  }
}

TEST(ToolSweep, BothKernelsMakeTheSameBits) {
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "no AVX2 here";
  const auto base = block(dvec3(0.45, 0.45, 1.25), 9);
  for (const auto& [name, body] : bodies()) {
    std::uint64_t hashes[2];
    for (const int wide : {0, 1}) {
      RemovalEditor editor = editor_of(base, 1.6, wide ? k_removal_kernels_8 : k_removal_kernels_4);
      editor.remove(ToolSweep{
          body, {{-0.6, -0.5, 0.3}, {0, 0, 1}}, {{0.5, 0.5, -0.4}, glm::normalize(dvec3(1, 0.2, 1))}});
      hashes[wide] = editor.publish()->content_hash();
    }
    EXPECT_EQ(hashes[0], hashes[1]) << name;
  }
}

}  // namespace
}  // namespace trephine::volume
