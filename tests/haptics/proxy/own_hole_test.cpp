// A hole is as wide as the burr that made it, for any voxel spacing, both for the hand and for the ledger of
// removed matter.
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

#include "haptics/walls/smooth_walls.h"
#include "tests/haptics/proxy/method_play.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

volume::Frame sheared(const dvec3& spacing, double degrees) {
  glm::dmat3 axes(0.0);
  for (int a = 0; a < 3; ++a) axes[a][a] = spacing[a];
  axes[2][1] = spacing.z * std::tan(degrees / 57.29577951308232);
  return volume::Frame::from_axes({3, -7, 11}, axes).value();
}

/// Bone of one density in a box of about `extent` mm.
TouchScene bone_block(const volume::Frame& frame, const dvec3& extent) {
  const glm::ivec3 size = glm::max(glm::ivec3(glm::ceil(extent / frame.spacing())), glm::ivec3(4));
  volume::Volume v = volume::make_volume(size, frame).value();
  for (auto& x : v.voxels.span()) x = 1200;
  return scenes::scene_of(std::move(v));
}

struct Hole {
  dvec3 start, end;
  double radius;
  double from_axis(const dvec3& p) const {
    const dvec3 way = end - start;
    const double t = std::clamp(glm::dot(p - start, way) / glm::dot(way, way), 0.0, 1.0);
    return glm::length(p - start - t * way);
  }
};

struct OwnHoleCase {
  const char* name;
  dvec3 spacing;
  double shear;
  double burr;  ///< diameter, mm
};

class OwnHole : public testing::TestWithParam<OwnHoleCase> {};

struct HoleReport {
  /// Solid points inside the hole, and free points outside it, that are farther from its wall than 0.1 mm and
  /// 0.3 radii, whichever is less.
  long held_inside = 0, free_outside = 0;
  /// Relative errors of the ledger, by the swept volume, and of the free volume, by the ledger.
  double ledger_error = 0, free_volume_error = 0;
};

/// Cuts a hole three burr diameters long through the middle of the scene, with a direction and an offset from
/// `seed`, and probes it point by point.
HoleReport probe_hole(const TouchScene& scene, const volume::CutLattice& lattice, double burr,
                      std::uint64_t seed) {
  const double r = 0.5 * burr;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> part(-1, 1);
  const auto anywhere = [&] {
    const double x = part(random), y = part(random);
    return dvec3(x, y, part(random));
  };
  const volume::Frame& frame = scene.base->frame;
  const dvec3 middle = frame.world_from_volume(0.5 * dvec3(scene.base->size - 1) + 0.5 * anywhere());
  const dvec3 direction = glm::normalize(anywhere());
  const Hole hole{middle - 1.5 * burr * direction, middle + 1.5 * burr * direction, r};
  volume::RemovalEditor editor(std::make_shared<volume::Version>(scene.base, lattice),
                               {scene.items[0].field});
  // The hole is cut in steps, as a drill cuts it tick by tick.
  constexpr int k_ticks = 15;
  const dvec3 bite = (hole.end - hole.start) / double(k_ticks);
  for (int i = 0; i < k_ticks; ++i)
    editor.remove({hole.start + double(i) * bite, hole.start + double(i + 1) * bite, r, i > 0});
  const auto version = editor.publish();

  const ShapeSet none;
  ProxyCounters counters;
  SmoothWalls walls(scene, *version, none, counters);
  HoleReport report;
  const double step = r / 12, slack = std::min(0.1, 0.3 * r);
  const int reach = static_cast<int>((1.5 * burr + 1.4 * r) / step);
  long touched = 0;
  for (int z = -reach; z <= reach; ++z)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const dvec3 p = middle + step * (dvec3(x, y, z) + dvec3(0.31, 0.17, 0.43));
        const double from_wall = r - hole.from_axis(p);
        if (from_wall < -0.4 * r) continue;
        const bool is_solid = walls.is_solid(0, frame.volume_from_world(p));
        touched += !is_solid;
        report.held_inside += is_solid && from_wall > slack;
        report.free_outside += !is_solid && from_wall < -slack;
      }
  constexpr double k_pi = 3.14159265358979;
  const double swept = k_pi * r * r * (3 * burr) + 4.0 / 3 * k_pi * r * r * r;
  const double ledger = version->mm3_of(version->ledger().total());
  report.ledger_error = std::abs(ledger / swept - 1);
  report.free_volume_error = std::abs(static_cast<double>(touched) * step * step * step / ledger - 1);
  return report;
}

TouchScene block_for(const OwnHoleCase& c) {
  const dvec3 extent = glm::max(dvec3(6 * c.burr), 4.0 * c.spacing) + dvec3(0, 0, c.spacing.z);
  return bone_block(sheared(c.spacing, c.shear), extent);
}

