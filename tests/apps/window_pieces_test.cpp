// Detached bodies in the window: detached, shown, grasped, released, restored. Tools at an opening of the
// skull. Stages of the window.
#include "tests/apps/window_fixture.h"
#include "tests/sim/saw_bench.h"

using glm::dvec3;

namespace trephine::view {
namespace {

/// Returns an engine in which the hand of the window has sawn a disk out of a plate.
sim::Engine sawn(const std::shared_ptr<const haptics::TouchScene>& plate) {
  auto method = std::make_shared<haptics::SubvoxelProxy>();
  EXPECT_FALSE(method->prepare(*plate));
  sim::HandStart hand{haptics::ServoHand(plate, method, haptics::TouchState(nullptr)),
                      drilling::burr({2 * sim::k_saw, 60, 40, true})};
  sim::Lockstep run(sim::Engine({std::move(hand)}, 1e-3, catalogue()), {}, 1000);
  const haptics::PosePath path = sim::sawing();
  for (int i = 0; i < static_cast<int>(1000 * sim::k_sawn); ++i) run.step(path.at(1e-3 * i));
  run.engine().freeze();
  return run.engine();
}

TEST_F(Window, PiecesAreDetachedShownGraspedReleasedAndRestored) {
  const auto plate = std::make_shared<const haptics::TouchScene>(sim::small_bone());
  options_.start = WindowStart{sawn(plate)};
  options_.recorder = nullptr;
  options_.session_file.clear();
  // The hand comes down on the disk, rests, and moves up and away.
  auto path = haptics::PosePath::from_samples({{0, {{0, 0, 9}, {1, 0, 0, 0}, 0}},
                                               {1, {{0, 0, 1.4}, {1, 0, 0, 0}, 0}},
                                               {6, {{0, 0, 1.4}, {1, 0, 0, 0}, 0}},
                                               {7, {{4, 0, 12}, {1, 0, 0, 0}, 0}},
                                               {60, {{4, 0, 12}, {1, 0, 0, 0}, 0}}},
                                              "");
  options_.device = std::make_shared<haptics::PlaybackDevice>(path.value());
  MainWindow window(nullptr, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  const auto held = [&] {
    return operation.state().overlays && !operation.state().overlays->empty() &&
           operation.state().overlays->front().holder == 0;
  };
  const auto height = [&] { return operation.state().overlays->front().placement.position_world.z; };
  EXPECT_EQ(operation.viewport().overlay_count(), 0u);
  child<QAction>(window, "free_pieces")->trigger();
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.viewport().overlay_count() == 1; }, k_patience));
  ASSERT_EQ(operation.state().bodies.size(), 1u);
  save_screenshot(window, "piece-lies");
  // Without contact the tool touches no piece that it can grasp, and the window reports this.
  if (!operation.state().newest.has_contact) {
    QTest::keyClick(&window, Qt::Key_T);
    EXPECT_TRUE(child<QLabel>(window, "notice")->text().contains("Touch a piece"));
    EXPECT_NE(operation.notice_text().find("Touch a piece"), std::string::npos) << "at the tool, too";
  }
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.t > 1.2; }, k_patience));
  EXPECT_TRUE(operation.state().newest.has_contact);
  QTest::keyClick(&window, Qt::Key_T);
  ASSERT_TRUE(QTest::qWaitFor(held, k_patience));
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.t > 7.3; }, k_patience));
  save_screenshot(window, "piece-lifted");
  // Shift+T puts the held piece back. The first undo moves the piece back into the air, where it is released.
  QTest::keyClick(&window, Qt::Key_T, Qt::ShiftModifier);
  ASSERT_TRUE(QTest::qWaitFor([&] { return !held() && height() < 1; }, k_patience)) << height();
  save_screenshot(window, "piece-put-back");
  QTest::keyClick(&window, Qt::Key_T, Qt::ShiftModifier);
  EXPECT_NE(operation.notice_text().find("to put it back"), std::string::npos)
      << "no piece is held or touched";
  operation.undo();
  ASSERT_TRUE(QTest::qWaitFor([&] { return height() > 8; }, k_patience)) << height();
  EXPECT_FALSE(held());
  EXPECT_EQ(operation.viewport().overlay_count(), 1u);
  // The second undo moves the piece to the position at which it was detached. The third undo attaches it.
  operation.undo();
  EXPECT_TRUE(QTest::qWaitFor([&] { return height() < 1; }, k_patience)) << height();
  operation.undo();
  EXPECT_TRUE(QTest::qWaitFor([&] { return operation.viewport().overlay_count() == 0; }, k_patience));
  window.close();
}

