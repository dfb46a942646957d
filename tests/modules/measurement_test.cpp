// Measures against closed forms, as functions and as commands of an operation.
#include "modules/measurement/measurement.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "data-tools/phantoms/phantoms.h"
#include "haptics/methods/methods.h"
#include "sim/drivers/lockstep.h"
#include "tests/modules/xray_scenes.h"
#include "volume/cuts/removal.h"

namespace trephine::measurement {
namespace {

using glm::dvec3;

/// Returns a ball of 30 mm radius around the origin, in voxels that may be sheared. Intensity falls by 400 HU
/// per mm at its surface.
std::shared_ptr<const volume::Volume> ball(const glm::dmat3& axes, const glm::ivec3& size) {
  return fluoroscopy::scan_of(size, axes, [](const dvec3& p) {
    return std::clamp(300 + 400 * (30 - glm::length(p)), -1000.0, 1200.0);
  });
}

TEST(Measurement, FollowsClosedForms) {
  const glm::dmat3 leaning(dvec3(0.9, 0, 0), dvec3(0, 0.9, 0), dvec3(0.2, 0.4, 2));
  for (const auto& scan :
       {ball(fluoroscopy::straight(dvec3(1)), {72, 72, 72}), ball(leaning, {84, 96, 38})}) {
    const volume::Field bone(*scan, volume::Shape{"bone", 300});
    volume::RemovalEditor editor(
        std::make_shared<volume::Version>(scan, volume::CutLattice::for_burr(*scan, 6).value()), {bone});
    const auto version = editor.freeze();
    const auto measured = [&](Kind kind, std::vector<dvec3> at, double radius = 5) {
      return measure({kind, std::move(at), radius, 0}, bone, *version);
    };
    EXPECT_NEAR(measured(Kind::ruler, {{1, 2, 3}, {4, 6, 15}}).length, 13, 1e-12);
    EXPECT_NEAR(measured(Kind::angle, {{5, 0, 0}, {0, 0, 0}, {0, 0, 7}}).angle, 90, 1e-9);
    EXPECT_NEAR(measured(Kind::angle, {{1, 0, 0}, {0, 0, 0}, {-1, 1e-9, 0}}).angle, 180, 1e-6);
    EXPECT_NEAR(measured(Kind::angle, {{3, 4, 0}, {0, 0, 0}, {3, 4, 0}}).angle, 0, 1e-5);
    // A tape along a quarter of a great circle, in two parts. Pulled taut, the tape stays on the ball.
    const double s = 30 * std::sqrt(0.5);
    const Measured tape = measured(Kind::tape, {{30, 0, 0}, {s, s, 0}, {0, 30, 0}});
    ASSERT_EQ(tape.problem, "");
    EXPECT_NEAR(tape.length, 47.124, 0.01 * 47.124);
    EXPECT_NEAR(tape.taut, 47.124, 0.01 * 47.124);
    EXPECT_NEAR(tape.straight, 30 * std::sqrt(2.0), 0.3);
    const Measured region = measured(Kind::region, {{0, 0, 0}}, 10);
    EXPECT_NEAR(region.mean, 1200, 1e-9);
    EXPECT_NEAR(region.deviation, 0, 1e-6);
    EXPECT_NEAR(region.size, 4188.8, 0.05 * 4188.8);
    EXPECT_NE(measured(Kind::region, {{0, 0, 900}}).problem, "");
    // A groove crosses the path: the line on the surface goes down into the groove, the taut tape passes over
    // it.
    editor.remove({{20, 20, -40}, {20, 20, 40}, 5});
    const Measured cut = measure({Kind::tape, {{30, 0, 0}, {0, 30, 0}}, 5, 0}, bone, *editor.freeze());
    EXPECT_GT(cut.length, tape.length + 1.5);
    EXPECT_LT(cut.taut, tape.length);
    EXPECT_GT(cut.taut, cut.straight);
  }
}

TEST(Measurement, IsACommandOfAnOperation) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(48);
  haptics::TouchScene scene = scenes::phantom_scene("sphere", o);
  const auto method = haptics::make_method("subvoxel").value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  const Measurement module;
  const sim::Catalogue catalogue({&module});
  sim::Lockstep run(sim::Engine(scene, *method, {}, 1e-3, catalogue), {}, 1000);
  const std::uint64_t start = run.engine().state().hash();
  for (const Measure& bad :
       {Measure{Kind::ruler, {dvec3(0)}}, Measure{Kind::angle, {dvec3(0), dvec3(1)}},
        Measure{Kind::tape, {dvec3(0)}}, Measure{Kind::region, {}},
        Measure{Kind::ruler, {dvec3(0), dvec3(NAN)}}, Measure{Kind::tape, {dvec3(0), dvec3(1)}, 5, 7}})
    EXPECT_TRUE(run.apply_and_finish({bad, 0}).refused.has_value()) << sim::Value(bad).words();
  EXPECT_EQ(run.engine().state().hash(), start);
  EXPECT_TRUE(run.engine().overlays().empty());
  EXPECT_FALSE(run.apply_and_finish({Measure{Kind::tape, {{40, 0, 0}, {0, 40, 0}}}, 0}).refused.has_value());
  const auto* last = run.engine().state().result_of<MeasurementState>();
  ASSERT_NE(last, nullptr);
  EXPECT_NEAR(last->length / last->straight, 3.14159265 / 2 / std::sqrt(2.0), 0.02);
  // The overlay draws the tape as dashes along its whole line, and a label with its length.
  const sim::Overlays seen = run.engine().overlays();
  ASSERT_EQ(seen.size(), 1u);
  double drawn = 0;
  for (const auto& dash : seen[0].lines) drawn += glm::length(dash[1] - dash[0]);
  EXPECT_NEAR(drawn / last->length, 2 / 3.5, 0.06);
  ASSERT_EQ(seen[0].labels.size(), 1u);
  EXPECT_NE(seen[0].labels[0].text.find(" mm"), std::string::npos);
}

/// Patches are regular polygons of great circles with n corners at an angle r from a pole. Each interior
/// angle is 2 atan(1 / (cos r tan(pi / n))). By Girard's theorem, the area is the squared radius times the
/// excess of the sum of the angles over (n - 2) pi.
TEST(Measurement, PatchesAndPartsFollowClosedForms) {
  const glm::dmat3 leaning(dvec3(0.9, 0, 0), dvec3(0, 0.9, 0), dvec3(0.2, 0.4, 2));
  for (const auto& scan :
       {ball(fluoroscopy::straight(dvec3(1)), {72, 72, 72}), ball(leaning, {84, 96, 38})}) {
    const volume::Field bone(*scan, volume::Shape{"bone", 300});
    const volume::Version uncut(scan);
    const double pi = 3.14159265358979;
    for (const auto& [corners, angle] : {std::pair(5, 0.35), std::pair(8, 0.6), std::pair(3, 0.5)})
      for (const bool is_turned : {false, true}) {
        std::vector<dvec3> at;
        for (int i = 0; i < corners; ++i) {
          const double turn = (is_turned ? -2 : 2) * pi * i / corners;
          const dvec3 p(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn), std::cos(angle));
          at.push_back(30.0 * (is_turned ? dvec3(p.y, p.z, p.x) : p));
        }
        const double inner = 2 * std::atan(1 / (std::cos(angle) * std::tan(pi / corners)));
        const double area = 900 * (corners * inner - (corners - 2) * pi);
        const Measured measured = measure({Kind::patch, at, 5, 0}, bone, uncut);
        ASSERT_EQ(measured.problem, "");
        EXPECT_NEAR(measured.area / area, 1, 0.015) << corners;
      }
    // A belt around the equator has no inside: the surface is too curved.
    EXPECT_NE(measure({Kind::patch, {{30, 0, 5}, {0, 30, 5}, {-30, 0, -5}, {0, -30, 5}}, 5, 0}, bone, uncut)
                  .problem,
              "");
    const Measured whole = measure({Kind::part, {{3, 2, 1}}, 40, 0}, bone, uncut);
    ASSERT_EQ(whole.problem, "");
    EXPECT_NEAR(whole.size / (4.0 / 3 * pi * 27000), 1, 0.01);
    EXPECT_NEAR(whole.area / (4 * pi * 900), 1, 0.02);
    EXPECT_NE(measure({Kind::part, {{3, 2, 1}}, 25, 0}, bone, uncut).problem, "");
    EXPECT_NE(measure({Kind::part, {{300, 2, 1}}, 25, 0}, bone, uncut).problem, "");
  }
}

