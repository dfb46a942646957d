#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "apps/verify/fall_through.h"
#include "haptics/methods/methods.h"
#include "haptics/proxy/implicit_proxy.h"
#include "modules/drilling/burr.h"
#include "sim/drivers/lockstep.h"

namespace trephine::drilling {
namespace {

using glm::dvec3;
constexpr double k_pi = 3.14159265358979323846;

haptics::TouchScene block_scene(double spacing, double edge = 24) {
  haptics::TouchScene scene;
  const int n = static_cast<int>(std::lround(edge / spacing));
  auto v =
      volume::make_volume(
          glm::ivec3(n), volume::Frame::from_spacing(dvec3(-0.5 * spacing * (n - 1)), dvec3(spacing)).value())
          .value();
  for (auto& x : v.voxels.span()) x = 1600;
  v.is_hounsfield = true;
  scene.base = std::make_shared<const volume::Volume>(std::move(v));
  const volume::Shape shape;
  scene.items.push_back(
      {volume::Field(*scene.base, shape),
       std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, shape)),
       {},
       haptics::Side::front});
  return scene;
}

haptics::TouchScene flat_bone(double spacing) {  // solid below z = 0
  data_tools::PhantomOptions o;
  const int n = static_cast<int>(std::lround(24 / spacing));
  o.size = glm::ivec3(n);
  o.spacing_mm = dvec3(spacing);
  o.psf_sigma_voxels = 1;
  o.parameters = {{"angle", 0}};
  return scenes::phantom_scene("plane", o);
}

double drill(const haptics::TouchScene& scene, const haptics::PosePath& path, double rate,
             const Burr& options, std::shared_ptr<const volume::Version>* end = nullptr) {
  haptics::ImplicitProxy method;
  EXPECT_FALSE(method.prepare(scene).has_value());
  sim::Lockstep run(scene, method, burr(options), {}, rate);
  for (const double t : haptics::servo_times(path, rate)) run.step(path.at(t));
  if (end) *end = run.engine().version();
  return run.engine().removed_mm3();
}

haptics::PosePath bent_path() {
  return haptics::PosePath::from_samples({{0, {{-5, -4, 0}}}, {0.4, {{4, -3, 2}}}, {0.9, {{3, 5, -2}}}},
                                         "test")
      .value();
}

TEST(Drilling, KinematicVolumeAgreesAtEveryRate) {
  const haptics::TouchScene scene = block_scene(0.5);
  const Burr options{4, 30, 20, true};
  const double slow = drill(scene, bent_path(), 100, options);
  for (const double rate : {1000.0, 10000.0})
    EXPECT_NEAR(drill(scene, bent_path(), rate, options) / slow, 1, 1e-3);
}

TEST(Drilling, KinematicVolumeEqualsTheCapsulesAtThreeVoxelSizes) {
  const dvec3 a(-5, -4, 1), b(4, 3, -2);
  const auto path = haptics::PosePath::from_samples({{0, {a}}, {1, {b}}}, "test").value();
  const double r = 2.4, exact = k_pi * r * r * glm::length(b - a) + 4.0 / 3.0 * k_pi * r * r * r;
  for (const double spacing : {0.3, 0.45, 0.6})  // radius 8, 5.3 and 4 voxels
    EXPECT_NEAR(drill(block_scene(spacing), path, 1000, {2 * r, 30, 20, true}) / exact, 1, 0.01) << spacing;
}

TEST(Drilling, CutSurfaceEqualsTheCapsules) {
  const dvec3 a(-5, -4, 1), b(4, 3, -2);
  const auto path = haptics::PosePath::from_samples({{0, {a}}, {1, {b}}}, "test").value();
  const double r = 3.0, spacing = 0.5;
  std::shared_ptr<const volume::Version> version;
  drill(block_scene(spacing), path, 1000, {2 * r, 30, 20, true}, &version);
  // Finds the zero of the trilinear distance by bisection on rays from the capsule's axis.
  double worst = 0;
  int count = 0;
  for (int i = 0; i < 4000; ++i) {
    const double z = 1 - 2 * (i + 0.5) / 4000, phi = 2.399963 * i, s = std::sqrt(1 - z * z);
    const dvec3 direction(s * std::cos(phi), s * std::sin(phi), z), from = a + (i % 17) / 16.0 * (b - a);
    double low = 0, high = 22;
    for (int k = 0; k < 60; ++k) {
      const double mid = 0.5 * (low + high);
      (version->distance(version->base().frame.volume_from_world(from + mid * direction)) <= 0 ? low : high) =
          mid;
    }
    const dvec3 p = from + low * direction, ab = b - a;
    const double t = std::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0, 1.0);
    worst = std::max(worst, std::abs(glm::length(p - a - t * ab) - r) / spacing);
    ++count;
  }
  EXPECT_EQ(count, 4000);
  EXPECT_LT(worst, 0.05);
}