/// An opened skull: a plate from -4 to 0 mm with a hole of 10 mm diameter, and below it the far side of the
/// skull, whose surface is at `far` mm. If `has_dura`, a sheet of dura lies between them, from -8 to -7 mm.
struct Opened {
  std::shared_ptr<haptics::TouchScene> scene;
  std::shared_ptr<const sim::Forbidden> dura;
  std::optional<sim::Engine> engine;
  explicit Opened(bool has_dura, double far = -18) {
    constexpr int k_side = 64;
    constexpr double k_mm = 0.5;
    const auto axes = glm::dmat3(k_mm);
    const dvec3 corner(-0.5 * k_mm * k_side, -0.5 * k_mm * k_side, -26);
    volume::Volume result =
        volume::make_volume(glm::ivec3(k_side), volume::Frame::from_axes(corner, axes).value(), true).value();
    volume::Volume* scan = &result;
    scan->is_hounsfield = true;
    scan->label_names = {"nothing", "dura"};
    for (int z = 0; z < k_side; ++z)
      for (int y = 0; y < k_side; ++y)
        for (int x = 0; x < k_side; ++x) {
          const double height = scan->frame.world_from_volume({x, y, z}).z;
          const bool is_bone = (height > -4 && height < 0) || height < far;
          scan->voxels[scan->index(x, y, z)] = is_bone ? 1200 : -1000;
          scan->labels[scan->index(x, y, z)] = has_dura && height > -8 && height < -7;
        }
    scene = std::make_shared<haptics::TouchScene>(scenes::scene_of(std::move(result)));
    auto method = std::make_shared<haptics::SubvoxelProxy>();
    EXPECT_FALSE(method->prepare(*scene));
    std::vector<std::shared_ptr<const sim::Forbidden>> forbidden;
    if (has_dura) {
      volume::Shape shape;
      shape.label = 1;
      shape.name = "dura";
      dura = sim::Forbidden::build(scene->base, shape).value();
      forbidden = {dura};
    }
    sim::HandStart hand{haptics::ServoHand(scene, method, haptics::TouchState(nullptr)),
                        drilling::burr({10, 60, 1e3, true})};
    sim::Lockstep run(sim::Engine({std::move(hand)}, 1e-3, catalogue(), forbidden), {}, 1000);
    for (int i = 0; i < 600; ++i)
      run.step({{0, 0, 6 - 0.013 * i}, {1, 0, 0, 0}, true});  // its lowest point stays above the dura
    run.step({{0, 0, 40}, {1, 0, 0, 0}, false});
    run.apply(drilling::Burr{3, 60, 40});
    run.step({{0, 0, 40}, {1, 0, 0, 0}, false});
    run.engine().freeze();
    engine = run.engine();
  }
  /// Sets the start of a window on this scene, in a view from above, without a recording.
  void start(WindowOptions& options) const {
    options.start = WindowStart{*engine};
    options.recorder = nullptr;
    options.session_file.clear();
    options.side = 'S';
  }
};

/// A tool that is pressed over an opening works at the structure in the opening, not at the bone behind this
/// structure.
TEST_F(Window, APressedToolStaysAtTheStructureInAnOpening) {
  const Opened opened(true, -14);
  opened.start(options_);
  MainWindow window(nullptr, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.viewport().triangle_count() > 100; }, k_patience));
  const auto wait = [&] {
    const std::uint64_t tick = operation.state().newest.tick;
    ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.tick > tick + 400; }, k_patience));
  };
  const QPoint middle = window.canvas()->rect().center();
  QTest::mouseMove(window.canvas(), middle + QPoint(1, 0));
  QTest::mouseMove(window.canvas(), middle);
  wait();
  operation.set_depth(2);
  QTest::mousePress(window.canvas(), Qt::LeftButton, {}, middle);
  wait();
  const double z = operation.state().newest.pose.position_world.z;
  EXPECT_LT(z, -4);
  EXPECT_GT(z, -9.5) << "pressed 2 mm into the dura at -7 mm; the bone behind is at -14 mm";
  QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, middle);
  window.close();
}

