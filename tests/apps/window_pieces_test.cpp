// What came off, in the window: freed, seen, taken in the hand, put down, taken back. And what the window
// does when.
#include "tests/apps/window_fixture.h"
#include "tests/sim/saw_bench.h"

namespace trephine::view {
namespace {

/// A disk was sawn out of a plate by the window's own hand.
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

TEST_F(Window, PiecesAreFreedSeenTakenPutDownAndTakenBack) {
  const auto plate = std::make_shared<const haptics::TouchScene>(sim::small_bone());
  options_.start = WindowStart{sawn(plate)};
  options_.recorder = nullptr;
  options_.session_file.clear();
  // The hand comes down on the disk, rests, and goes up and away.
  auto path = haptics::PosePath::from_samples({{0, {{0, 0, 9}, {1, 0, 0, 0}, 0}},
                                               {1, {{0, 0, 1.4}, {1, 0, 0, 0}, 0}},
                                               {6, {{0, 0, 1.4}, {1, 0, 0, 0}, 0}},
                                               {7, {{4, 0, 12}, {1, 0, 0, 0}, 0}},
                                               {60, {{4, 0, 12}, {1, 0, 0, 0}, 0}}},
                                              "");
  options_.device = std::make_shared<haptics::PlaybackDevice>(path.value());
  MainWindow window(nullptr, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window));
  OperationController& operation = *window.operation();
  const auto held = [&] {
    return operation.state().overlays && !operation.state().overlays->empty() &&
           operation.state().overlays->front().holder == 0;
  };
  const auto height = [&] { return operation.state().overlays->front().place.position_world.z; };
  EXPECT_EQ(operation.viewport().overlay_count(), 0u);
  child<QAction>(window, "free_pieces")->trigger();
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.viewport().overlay_count() == 1; }, 8000));
  ASSERT_EQ(operation.state().bodies.size(), 1u);
  keep(window, "piece-lies");
  // In the air there is nothing to take, which is said.
  if (!operation.state().newest.has_contact) {
    QTest::keyClick(&window, Qt::Key_T);
    EXPECT_TRUE(child<QLabel>(window, "notice")->text().contains("Touch a piece"));
  }
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.t > 1.2; }, 8000));
  EXPECT_TRUE(operation.state().newest.has_contact);
  QTest::keyClick(&window, Qt::Key_T);
  ASSERT_TRUE(QTest::qWaitFor(held, 3000));
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.t > 7.3; }, 12000));
  keep(window, "piece-lifted");
  QTest::keyClick(&window, Qt::Key_T);
  ASSERT_TRUE(QTest::qWaitFor([&] { return !held(); }, 3000));
  EXPECT_GT(height(), 8);
  EXPECT_EQ(operation.viewport().overlay_count(), 1u);
  // Back where it was, and then never off.
  operation.undo();
  EXPECT_TRUE(QTest::qWaitFor([&] { return height() < 1; }, 3000)) << height();
  operation.undo();
  EXPECT_TRUE(QTest::qWaitFor([&] { return operation.viewport().overlay_count() == 0; }, 3000));
  window.close();
}

TEST(WindowStage, OneThingAtATimeAndNothingUnderADialog) {
  using Stage = WindowStage::Stage;
  WindowStage stage;
  EXPECT_FALSE(stage.give_up() || stage.may_replace() || stage.opened());
  EXPECT_TRUE(stage.open());
  EXPECT_FALSE(stage.open());
  EXPECT_TRUE(stage.may_replace());
  {
    const WindowStage::Dialog outer(stage), inner(stage);
    EXPECT_FALSE(stage.may_replace());
  }
  EXPECT_TRUE(stage.opened());
  EXPECT_EQ(stage.stage(), Stage::working);
  // What was given up is not taken, though it may still come; then another can be opened.
  EXPECT_TRUE(stage.open() && stage.give_up() && stage.may_replace());
  EXPECT_FALSE(stage.open() || stage.opened());
  EXPECT_TRUE(stage.open() && stage.opened());
  // The end comes once, and nothing after it.
  EXPECT_TRUE(stage.open() && stage.close());
  EXPECT_FALSE(stage.close() || stage.open() || stage.give_up() || stage.opened() || stage.may_replace());
  EXPECT_EQ(stage.stage(), Stage::closing);
}

}  // namespace
}  // namespace trephine::view
