// Marks of a plan lie on the surface of the bone.
#include "apps/workbench/plan_overlays.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"

namespace trephine::workbench {
namespace {

using glm::dvec3;

constexpr double k_radius = 45;  // mm, of the built-in ball

/// A wide hole on an oblique trajectory, and an outline whose corners are far apart.
TEST(PlanOverlays, RingsAndOutlinesLieOnTheBone) {
  const haptics::TouchScene scene = scenes::phantom_scene("sphere", {});
  volume::SurgicalPlan plan;
  const dvec3 entry(0, 0, k_radius);
  plan.trajectories.push_back({"hole", entry, entry - dvec3(15, 0, 20), 14});
  for (const double order : {1.0, -1.0}) {
    volume::PlannedOutline& outline = plan.outlines.emplace_back();
    outline.name = "flap";
    for (int i = 0; i < 6; ++i) {
      const double angle = order * i * M_PI / 3;
      outline.points_world.push_back(k_radius *
                                     glm::normalize(dvec3(0.5 * std::cos(angle), 1, 0.5 * std::sin(angle))));
    }
  }
  const sim::Overlays overlays = plan_overlays(plan, scene);
  ASSERT_EQ(overlays.size(), 1u);
  int on_bone = 0, ring = 0, inside = 0;
  for (const auto& [from, to] : overlays[0].lines) {
    const double lift = glm::length(from) - k_radius;
    if (lift > 0.3 && lift < 1.0) {
      ++on_bone;
      ring += from.z > 30;
    } else {
      ++inside;  // the ring at the target, and the line of the trajectory
    }
  }
  EXPECT_EQ(ring, 24);
  EXPECT_GT(on_bone, 24 + 2 * 60);
  EXPECT_EQ(inside, 24 + 1);
}

/// Without bone nearby, the marks stay at their planned positions.
TEST(PlanOverlays, MarksInAirStay) {
  const haptics::TouchScene scene = scenes::phantom_scene("sphere", {});
  volume::SurgicalPlan plan;
  plan.outlines.push_back({"air", {{80, 0, 0}, {80, 5, 0}, {80, 0, 5}}});
  const sim::Overlays overlays = plan_overlays(plan, scene);
  for (const auto& [from, to] : overlays[0].lines) EXPECT_NEAR(from.x, 80, 1);
}

}  // namespace
}  // namespace trephine::workbench
