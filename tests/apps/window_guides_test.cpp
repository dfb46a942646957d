// Tools that mouse and keyboard move: a foot under an edge and in a burr hole, a tilted shaft, presses
// through bone, and structures that a tool must not enter.
#include <glm/gtc/quaternion.hpp>

#include "modules/drilling/craniotome.h"
#include "modules/drilling/perforator.h"
#include "modules/rongeur/rongeur.h"
#include "tests/apps/operation_window_fixture.h"

namespace trephine::view {
namespace {

using glm::dvec3;

TEST_F(ToolWindow, AKerrisonsFootIsMovedUnderAnEdgeByClicksAndByKeys) {
  open("spine",
       rongeur::rongeur({.kind = rongeur::Kind::kerrison, .width = 3, .opening = 14, .max_bite = 130}));
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  let_run(200);
  // On the lamina of L4, next to its spinous process.
  const dvec3 lamina(7, 43, -11);
  point_at(lamina);
  ASSERT_TRUE(reaches([&] { return hand().guide().edge().size() > 5; }));
  save_screenshot(*window_, "kerrison-edge");
  QTest::mouseClick(window_->canvas(), Qt::LeftButton, {}, pixel_of(lamina));
  ASSERT_TRUE(reaches([&] { return hand().guide().is_holding(); }));
  // The nearest edge is that of the spinous process: the foot goes to its other side.
  ASSERT_TRUE(reaches([&] { return hand().state().newest.pose.position_world.y > 55; }));
  save_screenshot(*window_, "kerrison-under");
  EXPECT_EQ(hand().state().removed_mm3, 0);
  // PageDown slides the foot farther under the bone, and Space acts like the left button.
  QTest::keyClick(window_.get(), Qt::Key_PageDown);
  let_run(400);
  QTest::keyPress(window_.get(), Qt::Key_Space);
  ASSERT_TRUE(reaches([&] { return hand().state().removed_mm3 > 5; }));
  QTest::keyRelease(window_.get(), Qt::Key_Space);
  EXPECT_LT(hand().state().removed_mm3, 130);
  const double first = hand().state().removed_mm3;
  let_run(1000);
  ASSERT_TRUE(reaches([&] { return hand().guide().is_holding(); }));  // at the new edge
  QTest::keyPress(window_.get(), Qt::Key_Space);
  ASSERT_TRUE(reaches([&] { return hand().state().removed_mm3 > first + 3; }));
  QTest::keyRelease(window_.get(), Qt::Key_Space);
  save_screenshot(*window_, "kerrison-bitten");
  point_at({20, 43, 20});
  EXPECT_TRUE(reaches([&] { return !hand().guide().is_holding(); }));
}

/// A click is refused at positions at which the foot finds no edge: the tool stays in place while the button
/// is held. A press at such a position would move the tool into the dural sac.
TEST_F(ToolWindow, AKerrisonIsNotPressedWhereItsClickWasRefused) {
  workbench::SourceChoice source("spine");
  source.uses_plan = true;
  open(source, rongeur::rongeur({.kind = rongeur::Kind::kerrison, .width = 3, .opening = 4}));
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  let_run(200);
  for (const dvec3 thick : {dvec3(7, 43, -13), dvec3(7, 43, 13), dvec3(5, 43, 14), dvec3(4, 45, -12)}) {
    SCOPED_TRACE(thick.x);
    point_at(thick);
    QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(thick));
    const std::uint64_t tick = hand().state().newest.tick;
    ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 1500; }));
    EXPECT_FALSE(hand().guide().is_holding());
    EXPECT_EQ(hand().state().removed_mm3, 0);
    EXPECT_EQ(entries(), 0);
    QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(thick));
  }
}