/// A pressed tool that slides behind bone is reported once. A pressed tool that is visible is not reported.
TEST_F(Window, AToolThatWorksBehindBoneIsReported) {
  const Opened opened(false, -9);
  opened.start(options_);
  MainWindow window(nullptr, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.viewport().triangle_count() > 100; }, k_patience));
  const auto point_at = [&](const dvec3& p, double seconds) {
    const glm::dvec2 share = operation.viewport().project(p);
    operation.set_cursor(share.x, share.y);  // before the next frame
    // A frame moves the hand: on a busy machine, several positions would become one jump.
    (void)QTest::qWaitFor(
        [&] { return std::abs(operation.state().newest.pose.position_world.x - p.x) < 0.6; }, 2000);
    const double t = operation.state().newest.t;
    ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.t > t + seconds; }, k_patience));
  };
  const auto count = [&] {
    int result = 0;
    for (const Notices::Entry& notice : operation.notices().log())
      result += notice.text.find("behind bone") != std::string::npos;
    return result;
  };
  operation.take_instrument(drilling::Burr{3, 0.5, 40});  // slow, so that any wait cuts little
  point_at({3, 0, -9}, 0.3);
  operation.set_depth(2);
  operation.press(true);
  point_at({3, 0, -9}, 2);
  EXPECT_EQ(count(), 0) << "in sight";
  operation.set_depth(8);  // deep enough to go from the upper side of the plate to below it
  for (double x = 5.6; x < 8; x += 0.4) point_at({x, 0, 0}, 0.2);
  point_at({8, 0, 0}, 2.5);
  save_screenshot(window, "tool-behind-bone");
  // It stops there. The cursor moved after the first message, so that a second one is possible.
  EXPECT_GT(operation.state().newest.proxy_world.z, -4) << "it went on below the plate";
  EXPECT_GE(count(), 1) << operation.state().newest.proxy_world.x;
  operation.press(false);
  window.close();
}

/// Over an opening an idle tool rests on the structure in the opening or, without a structure, on the plane
/// of the bone's inner side. It does not go to the far side of the skull, and enters no forbidden structure.
TEST_F(Window, AReleasedToolRestsOverAnOpening) {
  for (const bool has_dura : {true, false}) {
    SCOPED_TRACE(has_dura ? "over dura" : "over nothing");
    const Opened opened(has_dura);
    opened.start(options_);
    MainWindow window(nullptr, options_);
    window.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
    OperationController& operation = *window.operation();
    ASSERT_TRUE(QTest::qWaitFor([&] { return operation.viewport().triangle_count() > 100; }, k_patience));
    double lowest = 1e9;
    const auto hover = [&](double x, double y) {
      const QRect canvas = window.canvas()->rect();
      QTest::mouseMove(window.canvas(),
                       {static_cast<int>(x * canvas.width()), static_cast<int>(y * canvas.height())});
      const std::uint64_t tick = operation.state().newest.tick;
      ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.tick > tick + 150; }, k_patience));
      lowest = std::min(lowest, operation.state().newest.pose.position_world.z);
      for (const sim::ForbiddenWatch& watch : operation.state().watches)
        EXPECT_EQ(watch.entries, 0) << x << " " << watch.nearest << " " << lowest;
    };
    for (int i = 0; i <= 12; ++i) hover(0.44 + 0.01 * i, 0.5);
    hover(0.9, 0.5);
    hover(0.5, 0.5);
    save_screenshot(window, has_dura ? "rests-on-dura" : "rests-over-opening");
    // At the lower end of the hole: above the dura, or on the plane of the inner side. The burr's radius is
    // 1.5 mm.
    const double z = operation.state().newest.pose.position_world.z;
    if (has_dura) {
      EXPECT_LT(z, -3);
      EXPECT_GT(z, -7);
    } else {
      EXPECT_NEAR(z, -4, 1);
    }
    EXPECT_GT(lowest, has_dura ? -7 : -5);
    EXPECT_EQ(operation.fault_text(), "");
    window.close();
  }
}

TEST(WindowStage, OneSceneAtATimeAndNothingUnderADialog) {
  using Stage = WindowStage::Stage;
  WindowStage stage;
  EXPECT_FALSE(stage.cancel() || stage.may_replace() || stage.opened());
  EXPECT_TRUE(stage.open());
  EXPECT_FALSE(stage.open());
  EXPECT_TRUE(stage.may_replace());
  {
    const WindowStage::Dialog outer(stage), inner(stage);
    EXPECT_FALSE(stage.may_replace());
  }
  EXPECT_TRUE(stage.opened());
  EXPECT_EQ(stage.stage(), Stage::working);
  // A cancelled scene is not adopted when it arrives. Only then can another scene be opened.
  EXPECT_TRUE(stage.open() && stage.cancel() && stage.may_replace());
  EXPECT_FALSE(stage.open() || stage.opened());
  EXPECT_TRUE(stage.open() && stage.opened());
  // The window closes once, and accepts nothing afterwards.
  EXPECT_TRUE(stage.open() && stage.close());
  EXPECT_FALSE(stage.close() || stage.open() || stage.cancel() || stage.opened() || stage.may_replace());
  EXPECT_EQ(stage.stage(), Stage::closing);
}

}  // namespace
}  // namespace trephine::view