/// In the hole of a burr, a point is free up to 0.1 mm from the wall, and solid from 0.1 mm beyond the wall
/// on (less for small burrs). The free volume equals the ledger, and the ledger equals the swept volume.
TEST_P(OwnHole, IsFreeAndAsLargeAsTheLedgerReports) {
  const OwnHoleCase& c = GetParam();
  const TouchScene scene = block_for(c);
  const volume::CutLattice lattice = volume::CutLattice::for_burr(*scene.base, c.burr).value();
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const HoleReport report = probe_hole(scene, lattice, c.burr, seed);
    EXPECT_EQ(report.held_inside, 0);
    EXPECT_EQ(report.free_outside, 0);
    EXPECT_LT(report.ledger_error, 0.001);
    EXPECT_LT(report.free_volume_error, 0.01);
  }
}

/// Planted fault: if a hole is cut on the voxels of the scan, the small burr does not fit into it.
TEST(OwnHole, CutOnTheVoxelsASmallBurrIsHeldInItsHole) {
  const OwnHoleCase clinical{"clinical", {0.5, 0.5, 1.25}, 0, 1};
  const TouchScene scene = block_for(clinical);
  const HoleReport report = probe_hole(scene, volume::CutLattice(*scene.base), clinical.burr, 1);
  EXPECT_GT(report.held_inside, 100);
  EXPECT_GT(report.free_volume_error, 0.1);
}