/// Between two laminae an idle tool rests on the dural sac. It does not pass through the sac to the vertebral
/// body.
TEST_F(ToolWindow, AnIdleToolDoesNotEnterTheDuralSacBetweenLaminae) {
  workbench::SourceChoice source("spine");
  source.uses_plan = true;  // the dural sac and the nerve roots are forbidden
  const std::pair<const char*, sim::Instrument> tools[] = {
      {"kerrison", rongeur::rongeur({.kind = rongeur::Kind::kerrison, .width = 4, .opening = 12})},
      {"rongeur", rongeur::rongeur({})},
      {"burr", drilling::burr({.diameter = 4})}};
  for (const auto& [tool_name, tool] : tools) {
    SCOPED_TRACE(tool_name);
    open(source, tool);
    QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
    let_run(200);
    const sim::Engine start = operation_->engine();
    int crossings = 0;  // number of rays that cross a forbidden structure before they meet bone
    for (const double z : {14.5, 17.5})
      for (const double x :
           {-5.0, 3.0, 6.0, 0.0, -6.0}) {  // steps of 3 to 8 mm, over the convex dural sac too
        const dvec3 gap(x, 43, z);
        point_at(gap);
        const std::uint64_t tick = hand().state().newest.tick;
        ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 200; }));
        const glm::dvec2 pixel = hand().viewport().project(gap);
        const Ray ray = hand().viewport().ray_at(pixel.x, pixel.y);
        const double bone = hand().viewport().distance_to_solid(*hand().version(), ray);
        bool is_crossed = false;
        for (double along = 0; along < bone; along += 1)
          for (const auto& structure : start.forbidden())
            is_crossed = is_crossed || structure->clearance({ray.origin + along * ray.direction, 0}) < 0;
        crossings += is_crossed;
        EXPECT_EQ(entries(), 0) << x << " " << z;
      }
    EXPECT_GE(crossings, 2);
    save_screenshot(*window_, (std::string(tool_name) + "-over-dural-sac").c_str());
    // A lamina next to the gap is still touched.
    point_at({0, 43, 30});
    EXPECT_TRUE(reaches([&] { return hand().state().newest.has_contact; }));
    EXPECT_EQ(entries(), 0) << "on a lamina";
    window_.reset();
  }
}

TEST_F(ToolWindow, AnIdleToolEntersNoStructureOfAClippedHead) {
  workbench::SourceChoice source("head");
  source.uses_plan = true;  // the dura and others are forbidden
  open(source, drilling::burr({.diameter = 4}));
  QTest::keyClick(window_.get(), Qt::Key_A, Qt::ShiftModifier);
  hand().viewport().set_clip({.axis = ClipChoice::Axis::view, .share = 0.5});
  for (const dvec3 inside : {dvec3(0, 0, 20), dvec3(-30, 0, 30), dvec3(40, 0, 0), dvec3(0, 0, 55)}) {
    point_at(inside);
    const std::uint64_t tick = hand().state().newest.tick;
    ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 200; }));
    EXPECT_EQ(entries(), 0) << inside.x << " " << inside.z;
    const auto picked_point = hand().picked_point();
    ASSERT_TRUE(picked_point) << "the cut face can be marked";
    EXPECT_NEAR(picked_point->y, hand().viewport().clip_plane()->at.y, 1e-6);
  }
}

TEST_F(ToolWindow, AnIdleToolStaysOutsideTheDuralSacWhenHiddenBoneIsClipped) {
  workbench::SourceChoice source("spine");
  source.uses_plan = true;  // the dural sac is forbidden
  open(source, drilling::burr({.diameter = 4}));
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  let_run(200);
  const auto rest = [&] {
    const std::uint64_t tick = hand().state().newest.tick;
    ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 150; }));
  };
  hand().viewport().set_opacity(0, 0);
  for (const dvec3 at : {dvec3(-3, 12, 15), dvec3(0, 12, 7.5), dvec3(6, 12, -22.5)}) {
    point_at(at);
    rest();
    EXPECT_EQ(entries(), 0) << "before " << at.x << " " << at.z;
    for (const double share : {0.5, 0.7}) {
      hand().viewport().set_clip({.axis = ClipChoice::Axis::view, .share = share});
      rest();
      EXPECT_EQ(entries(), 0) << at.x << " " << at.z << ", " << share;
    }
    hand().viewport().set_clip({});
    rest();
    EXPECT_EQ(entries(), 0) << "after " << at.x << " " << at.z;
  }
}

TEST_F(ToolWindow, APerforatorTouchesAndDrillsOnSlopes) {
  open("head", drilling::burr({.diameter = 6}));
  hand().take_instrument(drilling::perforator({}).parameters);
  ASSERT_TRUE(reaches([&] { return holds("perforator"); }));
  QTest::keyClick(window_.get(), Qt::Key_A, Qt::ShiftModifier);
  let_run(300);
  for (const dvec3 slope : {dvec3(-28, -83, -24), dvec3(61, -44, -24), dvec3(28, -76, 33)}) {
    point_at(slope);
    ASSERT_TRUE(reaches([&] { return hand().state().newest.has_contact; })) << slope.x;
    EXPECT_LT(glm::length(hand().state().newest.force_world), 0.6) << "only rests on the bone";
    const double before = hand().state().removed_mm3;
    QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(slope));
    EXPECT_TRUE(reaches([&] { return hand().state().removed_mm3 > before + 20; })) << slope.x;
    QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(slope));
    let_run(100);
  }
}

