// Replay of a recorded session in the window.
#include <QInputDialog>
#include <filesystem>
#include <fstream>

#include "data-tools/cases/session_notes.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

class ReplayWindow : public Window {
 protected:
  void SetUp() override {
    Window::SetUp();
    // A session to play: a burr that enters the ball.
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
    options_.recorder = nullptr;
    options_.replay_seconds = 2;
  }
  /// A session that is open for a replay.
  struct Played {
    Result<sim::SessionReader> reader;
    std::unique_ptr<sim::Replay> replay;
    Played(const std::string& session, const std::shared_ptr<const volume::Volume>& scan)
        : reader(sim::SessionReader::open(session, catalogue())),
          replay(sim::Replay::open(reader.value(), scan).value()) {}
  };
};

TEST_F(ReplayWindow, PlaysASessionPausedAtAnySpeedAndToAnyTime) {
  Played played(session_, scene_->base);
  sim::Replay& replay = *played.replay;
  options_.replay = &replay;
  options_.replayed_file = session_;
  options_.may_take_over = true;
  options_.summary.work_position = scene_->base->frame.world_from_volume(glm::dvec3(31.5, 31.5, 60));
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
  // The view is from the side of the work, here from above. An event is shown at the tool from its time on,
  // and hidden when the replay goes back to an earlier time.
  EXPECT_LT(window.replay()->viewport().camera().forward.z, -0.7);
  EXPECT_TRUE(QTest::qWaitFor([&] { return child<QLabel>(window, "notice_at_tool")->text() == "Dura torn."; },
                              k_patience));
  const double late = window.replay()->engine().removed_mm3();
  EXPECT_GT(late, 1);
  EXPECT_GT(glm::length(window.replay()->record().force_world), 0);
  save_screenshot(window, "replay");
  // A click on the slider seeks to the time at this position, or to the time of a mark close to it.
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
  // The table shows the parts of the force at the paused tick, and then at the previous tick.
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
  save_screenshot(window, "replay-force");
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
  // A note is stored in a file next to the session, and shown at its time with a mark. It can be edited, and
  // an empty text removes it.
  const auto write_note = [&](const char* text) {
    QTest::mouseClick(child<QPushButton>(window, "note"), Qt::LeftButton);
    auto* dialog = window.findChild<QInputDialog*>("note_dialog");
    ASSERT_NE(dialog, nullptr);
    dialog->setTextValue(text);
    dialog->accept();
    let_run(60);
  };
  EXPECT_FALSE(window.replay()->seek(1.5).has_value());
  let_run(60);
  write_note("Hold \"still\" \\ here");
  auto notes = data_tools::read_notes(session_);
  ASSERT_TRUE(notes.is_ok());
  ASSERT_EQ(notes.value().size(), 1u);
  EXPECT_EQ(notes.value()[0].seconds, 1.5);
  EXPECT_EQ(notes.value()[0].text, "Hold \"still\" \\ here");
  ASSERT_TRUE(notes.value()[0].at_world);
  EXPECT_LT(glm::length(*notes.value()[0].at_world - window.replay()->record().proxy_world), 1e-6);
  EXPECT_TRUE(QTest::qWaitFor(
      [&] {
        return child<QLabel>(window, "notice_at_tool")->text().contains("Note: Hold \"still\" \\ here");
      },
      k_patience));
  EXPECT_EQ(ReplayPanel::marks_of(notes.value(), 1.6).size(), 1u);
  EXPECT_TRUE(ReplayPanel::marks_of(notes.value(), 1.4).empty());
  save_screenshot(window, "replay-note");
  EXPECT_FALSE(window.replay()->seek(1.7).has_value());  // near the note: it is edited
  let_run(60);
  write_note("Slower");
  notes = data_tools::read_notes(session_);
  ASSERT_EQ(notes.value().size(), 1u);
  EXPECT_EQ(notes.value()[0].text, "Slower");
  write_note("");
  EXPECT_FALSE(std::filesystem::exists(data_tools::notes_path(session_)));
  // The window closes, and reports the time from which the user takes over.
  EXPECT_FALSE(window.replay()->seek(0.7).has_value());
  let_run(60);
  QTest::mouseClick(child<QPushButton>(window, "take_over"), Qt::LeftButton);
  EXPECT_TRUE(window.isHidden());
  const WindowReport report = window.finish();
  ASSERT_TRUE(report.taken_over_at);
  EXPECT_NEAR(*report.taken_over_at, 0.7, 0.002);
}

/// A companion window shows the time and the view of its leader, and closes with the leader.
TEST_F(ReplayWindow, ACompanionFollowsTheTimeAndTheViewOfItsLeader) {
  Played first(session_, scene_->base), second(session_, scene_->base);
  options_.replay = first.replay.get();
  options_.replay_seconds = 1.2;  // shorter than its companion
  MainWindow leader(scene_, options_);
  options_.replay = second.replay.get();
  options_.replay_seconds = 2;
  MainWindow companion(scene_, options_);
  companion.follow(leader);
  leader.show();
  companion.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&companion, k_patience));
  ASSERT_TRUE(QTest::qWaitFor([&] { return leader.replay()->seconds() > 0.2; }, k_patience));
  leader.replay()->play(false);
  for (const double seconds : {1.6, 0.4, 2.0, 0.0}) {
    ASSERT_FALSE(leader.replay()->seek(seconds));
    EXPECT_TRUE(QTest::qWaitFor([&] { return std::abs(companion.replay()->seconds() - seconds) < 0.002; },
                                k_patience));
    EXPECT_EQ(leader.replay()->seconds(), seconds);
    const double own = leader.replay()->engine().removed_mm3(),
                 other = companion.replay()->engine().removed_mm3();
    if (seconds <= 1.2)
      EXPECT_EQ(other, own);
    else
      EXPECT_GT(other, own) << "the leader stays at its end";
  }
  EXPECT_EQ(child<QSlider>(leader, "session_time")->maximum(), 2000);
  leader.replay()->viewport().look_from('S');
  const auto looks_alike = [&] {
    return glm::length(companion.replay()->viewport().camera().forward -
                       leader.replay()->viewport().camera().forward) < 1e-9;
  };
  EXPECT_TRUE(QTest::qWaitFor(looks_alike, k_patience));
  EXPECT_TRUE(child<QWidget>(companion, "replay_panel")->isHidden());
  leader.close();
  EXPECT_TRUE(QTest::qWaitFor([&] { return companion.isHidden(); }, k_patience));
}

/// A file of notes that cannot be read is reported and not replaced.
TEST_F(Window, AReplayKeepsAnInvalidFileOfNotes) {
  const std::string file = data_tools::notes_path(session_);
  {
    std::ofstream out(file);
    out << "schema = 1\n[[note]]\nsecond = 1\ntext = \"a\"\n";
  }
  ReplayPanel panel({}, 2, session_, nullptr);
  std::string shown;
  panel.on_error = [&](const Error& error) { shown = error.message(); };
  let_run(30);
  EXPECT_NE(shown.find("line 3"), std::string::npos) << shown;
  EXPECT_FALSE(panel.findChild<QPushButton*>("note")->isEnabled());
  EXPECT_EQ(std::filesystem::file_size(file), 42u);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace trephine::view