/// A point moves down the hole of a burr to its end, 0.15 mm from the wall, or on the axis for methods on
/// cubes. Methods on triangles and on cubes refuse burrs that are too small for the voxels. Other methods
/// that guarantee no solid are not moved.
TEST(OwnHole, EveryMethodReachesItsEnd) {
  struct Case {
    dvec3 spacing;
    double burr;
    bool has_triangles, has_voxels;  ///< methods on triangles, and on cubes, accept this burr
  };
  for (const Case& c : {Case{{0.5, 0.5, 0.5}, 4, true, true},
                        {{0.5, 0.5, 1}, 2, true, true},
                        {{0.4, 0.4, 2}, 2, true, false},
                        {{0.5, 0.5, 1.25}, 1, false, false},
                        {{0.5, 0.5, 3}, 2, false, false},
                        {{0.5, 0.5, 5}, 1, false, false}}) {
    TouchScene scene = bone_block(sheared(c.spacing, 0), dvec3(12, 12, 15));
    ASSERT_FALSE(set_smallest_burr(scene, c.burr));
    for (const MethodInfo& info : method_catalogue()) {
      const std::string name = info.name;
      if (!info.takes_points) continue;
      SCOPED_TRACE(testing::Message() << name << ", " << c.spacing.z << " mm, burr " << c.burr);
      const auto method = make_method(name).value();
      const bool is_net = name.starts_with("explicit"), is_mesh = !info.takes_cuts;
      const bool is_cubes =
          name == "implicit" || name == "path" || name == "scene-sequential" || name == "raystep";
      const Status refused = method->prepare(scene);
      ASSERT_EQ(bool(refused), is_mesh || (is_net && !c.has_triangles) || (is_cubes && !c.has_voxels));
      if (refused) {
        EXPECT_NE(refused->remedy.find("subvoxel"), std::string::npos);
        continue;
      }
      if (info.solid == MethodInfo::Solid::nothing && !is_cubes) continue;
      double worst = 0;
      for (int k = 0; k < 5; ++k) {
        const dvec3 axis = glm::normalize(dvec3(0.4 * std::sin(2.1 * k), 0.4 * std::cos(3.3 * k), 1)),
                    top = scene.base->frame.world_from_volume(0.5 * dvec3(scene.base->size)) +
                          dvec3(0.037 * k, 0.023 * k, 0) + 4.0 * axis,
                    aside = (is_cubes ? 0 : 0.5 * c.burr - std::min(0.15, 0.25 * c.burr)) *
                            glm::normalize(glm::cross(axis, dvec3(1, 0.3 * k, 0.2)));
        volume::RemovalEditor editor(uncut_version(scene), {scene.items[0].field});
        for (int i = 0; i < 40; ++i)
          editor.remove({top - 0.2 * i * axis, top - 0.2 * (i + 1) * axis, 0.5 * c.burr, i > 0});
        const auto version = editor.publish();
        ProxyState state;
        for (double depth = 0; depth < 8; depth += 0.01) {
          const dvec3 hip = top + aside - depth * axis;
          const ProxyStep step = method->step(scene, *version, state, {hip});
          if (step.has_contact) worst = std::max(worst, glm::length(step.proxy_world - hip));
        }
      }
      EXPECT_LT(worst, is_net ? 0.11 : 1e-3);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, OwnHole,
                         testing::Values(OwnHoleCase{"fine", {0.2, 0.2, 0.2}, 0, 0.5},
                                         OwnHoleCase{"isotropic", {0.5, 0.5, 0.5}, 0, 4},
                                         OwnHoleCase{"small_in_coarse", {0.5, 0.5, 0.5}, 0, 0.5},
                                         OwnHoleCase{"clinical", {0.5, 0.5, 1.25}, 0, 1},
                                         OwnHoleCase{"slices_of_2", {0.4, 0.4, 2}, 0, 2},
                                         OwnHoleCase{"slices_of_3", {0.5, 0.5, 3}, 0, 2},
                                         OwnHoleCase{"large_in_3", {0.5, 0.5, 3}, 0, 6},
                                         OwnHoleCase{"slices_of_5", {0.4, 0.4, 5}, 0, 0.5},
                                         OwnHoleCase{"tilted", {0.45, 0.45, 2.5}, 30, 1.5},
                                         OwnHoleCase{"micrometres", {0.02, 0.02, 0.1}, 0, 0.1}),
                         [](const auto& info) { return std::string(info.param.name); });

/// A point moves down the hole of a burr to its bottom and is held there, with the smooth methods.
TEST(OwnHole, TheTipFollowsTheHandToTheBottom) {
  for (const double burr : {0.5, 1.0, 2.0}) {
    for (const char* name : {"subvoxel", "scene"}) {
      const dvec3 spacing(0.5, 0.5, burr == 0.5 ? 5 : 2);
      Play play(name, bone_block(sheared(spacing, 15), dvec3(20, 20, 40)));
      play.no_friction();
      const volume::CutLattice lattice = volume::CutLattice::for_burr(*play.scene.base, burr).value();
      volume::RemovalEditor editor(std::make_shared<volume::Version>(play.scene.base, lattice),
                                   {play.scene.items[0].field});
      const dvec3 middle = play.scene.base->frame.world_from_volume(0.5 * dvec3(play.scene.base->size - 1));
      const dvec3 down = glm::normalize(dvec3(0.3, -0.2, -1));
      // From outside the block, through its border.
      const dvec3 start = middle - 30.0 * down, end = middle + 3.13 * down;
      editor.remove({start, end, 0.5 * burr, false});
      play.set_version(editor.publish());
      const dvec3 axis_end = end + 0.5 * burr * down;
      double worst = 0, deepest = 0;
      for (int i = 0; i <= 400; ++i) {
        const dvec3 hip = start + (i / 400.0) * (end + 2.0 * down - start);
        const ProxyStep s = play.step(hip);
        const double beyond = glm::dot(hip - axis_end, down);
        if (beyond < -0.1) {
          worst = std::max(worst, glm::length(s.proxy_world - hip));
        } else if (beyond > 0.1) {
          EXPECT_TRUE(s.has_contact);
          deepest = std::max(deepest, std::abs(glm::dot(s.proxy_world - axis_end, down)));
        }
      }
      EXPECT_LT(worst, 1e-6) << name << " " << burr;
      EXPECT_LT(deepest, 0.1) << name << " " << burr;
      EXPECT_EQ(play.judge.fall_throughs(), 0);
    }
  }
}

/// A hand moves in crossing grooves of a small burr, in a scan of thick slices. The walls hold the proxy: it
/// never passes through a wall and is never buried.
TEST(OwnHole, NothingIsPassedInCrossingGroovesUnderThickSlices) {
  for (const char* name : {"subvoxel", "scene"}) {
    Play play(name, bone_block(sheared({0.5, 0.5, 3}, 20), dvec3(14, 14, 18)));
    play.no_friction();
    const volume::CutLattice lattice = volume::CutLattice::for_burr(*play.scene.base, 1).value();
    volume::RemovalEditor editor(std::make_shared<volume::Version>(play.scene.base, lattice),
                                 {play.scene.items[0].field});
    const dvec3 middle = play.scene.base->frame.world_from_volume(0.5 * dvec3(play.scene.base->size - 1));
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> part(-3, 3);
    dvec3 at = middle;
    for (int i = 0; i < 40; ++i) {
      const double x = part(random), y = part(random);
      const dvec3 to = middle + dvec3(x, y, part(random));
      editor.remove({at, to, i % 3 == 0 ? 0.5 : 0.8, false});
      at = to;
    }
    play.set_version(editor.publish());
    play.state.begin_at(play.scene.base->frame.volume_from_world(middle));
    const PosePath walk = scenes::rough_walk(middle - 4.0, middle + 4.0, 0.4, 3000, 11);
    long buried = 0;
    for (const auto& sample : walk.samples()) buried += play.step(sample.pose.position_world).is_buried;
    EXPECT_EQ(buried, 0) << name;
    EXPECT_EQ(play.judge.fall_throughs(), 0) << name;
    EXPECT_GT(play.contacts, 1000) << name;
  }
}

}  // namespace
}  // namespace trephine::haptics