TEST_F(ToolWindow, ABurrThatIsPressedDeepGoesThroughTheSkull) {
  open("head", drilling::burr({.diameter = 4, .is_kinematic = true}));
  QTest::keyClick(window_.get(), Qt::Key_R, Qt::ShiftModifier);
  let_run(300);
  for (const dvec3 place : {dvec3(-66, 10, 24), dvec3(-55, 5, 48), dvec3(-62, 40, 25)}) {
    SCOPED_TRACE(place.y);
    hand().set_depth(1);
    point_at(place);
    const auto start = hand().picked_point();
    ASSERT_TRUE(start);
    QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(place));
    double deepest = 0;
    for (double depth = 1; depth <= 3; depth += 0.25) {
      hand().set_depth(depth);
      const std::uint64_t tick = hand().state().newest.tick;
      ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 150; }));
      const double now = glm::distance(hand().state().newest.proxy_world, *start);
      EXPECT_GT(now, deepest - 0.1) << "the tool rose out of its hole at a press of " << depth << " mm";
      deepest = std::max(deepest, now);
    }
    QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(place));
    EXPECT_GT(deepest, 7) << "through the bone";
    let_run(100);
  }
}

TEST_F(ToolWindow, ABurrRemovesBoneWhereTheLineOfSightGrazesIt) {
  open("spine", drilling::burr({.diameter = 4}));
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  let_run(300);
  const auto ray_at = [&](const dvec3& p) {
    const glm::dvec2 pixel = hand().viewport().project(p);
    return hand().viewport().ray_at(pixel.x, pixel.y);
  };
  const auto version = hand().version();
  const auto hits = [&](const dvec3& p) {
    return hand().viewport().distance_to_solid(*version, ray_at(p)) >= 0;
  };
  const auto depth_at = [&](const dvec3& p) {
    return hand().viewport().distance_to_solid(*version, ray_at(p));
  };
  int count = 0;
  for (const double z : {-12.0, -8.0, -4.0, 24.0, 28.0, 32.0})
    for (const double side : {-1.0, 1.0}) {
      // The outermost position at a side of the spinous process. Beyond it, the line of sight meets no bone,
      // or meets bone 10 mm deeper.
      const double top = depth_at({0, 60, z});
      if (top < 0) continue;
      double x = 0;
      while (x < 12 && hits({side * (x + 0.1), 60, z}) && depth_at({side * (x + 0.1), 60, z}) < top + 10)
        x += 0.1;
      const dvec3 edge(side * (x - 0.3), 60, z);
      SCOPED_TRACE(std::to_string(edge.x) + " " + std::to_string(z));
      point_at(edge);
      const double before = hand().state().removed_mm3;
      QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(edge));
      const bool is_cut = reaches([&] { return hand().state().removed_mm3 > before + 0.2; });
      QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(edge));
      EXPECT_TRUE(is_cut) << hand().state().removed_mm3 - before;
      ++count;
      let_run(100);
    }
  EXPECT_GT(count, 5);
}

/// A press on a cut face is refused: the tool cannot pass the hidden bone in front of the face, and the
/// matter behind the face is not visible. Otherwise a press can tear a nerve root far behind the face.
TEST_F(ToolWindow, APressOnACutFaceIsRefused) {
  open_with_plan("spine", drilling::burr({.diameter = 4}));
  QTest::keyClick(window_.get(), Qt::Key_L, Qt::ShiftModifier);
  QTest::keyClick(window_.get(), Qt::Key_C);
  ASSERT_TRUE(reaches([&] { return viewport().clip_plane() && viewport().is_complete(); }));
  int presses = 0;
  for (const dvec3& at :
       {dvec3(0, -10, 0), dvec3(0, -14, 30), dvec3(0, 12, 0), dvec3(0, 45, 0), dvec3(0, 8, -30)}) {
    SCOPED_TRACE(testing::Message() << at.y << ' ' << at.z);
    point_at(at);
    const glm::dvec2 pixel = hand().viewport().project(at);
    if (!viewport().distance_to_clip_face(*hand().version(), hand().viewport().ray_at(pixel.x, pixel.y)))
      continue;
    ++presses;
    const std::size_t notices = hand().notices().count();
    QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(at));
    EXPECT_TRUE(reaches([&] { return hand().notices().count() > notices; }));
    EXPECT_NE(hand().notices().log().back().text.find("cut face"), std::string::npos);
    const std::uint64_t tick = hand().state().newest.tick;
    ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 500; }));
    QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(at));
    EXPECT_EQ(entries(), 0);
    EXPECT_EQ(hand().state().removed_mm3, 0);
    let_run(100);
  }
  EXPECT_GE(presses, 3);
  save_screenshot(*window_, "press-on-face");
}

