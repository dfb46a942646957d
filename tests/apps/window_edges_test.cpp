// Presses at edges of bone in the window: a burr stops when it is hidden, and is reported when it only rubs.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "modules/drilling/burr.h"
#include "tests/apps/operation_window_fixture.h"

namespace trephine::view {
namespace {

using glm::dvec3;

/// A press at an edge pulls the burr below the edge. There it stops, with a message, until the cursor moves.
TEST_F(ToolWindow, ABurrThatSlidesBehindBoneStops) {
  open("spine", drilling::burr({.diameter = 4}));
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  let_run(300);
  hand().set_depth(3);
  const auto count = [&] {
    const auto& log = hand().notices().log();
    return std::count_if(log.begin(), log.end(), [](const auto& entry) {
      return entry.text.starts_with("The tool slid behind bone, out of sight");
    });
  };
  // Positions at the lower edges of the lamina and of the articular processes: at some, the burr slips over
  // the edge.
  int slides = 0;
  for (const double z : {-12.0, -14.0, -10.0, -22.0, -24.0})
    for (const double x : {-4.5, 5.5, -7.0, 8.0, 12.0}) {
      if (slides >= 2) continue;
      const dvec3 edge(x, 45, z);
      SCOPED_TRACE(std::to_string(x) + " " + std::to_string(z));
      const auto before = count();
      point_at(edge);
      QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(edge));
      const double start = hand().state().newest.t;
      EXPECT_TRUE(reaches([&] { return count() > before || hand().state().newest.t > start + 2.5; }));
      if (count() > before) {
        ++slides;
        let_run(300);
        const double stopped = hand().state().removed_mm3, time = hand().state().newest.t;
        EXPECT_TRUE(reaches([&] { return hand().state().newest.t > time + 2; }));
        EXPECT_LT(hand().state().removed_mm3, stopped + 0.5) << "it went on out of sight";
      }
      QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(edge));
      let_run(100);
    }
  EXPECT_GE(slides, 1);
}

/// A burr that is pressed too lightly rubs and hardly cuts. The window reports the force, and how to
/// increase it, once until the burr cuts again or is released.
TEST_F(ToolWindow, ABurrThatRubsIsReported) {
  open("head", drilling::burr({.diameter = 6}));
  QTest::keyClick(window_.get(), Qt::Key_R, Qt::ShiftModifier);
  let_run(300);
  const dvec3 at(-66, 10, 24);
  const auto count = [&] {
    const auto& log = hand().notices().log();
    return std::count_if(log.begin(), log.end(), [](const auto& entry) {
      return entry.text.starts_with("The burr rubs and hardly cuts at ");
    });
  };
  for (const auto& [depth, rubs] : {std::pair(12.0, false), std::pair(0.5, true)}) {
    SCOPED_TRACE(depth);
    hand().set_depth(depth);
    point_at(at);
    const double start = hand().state().newest.t;
    QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(at));
    EXPECT_TRUE(reaches([&] { return rubs ? count() == 1 : hand().state().newest.t > start + 2.5; }));
    const double shown = hand().state().newest.t;
    EXPECT_TRUE(reaches([&] { return hand().state().newest.t > shown + (rubs ? 2.5 : 0); }));
    QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(at));
    EXPECT_EQ(count(), rubs ? 1 : 0);
    let_run(100);
  }
}

/// Presses at the edges of the built-in spine remove little bone while the tool is out of sight.
TEST_F(ToolWindow, PressesAtEdgesCutLittleOutOfSight) {
  if (std::getenv("TREPHINE_WHOLE") == nullptr) GTEST_SKIP() << "4 minutes: set TREPHINE_WHOLE=1";
  workbench::SourceChoice source("spine");
  source.uses_plan = true;
  open(source, drilling::burr({.diameter = 4}));
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  let_run(300);
  hand().set_depth(3);
  const auto uncut = hand().version();
  const auto depth_at = [&](const dvec3& p) {
    const glm::dvec2 pixel = hand().viewport().project(p);
    return hand().viewport().distance_to_solid(*uncut, hand().viewport().ray_at(pixel.x, pixel.y));
  };
  int presses = 0;
  double all = 0, hidden = 0;  // mm3
  for (double z = -20; z <= 12; z += 2.5)
    for (double x = -14; x <= 14; x += 1.75) {
      const dvec3 at(x, 45, z);
      const double depth = depth_at(at);
      if (depth < 0) continue;
      constexpr double k_edge = 4;  // mm, least step of the depth next to an edge
      double step = 0;
      for (const dvec3& aside : {dvec3(1.5, 0, 0), dvec3(-1.5, 0, 0), dvec3(0, 0, 1.5), dvec3(0, 0, -1.5)}) {
        const double next = depth_at(at + aside);
        step = std::max(step, next < 0 ? k_edge : next - depth);
      }
      if (step < k_edge) continue;
      point_at(at);
      const double before = hand().state().removed_mm3;
      double last = before;
      QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(at));
      for (const double begin = hand().state().newest.t; hand().state().newest.t < begin + 2.5;) {
        let_run(30);
        const dvec3 tip = hand().state().newest.proxy_world;
        const glm::dvec2 pixel = hand().viewport().project(tip);
        const Ray ray = hand().viewport().ray_at(pixel.x, pixel.y);
        const double bone = hand().viewport().distance_to_solid(*hand().version(), ray);
        const double distance = glm::dot(tip - ray.origin, ray.direction);
        const bool is_hidden = hand().state().newest.has_contact && bone >= 0 &&
                               bone < distance - hand().state().tool_radius - 1;
        if (is_hidden) hidden += hand().state().removed_mm3 - last;
        last = hand().state().removed_mm3;
      }
      QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(at));
      let_run(150);
      ++presses, all += last - before;
      hand().undo();
      let_run(250);
    }
  std::printf("%d presses removed %.1f mm3, of which %.1f mm3 out of sight\n", presses, all, hidden);
  EXPECT_GT(presses, 30);
  EXPECT_LT(hidden, 0.3 * all);  // measured: 0.25; 0.35 for a tool that works on out of sight
}

}  // namespace
}  // namespace trephine::view