TEST(Measurement, ShowsTheNewestUntilCleared) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(32);
  haptics::TouchScene scene = scenes::phantom_scene("sphere", o);
  const auto method = haptics::make_method("subvoxel").value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  const Measurement module;
  const sim::Catalogue catalogue({&module});
  sim::Lockstep run(sim::Engine(scene, *method, {}, 1e-3, catalogue), {}, 1000);
  for (int i = 0; i < 40; ++i)
    ASSERT_FALSE(
        run.apply_and_finish({Measure{Kind::ruler, {dvec3(0), dvec3(1 + i, 0, 0)}}, 0}).refused.has_value());
  const auto* kept = run.engine().state().result_of<MeasurementState>();
  EXPECT_EQ(kept->length, 40);
  EXPECT_EQ(kept->kinds.size(), MeasurementState::k_shown);
  EXPECT_EQ(kept->lines.size(), 2 * MeasurementState::k_shown);
  const sim::Overlays seen = run.engine().overlays();
  ASSERT_EQ(seen.size(), 1u);
  ASSERT_EQ(seen[0].labels.size(), MeasurementState::k_shown);
  EXPECT_EQ(seen[0].labels.back().text, "40.0 mm");
  EXPECT_EQ(seen[0].labels.front().text, "9.0 mm");
  ASSERT_FALSE(run.apply_and_finish({ClearMeasures{}, 0}).refused.has_value());
  EXPECT_TRUE(run.engine().overlays().empty());
}

}  // namespace
}  // namespace trephine::measurement