TEST(Drilling, ThroughTheProxyTheHoleDoesNotDependOnRateOrVoxels) {
  // The hand presses slowly to a depth of 3 mm, and then moves along x. The burr's lowest point follows the
  // HIP.
  const auto path = haptics::PosePath::from_samples({{0, {{-3, 0.2, 2}}},
                                                     {0.5, {{-3, 0.2, 0}}},
                                                     {3.5, {{-3, 0.2, -3}}},
                                                     {9.5, {{3, 0.2, -3}}},
                                                     {10, {{3, 0.2, 4}}}},
                                                    "test")
                        .value();
  const double r = 3;
  std::vector<double> volumes;
  const std::pair<double, double> settings[] = {
      {0.4, 1000}, {0.5, 250}, {0.5, 4000}, {0.6, 250}, {0.6, 1000}};
  for (const auto& [spacing, rate] : settings) {
    haptics::TouchScene scene = flat_bone(spacing);
    scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = 0;
    volumes.push_back(drill(scene, path, rate, {2 * r, 60, 20, false}));
  }
  // The ball's lowest point reaches 3 mm below z = 0 and moves 6 mm: half a ball and half a cylinder.
  const double exact = 0.5 * (4.0 / 3.0 * k_pi * r * r * r + k_pi * r * r * 6);
  for (const double v : volumes) EXPECT_NEAR(v / exact, 1, 0.02);
  std::string shown;
  for (const double v : volumes) shown += std::to_string(v / exact) + " ";
  RecordProperty("over_exact", shown);
}

TEST(Drilling, RemovalRateHoldsAtAnyServoRateAndVoxelSize) {
  const auto path =
      haptics::PosePath::from_samples({{0, {{0, 0, 2}}}, {0.1, {{0, 0, -6}}}, {1.1, {{0, 0, -6}}}}, "test")
          .value();
  for (const double spacing : {0.3, 0.6})
    for (const double rate : {500.0, 2000.0}) {
      const double removed = drill(flat_bone(spacing), path, rate, {6, 30, 20, false});
      EXPECT_NEAR(removed, 32.36, 0.05) << spacing << " " << rate;
    }
}

TEST(Drilling, TheProxyNeverFallsThroughDuringDrilling) {
  haptics::TouchScene scene = flat_bone(0.6);
  haptics::ImplicitProxy method;
  ASSERT_FALSE(method.prepare(scene).has_value());
  const Burr burr{4, 60, 40, false};
  sim::Lockstep run(scene, method, drilling::burr(burr), {}, 1000);
  std::shared_ptr<const volume::Version> seen = run.engine().version();
  verify::FallThroughJudge judge(scene.base->size, [&](int x, int y, int z) {
    return scene.base->voxels[scene.base->index(x, y, z)] >= 300 && seen->voxel_distance(x, y, z) > 0;
  });
  const haptics::PosePath path = scenes::rough_walk(dvec3(-9, -9, -7), dvec3(9, 9, 3), 0.4, 15000, 21);
  for (const auto& s : path.samples()) {
    seen = run.engine().version();
    run.step(s.pose);
    const auto& step = run.last_step();
    judge.judge_step({std::span(step.path_volume.data(), static_cast<std::size_t>(step.waypoint_count)),
                      scene.base->frame.volume_from_world(run.last_record().pose.position_world),
                      step.has_contact, step.is_buried});
  }
  EXPECT_EQ(judge.fall_throughs(), 0);
  EXPECT_EQ(judge.buried_starts(), 0);  // a removal never buries the proxy
  EXPECT_GT(run.engine().removed_mm3(), 50);
}

/// In every frame and unit, drills a slanted hole in the middle of the scan, and two holes of twice that
/// length that are centred on the border. Half of each of these two holes is outside the scan.
TEST(Drilling, KinematicVolumeEqualsTheCapsulesInEveryFrameUnitAndMask) {
  for (const scenes::Scan& scan : scenes::k_scans) {
    SCOPED_TRACE(scan.name());
    haptics::TouchScene scene = scenes::scan_scene(scan, true);
    const volume::Frame& frame = scene.base->frame;
    const double r = 4.5 * scan.unit, length = 20 * scan.unit;
    ASSERT_FALSE(haptics::set_smallest_burr(scene, 2 * r).has_value());
    const auto method = haptics::make_method(haptics::k_default_method).value();
    ASSERT_FALSE(method->prepare(scene).has_value());
    const dvec3 size(scene.base->size),
        middle = frame.world_from_volume(0.5 * (size - 1.0)),
        face = frame.world_from_volume({-0.5, 0.5 * (size.y - 1), 0.5 * (size.z - 1)}),
        slant = glm::normalize(dvec3(3, -2, 1.5)), inward = glm::normalize(frame.axes()[0]);
    const double ball = 4.0 / 3.0 * k_pi * r * r * r, disk = k_pi * r * r;
    const struct {
      dvec3 from, to;
      double exact;
    } holes[] = {{middle - 0.5 * length * slant, middle + 0.5 * length * slant, disk * length + ball},
                 {face - length * slant, face + length * slant, disk * length + 0.5 * ball},
                 {face - length * inward, face + length * inward, disk * length + 0.5 * ball}};
    for (const auto& hole : holes) {
      const auto path = haptics::PosePath::from_samples({{0, {hole.from}}, {0.2, {hole.to}}}, "test").value();
      sim::Lockstep run(scene, *method, burr({2 * r, 30, 20, true}), {}, 1000);
      for (const double t : haptics::servo_times(path, 1000)) run.step(path.at(t));
      EXPECT_NEAR(run.engine().removed_mm3() / hole.exact, 1, 1e-3);
    }
  }
}

}  // namespace
}  // namespace trephine::drilling