/// An idle burr that moves over a hole does not enter the dura, neither at the bottom of the hole nor at its
/// rim.
TEST_F(ToolWindow, AnIdleBurrOverAHoleDoesNotEnterTheDura) {
  workbench::SourceChoice source("head");
  source.uses_plan = true;  // the dura is forbidden
  open(source, drilling::burr({.diameter = 6, .is_kinematic = true}));
  QTest::keyClick(window_.get(), Qt::Key_R, Qt::ShiftModifier);
  let_run(300);
  const dvec3 hole(-70, 12, 25);
  point_at(hole);
  hand().set_depth(1.5);
  QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(hole));
  ASSERT_TRUE(reaches([&] { return entries() > 0; }));
  QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(hole));
  hand().take_instrument(drilling::burr({.diameter = 6}).parameters);
  ASSERT_TRUE(reaches([&] {
    const auto* burr = hand().tool().as<drilling::Burr>();
    return burr && !burr->is_kinematic && !hand().is_changing_instrument();
  }));
  point_at(hole + dvec3(0, 0, 20));
  const std::int64_t before = entries();
  for (double z = -6; z <= 6; z += 1)
    for (double y = -6; y <= 6; y += 1) {
      QTest::mouseMove(window_->canvas(), pixel_of(hole + dvec3(0, y, z)));
      const std::uint64_t tick = hand().state().newest.tick;
      ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 60; }));
      EXPECT_EQ(entries(), before) << y << " " << z;
    }
  save_screenshot(*window_, "burr-over-hole");
}

/// A deep press at an edge of the lamina does not pull the tool past the edge, where it would tear the dural
/// sac.
TEST_F(ToolWindow, APressAtAnEdgeOfBoneDoesNotSlipToItsOtherSide) {
  workbench::SourceChoice source("spine");
  source.uses_plan = true;
  open(source, drilling::burr({.diameter = 4, .removal_rate = 0.1}));  // it hardly cuts
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  let_run(200);
  hand().set_depth(12);
  int places = 0;
  for (const double x : {-9.75, 9.75, 7.0})
    for (const double z : {9.2, 6.0}) {
      if (x == 9.75 && z == 9.2) continue;  // the gap of the facet joint
      const dvec3 at(x, 40, z);
      SCOPED_TRACE(testing::Message() << x << ' ' << z);
      point_at(at);
      if (!hand().surface_point()) continue;
      ++places;
      EXPECT_LT((pixel_of(*hand().surface_point()) - pixel_of(at)).manhattanLength(), 6)
          << "not under the cursor";
      const dvec3 surface = *hand().surface_point();
      QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(at));
      const std::uint64_t tick = hand().state().newest.tick;
      ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 600; }));
      EXPECT_EQ(entries(), 0);
      const dvec3 off = hand().state().newest.proxy_world - surface;  // the view is along y
      EXPECT_LT(std::hypot(off.x, off.z), 1) << "the tool slid away from the cursor";
      QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(at));
      ASSERT_TRUE(reaches([&] { return !hand().state().newest.pose.is_pressed(); }));
    }
  EXPECT_GE(places, 4);
}

/// A deep press does not move a craniotome whose foot has no room. The tool would pass through structures.
TEST_F(ToolWindow, ACraniotomeIsNotPressedWhereItsFootHasNoPlace) {
  open_with_plan("spine", drilling::craniotome({}));
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  let_run(200);
  hand().set_depth(12);
  for (const dvec3 gap : {dvec3(0, 43, 14.5), dvec3(3, 43, 17.5)}) {
    point_at(gap);
    EXPECT_EQ(entries(), 0) << "at rest";
    QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(gap));
    for (int i = 0; i < 6; ++i) {
      QTest::mouseMove(window_->canvas(), pixel_of(gap + dvec3(i, 0, 0)));
      const std::uint64_t tick = hand().state().newest.tick;
      ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 100; }));
    }
    EXPECT_FALSE(hand().guide().is_holding());
    QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(gap));
    EXPECT_EQ(entries(), 0) << gap.x;
  }
}

