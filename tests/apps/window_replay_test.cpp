// Replay of a recorded session in the window.
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

TEST_F(Window, PlaysASessionPausedAtAnySpeedAndToAnyTime) {
  // A session to play: a burr that enters the ball.
  {
    haptics::SubvoxelProxy method;
    ASSERT_FALSE(method.prepare(*scene_).has_value());
    const drilling::Burr burr;
    sim::Engine edits(*scene_, method, drilling::burr(burr), 1e-3);
    haptics::ServoCore core({}, 1e-3);
    for (int i = 0; i < 2000; ++i) {
      const haptics::ServoRecord record =
          core.step(*edits.servo_scene(), {{{0, 0, 60 - 0.01 * i}, {1, 0, 0, 0}, true}});
      const sim::Outcome outcome = edits.apply(record);
      recorder_->add(record, edits, outcome);
    }
    ASSERT_FALSE(recorder_->finish(edits).has_value());
  }
  auto opened = sim::SessionReader::open(session_, catalogue());
  ASSERT_TRUE(opened.is_ok());
  haptics::SubvoxelProxy method;
  ASSERT_FALSE(method.prepare(*scene_).has_value());
  const auto replay_of = sim::Replay::open(opened.value(), scene_->base).value();
  sim::Replay& replay = *replay_of;
  options_.recorder = nullptr;
  options_.replay = &replay;
  options_.replay_seconds = 2;
  options_.summary.worked_at = scene_->base->frame.world_from_volume(glm::dvec3(31.5, 31.5, 60));
  options_.summary.marks = {{1.0, workbench::EventLevel::danger, "Dura torn."}};
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  EXPECT_TRUE(QTest::qWaitFor([&] { return window.replay()->seconds() > 0.2; }, k_patience));
  QTest::keyClick(&window, Qt::Key_Space);
  EXPECT_FALSE(window.replay()->is_playing());
  const double paused = window.replay()->seconds();
  let_run(100);
  EXPECT_EQ(window.replay()->seconds(), paused);
  EXPECT_FALSE(window.replay()->seek(1.9).has_value());
  let_run(60);
  EXPECT_NEAR(window.replay()->seconds(), 1.9, 0.01);
  // The view is from the side of the work, here from above. Events are shown at the tool, and hidden again
  // before their time.
  EXPECT_LT(window.replay()->viewport().camera().forward.z, -0.7);
  EXPECT_TRUE(QTest::qWaitFor([&] { return child<QLabel>(window, "notice_at_tool")->text() == "Dura torn."; },
                              k_patience));
  const double late = window.replay()->engine().removed_mm3();
  EXPECT_GT(late, 1);
  EXPECT_GT(glm::length(window.replay()->record().force_world), 0);
  keep(window, "replay");
  // A click seeks to its position, or to a mark next to it.
  auto* slider = child<QSlider>(window, "session_time");
  const auto click_at = [&](double share, int pixels) {
    QTest::mouseClick(slider, Qt::LeftButton, {},
                      {static_cast<int>(share * slider->width()) + pixels, slider->height() / 2});
    return window.replay()->seconds();
  };
  EXPECT_NEAR(click_at(0.75, 0), 1.5, 0.05);
  EXPECT_NEAR(click_at(0.25, 0), 0.5, 0.05);
  EXPECT_NEAR(click_at(0.5, 4), 1.0, 0.0015) << "the mark";
  EXPECT_FALSE(window.replay()->seek(0.3).has_value());
  EXPECT_LT(window.replay()->engine().removed_mm3(), late);
  EXPECT_TRUE(
      QTest::qWaitFor([&] { return child<QLabel>(window, "notice_at_tool")->isHidden(); }, k_patience));
  // The parts of the force of a paused tick, and of its neighbour.
  EXPECT_FALSE(window.replay()->seek(1.9).has_value());
  QTest::keyClick(&window, Qt::Key_X);
  auto* table = child<QTableWidget>(window, "force_table");
  const auto shows_force = [&] {
    const std::optional<haptics::ForceParts>& parts = window.replay()->force_parts();
    const int last = table->rowCount() - 1;
    return parts && last > 0 &&
           static_cast<long long>(parts->record.tick) + 1 ==
               std::llround(1000 * window.replay()->seconds()) &&
           table->item(last, 4)->text() ==
               QString::number(glm::length(window.replay()->record().force_world), 'f', 3);
  };
  EXPECT_TRUE(QTest::qWaitFor(shows_force, k_patience));
  EXPECT_TRUE(child<QLabel>(window, "force_text")->text().contains("The tool touches"));
  keep(window, "replay-force");
  const double before_step = window.replay()->seconds();
  QTest::mouseClick(child<QPushButton>(window, "previous_tick"), Qt::LeftButton);
  EXPECT_NEAR(window.replay()->seconds(), before_step - 0.001, 1e-9);
  EXPECT_TRUE(QTest::qWaitFor(shows_force, k_patience));
  QTest::keyClick(&window, Qt::Key_X);
  EXPECT_TRUE(QTest::qWaitFor([&] { return !window.replay()->force_parts(); }, k_patience));
  child<QComboBox>(window, "speed")->setCurrentIndex(5);
  QTest::mouseClick(child<QPushButton>(window, "play"), Qt::LeftButton);
  EXPECT_TRUE(QTest::qWaitFor([&] { return window.replay()->seconds() >= 2; }, k_patience))
      << "at 20 times real time";
  EXPECT_FALSE(replay.mismatch().has_value());
  window.close();
}

}  // namespace
}  // namespace trephine::view