/// The craniotome enters the hole that a perforator leaves, without widening, and cuts along the bone.
TEST_F(ToolWindow, ACraniotomeEntersAHoleOfThePerforator) {
  open_with_plan("head", drilling::craniotome({}));
  const int sides = std::getenv("TREPHINE_WHOLE") == nullptr ? 1 : 4;
  const std::tuple<Qt::Key, QPoint> places[] = {
      {Qt::Key_L, {0, -150}}, {Qt::Key_R, {40, -170}}, {Qt::Key_S, {60, 40}}, {Qt::Key_A, {30, -200}}};
  for (int side = 0; side < sides; ++side) {
    SCOPED_TRACE(side);
    hand().take_instrument(drilling::perforator({}).parameters);
    ASSERT_TRUE(reaches([&] { return holds("perforator"); }));
    QTest::keyClick(window_.get(), std::get<0>(places[side]), Qt::ShiftModifier);
    let_run(300);
    const QPoint at = window_->canvas()->rect().center() + std::get<1>(places[side]);
    QTest::mouseMove(window_->canvas(), at + QPoint(2, 0));
    QTest::mouseMove(window_->canvas(), at);
    ASSERT_TRUE(reaches([&] { return hand().surface_point().has_value(); }));
    const dvec3 hole = *hand().surface_point();
    child<QSlider>(*window_, "depth")->setValue(8);
    const auto stops = [&] {
      const auto& log = hand().notices().log();
      return std::count_if(log.begin(), log.end(),
                           [](const auto& entry) { return entry.text.starts_with("The clutch released"); });
    };
    const auto before = stops();
    QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, at);
    EXPECT_TRUE(reaches([&] { return stops() > before; }));
    QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, at);
    QTest::mouseMove(window_->canvas(), at + QPoint(150, 0));
    let_run(300);
    save_screenshot(*window_, ("perforator-hole-" + std::to_string(side)).c_str());

    hand().take_instrument(drilling::craniotome({}).parameters);
    ASSERT_TRUE(reaches([&] { return holds("craniotome"); }));
    point_at(hole);
    ASSERT_TRUE(reaches([&] { return hand().guide().is_holding(); }));
    let_run(500);
    const double removed = hand().state().removed_mm3;
    QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(hole));
    const QPoint start = pixel_of(hole);
    for (int i = 1; i <= 40; ++i) {
      QTest::mouseMove(window_->canvas(), start + QPoint(3 * i, 0));
      let_run(60);
    }
    // A fault on a busy machine may have ended the press.
    EXPECT_TRUE(reaches([&] {
      if (!hand().is_pressed())
        QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, start + QPoint(120, 0));
      return hand().state().removed_mm3 > removed + 60;
    }));
    QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, start + QPoint(120, 0));
    save_screenshot(*window_, ("craniotome-kerf-" + std::to_string(side)).c_str());
    EXPECT_EQ(entries("brain"), 0) << "the foot pushes the dura";
    // No piece is free after this cut, which a message states when the craniotome is put away.
    hand().remove_instrument();
    const auto& log = hand().notices().log();
    EXPECT_TRUE(reaches([&] { return log.back().text.starts_with("No piece is free yet"); }));
  }
}

TEST_F(ToolWindow, ACraniotomeMovesFromABurrHoleAlongTheBone) {
  if (std::getenv("TREPHINE_WHOLE") == nullptr) GTEST_SKIP() << "takes 50 s: set TREPHINE_WHOLE=1 to run it";
  open("head", drilling::craniotome({}));
  hand().take_instrument(drilling::burr({.diameter = 6, .removal_rate = 400}).parameters);
  ASSERT_TRUE(reaches([&] { return holds("burr"); }));
  QTest::keyClick(window_.get(), Qt::Key_L, Qt::ShiftModifier);
  let_run(200);
  const QPoint middle = window_->canvas()->rect().center() + QPoint(0, -150);
  QTest::mouseMove(window_->canvas(), middle + QPoint(2, 0));
  QTest::mouseMove(window_->canvas(), middle);
  ASSERT_TRUE(reaches([&] { return hand().surface_point().has_value(); }));
  const dvec3 hole = *hand().surface_point();
  const auto near_hole = [&](double back, double up) { return hole + dvec3(0, back, up); };
  // Drill around a ring, deeper and deeper, until the foot has room on the inner side of the bone. The button
  // is pressed again after every 20 moves, because a fault on a busy machine may have released it.
  child<QSlider>(*window_, "depth")->setValue(16);
  for (int i = 0; i < 160; ++i) {
    const QPoint at = pixel_of(near_hole(3 * std::cos(0.4 * i), 3 * std::sin(0.4 * i)));
    QTest::mouseMove(window_->canvas(), at);
    if (i % 20 == 0) QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, at);
    let_run(80);
    if (i % 20 == 19) QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, at), let_run(80);
  }
  save_screenshot(*window_, "craniotome-hole");

  hand().take_instrument(drilling::craniotome({}).parameters);
  ASSERT_TRUE(reaches([&] { return holds("craniotome"); }));
  point_at(hole);
  ASSERT_TRUE(reaches([&] { return hand().guide().is_holding(); }));
  let_run(800);
  save_screenshot(*window_, "craniotome-standing");
  const double before = hand().state().removed_mm3;
  QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(hole));
  for (int i = 1; i <= 60; ++i) {
    QTest::mouseMove(window_->canvas(), pixel_of(near_hole(0.5 * i, 0)));
    let_run(60);
  }
  EXPECT_TRUE(reaches([&] { return hand().state().removed_mm3 > before + 100; }));
  QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(near_hole(30, 0)));
  save_screenshot(*window_, "craniotome-kerf");
}

TEST_F(ToolWindow, TheShaftIsTiltedByTheMiddleButtonAndByKeys) {
  open("spine", rongeur::rongeur({}));
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  const dvec3 place(8, 43, -6);
  point_at(place);
  ASSERT_TRUE(reaches([&] { return hand().surface_point().has_value(); }));
  let_run(500);
  const dvec3 before = shaft();
  const dvec3 tip = hand().state().newest.pose.position_world;
  for (int i = 0; i < 10; ++i) QTest::keyClick(window_.get(), Qt::Key_D);
  EXPECT_NEAR(hand().tilt_angle(), 20, 1e-6);
  const auto leans = [&](double degrees) {
    return std::abs(std::acos(std::min(1.0, glm::dot(before, shaft()))) * 180 / 3.14159265 - degrees) < 1;
  };
  EXPECT_TRUE(reaches([&] { return leans(20); }));
  // The shaft leans toward the right edge of the picture. In the view from the back this is the patient's
  // right.
  EXPECT_LT(glm::dot(shaft() - before, dvec3(1, 0, 0)), -0.2);
  // The tip stays in place.
  EXPECT_LT(glm::length(hand().state().newest.pose.position_world - tip), 1.5);
  save_screenshot(*window_, "tilted");
  // A drag with the middle button turns the shaft back about its tip.
  const QPoint at = pixel_of(place);
  QTest::mousePress(window_->canvas(), Qt::MiddleButton, {}, at);
  for (int i = 1; i <= 10; ++i) QTest::mouseMove(window_->canvas(), at - QPoint(6 * i, 0));
  QTest::mouseRelease(window_->canvas(), Qt::MiddleButton, {}, at - QPoint(60, 0));
  EXPECT_LT(hand().tilt_angle(), 6);
  // A fixed shaft does not follow the surface.
  QTest::keyClick(window_.get(), Qt::Key_K);
  QTest::keyClick(window_.get(), Qt::Key_K);
  let_run(500);
  const dvec3 fixed = shaft();
  point_at({14, 43, 4});
  let_run(500);
  EXPECT_GT(glm::dot(fixed, shaft()), 0.9999);
  // Each press of an arrow key moves the tip over the bone by 1 mm.
  const dvec3 here = hand().state().newest.pose.position_world;
  for (int i = 0; i < 4; ++i) QTest::keyClick(window_.get(), Qt::Key_Up);
  EXPECT_TRUE(
      reaches([&] { return std::abs(hand().state().newest.pose.position_world.z - here.z - 4) < 1; }));
}

}  // namespace
}  // namespace trephine::view
