// Clicks through the window as a user would: open, touch, drill, undo, save, quit. Needs an X display.
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

/// Space or the mouse button may be released over another window, without an event here.
TEST_F(Window, DrillsNothingInTheBackground) {
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->viewport().triangle_count() > 1000; }, k_patience));
  const QPoint middle = window.canvas()->rect().center();
  for (const bool is_key : {true, false}) {
    QTest::mouseMove(window.canvas(), middle + QPoint(1, 0));  // a move to the same position causes no event
    QTest::mouseMove(window.canvas(), middle);
    ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().newest.has_contact; }, k_patience));
    const double before = window.operation()->state().removed_mm3;
    if (is_key)
      QTest::keyPress(&window, Qt::Key_Space);
    else
      QTest::mousePress(window.canvas(), Qt::LeftButton, {}, middle);
    ASSERT_TRUE(
        QTest::qWaitFor([&] { return window.operation()->state().removed_mm3 > before + 1; }, k_patience));
    QEvent other(QEvent::WindowDeactivate);
    QApplication::sendEvent(&window, &other);
    ASSERT_TRUE(
        QTest::qWaitFor([&] { return !window.operation()->state().newest.pose.is_pressed(); }, k_patience));
    const double left = window.operation()->state().removed_mm3;
    let_run(300);
    EXPECT_EQ(window.operation()->state().removed_mm3, left);
    QTest::keyRelease(&window, Qt::Key_Space);
    QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, middle);
  }
  window.close();
}

// An undo directly after the release of the button restores all bone: no later tick of the stroke cuts again.
TEST_F(Window, UndoRightAfterTheReleaseRestoresAllBone) {
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.viewport().is_complete(); }, k_patience));
  const QPoint middle = window.canvas()->rect().center();
  QTest::mouseMove(window.canvas(), middle);
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.has_contact; }, k_patience));
  operation.press(true);
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().removed_mm3 > 3; }, k_patience));
  operation.press(false);
  operation.undo();  // before the next frame
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().removed_mm3 == 0; }, k_patience));
  let_run(300);
  EXPECT_EQ(operation.state().removed_mm3, 0);
  EXPECT_EQ(operation.state().strokes, 0u);
  EXPECT_EQ(operation.state().all_strokes, 1u);
  operation.redo();
  EXPECT_TRUE(QTest::qWaitFor([&] { return operation.state().removed_mm3 > 3; }, k_patience));
}

TEST_F(Window, TouchDrillUndoSaveAndQuit) {
  WindowReport report;
  {
    MainWindow window(scene_, options_);
    window.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
    ASSERT_TRUE(QTest::qWaitFor(
        [&] {
          return window.operation()->viewport().is_complete() &&
                 window.operation()->viewport().triangle_count() > 1000;
        },
        k_patience));
    const QPoint middle = window.canvas()->rect().center();

    // Touch: the stylus follows the surface under the cursor.
    QTest::mouseMove(window.canvas(), middle);
    EXPECT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().newest.has_contact; }, k_patience));
    EXPECT_EQ(window.operation()->state().removed_mm3, 0);
    EXPECT_FALSE(child<QPushButton>(window, "undo")->isEnabled());

    // Drill: hold the button.
    QTest::mousePress(window.canvas(), Qt::LeftButton, {}, middle);
    EXPECT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().removed_mm3 > 3; }, k_patience));
    save_screenshot(window, "drilling");
    QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, middle);
    EXPECT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().strokes == 1; }, k_patience));
    EXPECT_TRUE(child<QLabel>(window, "removed")->text().contains("1 change"));

    // Undo by button, redo by key, undo by menu.
    const double removed = window.operation()->state().removed_mm3;
    QTest::mouseClick(child<QPushButton>(window, "undo"), Qt::LeftButton);
    EXPECT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().removed_mm3 == 0; }, k_patience));
    QTest::keyClick(&window, Qt::Key_Y);
    EXPECT_TRUE(
        QTest::qWaitFor([&] { return window.operation()->state().removed_mm3 == removed; }, k_patience));
    // Space presses like the mouse button, for users of a trackpad.
    child<QDoubleSpinBox>(window, "diameter")->setValue(6);
    QTest::keyPress(&window, Qt::Key_Space);
    EXPECT_TRUE(
        QTest::qWaitFor([&] { return window.operation()->state().removed_mm3 > removed + 2; }, k_patience));
    QTest::keyRelease(&window, Qt::Key_Space);
    EXPECT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().strokes == 2; }, k_patience));

    // Views, depth, clip plane, help, larger text: every control responds.
    const int depth = child<QSlider>(window, "depth")->value();
    QTest::keyClick(&window, Qt::Key_PageDown);
    EXPECT_EQ(child<QSlider>(window, "depth")->value(), depth + 1);
    for (const char* view : {"view_A", "view_P", "view_L", "view_R", "view_S", "view_I"})
      QTest::mouseClick(child<QPushButton>(window, view), Qt::LeftButton);
    QTest::keyClick(&window, Qt::Key_0);
    QTest::keyClick(&window, Qt::Key_C);
    EXPECT_EQ(window.operation()->viewport().clip().axis, ClipChoice::Axis::view);
    let_run(400);
    save_screenshot(window, "open");
    QTest::keyClick(&window, Qt::Key_C);
    child<QAction>(window, "help")->trigger();
    EXPECT_TRUE(child<HelpOverlay>(window, "help_overlay")->isVisible());
    let_run(100);
    save_screenshot(window, "help");
    QTest::mouseClick(child<HelpOverlay>(window, "help_overlay"), Qt::LeftButton);
    EXPECT_FALSE(child<HelpOverlay>(window, "help_overlay")->isVisible());
    const double points = QApplication::font().pointSizeF();
    window.scale_text(1.5);
    EXPECT_GT(QApplication::font().pointSizeF(), points);
    let_run(50);
    save_screenshot(window, "large-text");
    window.scale_text(1 / 1.5);

    // Saving, by menu and dialog.
    const std::string volume = (folder_ / "left.mha").string();
    answer_dialog_with(volume);
    child<QAction>(window, "save_volume")->trigger();
    const auto saved = data_tools::open_volume(volume);
    ASSERT_TRUE(saved.is_ok());
    EXPECT_EQ(saved.value().volume.size, scene_->base->size);
    EXPECT_FALSE(window.save_mesh(QString::fromStdString((folder_ / "left.stl").string())).has_value());
    EXPECT_GT(fs::file_size(folder_ / "left.stl"), 10000u);
    EXPECT_FALSE(window.save_picture(QString::fromStdString((folder_ / "left.png").string())).has_value());
    EXPECT_GT(fs::file_size(folder_ / "left.png"), 5000u);
    EXPECT_FALSE(
        window.save_session(QString::fromStdString((folder_ / "copy.session").string())).has_value());
    EXPECT_TRUE(window.save_volume("left.doc").has_value());
    EXPECT_TRUE(window.save_picture("/no/such/folder/a.png").has_value());

    QString message;
    in_next_dialog<QMessageBox>([&message](QMessageBox& box) {
      message = box.text();
      box.accept();
    });
    child<QAction>(window, "quit")->trigger();
    EXPECT_TRUE(message.contains(QString::fromStdString(session_)))
        << "the message names the file of the session";
    EXPECT_FALSE(window.isVisible());
    report = window.finish();
  }
  EXPECT_EQ(report.window, "qt");
  EXPECT_EQ(report.strokes, 2u);
  EXPECT_GT(report.frames, 5);
  EXPECT_GT(report.drilling_frames, 0);
  EXPECT_FALSE(report.recording_error.has_value());
  EXPECT_EQ(report.servo.faults & haptics::k_latched_faults, 0u);
  // A replay of the session reproduces all work, to the bit. The copy that was saved in between can also be
  // replayed.
  for (const std::string& file : {session_, (folder_ / "copy.session").string()}) {
    auto opened = sim::SessionReader::open(file, catalogue());
    ASSERT_TRUE(opened.is_ok()) << file;
    haptics::SubvoxelProxy method;
    ASSERT_FALSE(method.prepare(*scene_).has_value());
    const auto replay_of = sim::Replay::open(opened.value(), scene_->base).value();
    sim::Replay& replay = *replay_of;
    while (replay.step().value()) {}
    EXPECT_FALSE(replay.mismatch().has_value()) << replay.mismatch()->what;
    EXPECT_GT(replay.engine().removed_mm3(), 3);
  }
}

/// Makes three strokes, selects earlier states with the slider, and compares two states side by side.
TEST_F(Window, MovesThroughStrokesAndComparesThem) {
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->viewport().triangle_count() > 1000; }, k_patience));
  const QPoint middle = window.canvas()->rect().center();
  auto* slider = child<QSlider>(window, "history");
  EXPECT_FALSE(slider->isEnabled());
  std::vector<double> removed{0};
  for (int stroke = 1; stroke <= 3; ++stroke) {
    const QPoint at = middle + QPoint(0, 8 * (stroke - 2));
    QTest::mouseMove(window.canvas(), at + QPoint(1, 0));
    QTest::mouseMove(window.canvas(), at);
    let_run(200);
    QTest::mousePress(window.canvas(), Qt::LeftButton, {}, at);
    ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().removed_mm3 > removed.back() + 2; },
                                k_patience));
    QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, at);
    ASSERT_TRUE(QTest::qWaitFor(
        [&] { return window.operation()->state().strokes == static_cast<std::size_t>(stroke); }, k_patience));
    removed.push_back(window.operation()->state().removed_mm3);
  }
  const auto is_at = [&](std::size_t stroke) {
    return QTest::qWaitFor(
        [&] {
          return window.operation()->state().strokes == stroke &&
                 window.operation()->state().removed_mm3 == removed[stroke] &&
                 slider->value() == static_cast<int>(stroke);
        },
        k_patience);
  };
  ASSERT_TRUE(is_at(3));
  EXPECT_EQ(slider->maximum(), 3);
  EXPECT_TRUE(QTest::qWaitFor(
      [&] { return child<QLabel>(window, "history_text")->text().contains("change 3 of 3"); }, k_patience));
  EXPECT_TRUE(QTest::qWaitFor([&] { return child<QLabel>(window, "history_text")->text().contains("MB"); },
                              k_patience));
  // The slider is dragged faster than the edit thread follows.
  const auto drag_to = [&](int to) {
    slider->setSliderPosition(to);
    emit slider->actionTriggered(QAbstractSlider::SliderMove);
  };
  drag_to(2), drag_to(1), drag_to(0), drag_to(1);
  EXPECT_TRUE(is_at(1));
  save_screenshot(window, "history");
  drag_to(3);
  EXPECT_TRUE(is_at(3));
  drag_to(2);
  EXPECT_TRUE(is_at(2));

  child<QAction>(window, "compare_action")->trigger();
  auto* dialog = window.findChild<QDialog*>("comparison");
  ASSERT_NE(dialog, nullptr);
  const auto* picture = dialog->findChild<QLabel*>("compared");
  auto* with = dialog->findChild<QComboBox*>("compare_with");
  EXPECT_EQ(with->currentText(), "change 1");
  EXPECT_EQ(with->count(), 3);  // the uncut bone, strokes 1 and 3
  ASSERT_TRUE(QTest::qWaitFor([&] { return picture->pixmap(Qt::ReturnByValue).width() > 300; }, k_patience));
  const QImage first = picture->pixmap(Qt::ReturnByValue).toImage();
  let_run(100);
  if (const char* folder = std::getenv("TREPHINE_SCREENSHOTS"))
    dialog->grab().save(QString("%1/compare.png").arg(folder));
  with->setCurrentIndex(0);
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return picture->pixmap(Qt::ReturnByValue).toImage() != first; }, k_patience));
  dialog->close();
  // The window itself continues.
  const int frames = window.finish().frames;
  EXPECT_GT(frames, 5);
  window.close();
}

// The window shows the reason of a refusal. Here undo needs a state that is in a session file, and this file
// is no longer readable.
TEST_F(Window, ShowsWhyACommandWasRefused) {
  haptics::TouchScene scene = *scene_;
  const haptics::SubvoxelProxy method = [&scene] {
    haptics::SubvoxelProxy result;
    EXPECT_FALSE(result.prepare(scene));
    return result;
  }();
  sim::Engine engine(scene, method, drilling::burr({.removal_rate = 30}), 1e-3, catalogue());
  const glm::dvec3 on_it(0, 0, 45);
  for (std::uint64_t tick = 0; tick < 60; ++tick) {
    haptics::ServoRecord record;
    record.tick = tick;
    record.proxy_world = record.pose.position_world =
        on_it + glm::dvec3(0.1 * static_cast<double>(tick), 0, -1);
    record.has_contact = true;
    record.pose.buttons = tick < 50 ? 1u : 0u;
    engine.apply(record);
  }
  sim::EngineSnapshot snapshot = engine.full_snapshot();
  ASSERT_EQ(snapshot.branch.history.size(), 2u);
  sim::HistoryEntry gone = *snapshot.branch.history[0];
  gone.load = [] {
    return Result<sim::EntryState>(Error{.what = "the session is no longer readable",
                                         .where = "a.session",
                                         .expected = "a file that is neither moved nor deleted"});
  };
  snapshot.branch.history[0] = std::make_shared<const sim::HistoryEntry>(gone);
  ASSERT_FALSE(engine.restore(snapshot));
  options_.start = WindowStart{std::move(engine), 60};
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  ASSERT_TRUE(QTest::qWaitFor([&] { return child<QPushButton>(window, "undo")->isEnabled(); }, k_patience));
  EXPECT_FALSE(child<QLabel>(window, "notice")->text().contains("was refused"));
  QTest::mouseClick(child<QPushButton>(window, "undo"), Qt::LeftButton);
  EXPECT_TRUE(QTest::qWaitFor(
      [&] {
        return child<QLabel>(window, "notice")
            ->text()
            .startsWith("The command was refused: the session is no longer readable");
      },
      k_patience))
      << child<QLabel>(window, "notice")->text().toStdString();
  save_screenshot(window, "refused");
  EXPECT_EQ(window.operation()->state().strokes, 1u);
  window.close();
}

TEST_F(Window, OpensOtherScenesShowsErrorsAndChangesTheShape) {
  options_.recorder = nullptr;
  volume::SurgicalPlan plan;
  plan.trajectories.push_back({"path", glm::dvec3(0, 0, 40), glm::dvec3(0)});
  options_.plan = std::make_shared<const volume::SurgicalPlan>(plan);
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  EXPECT_EQ(window.operation()->viewport().overlay_count(), 2u) << "lines and name of the plan";
  const auto wait_opened = [&] { return QTest::qWaitFor([&] { return !window.is_opening(); }, k_patience); };
  window.open_source("bad");
  ASSERT_TRUE(wait_opened());
  auto* box = window.findChild<QMessageBox*>("error");
  ASSERT_NE(box, nullptr);
  EXPECT_TRUE(box->text().contains("does not exist"));
  EXPECT_TRUE(box->text().contains("check the spelling"));
  box->close();
  EXPECT_TRUE(window.windowTitle().startsWith("ball"));
  EXPECT_EQ(window.operation()->viewport().overlay_count(), 2u) << "the plan stays with its scan";

  // A folder is dropped.
  QMimeData mime;
  mime.setUrls({QUrl::fromLocalFile("/some/scan")});
  QDragEnterEvent enter(QPoint(50, 50), Qt::CopyAction, &mime, Qt::LeftButton, {});
  QApplication::sendEvent(&window, &enter);
  EXPECT_TRUE(enter.isAccepted());
  QDropEvent drop(QPointF(50, 50), Qt::CopyAction, &mime, Qt::LeftButton, {});
  QApplication::sendEvent(&window, &drop);
  ASSERT_TRUE(wait_opened());
  EXPECT_TRUE(QTest::qWaitFor([&] { return window.windowTitle().startsWith("another ball"); }, k_patience));
  EXPECT_EQ(window.operation()->viewport().overlay_count(), 0u) << "no overlay of the other scene is left";
  // Wait for the complete surface: no triangles are added for 500 ms.
  std::size_t before = 0;
  QElapsedTimer same;
  same.start();
  EXPECT_TRUE(QTest::qWaitFor(
      [&] {
        const std::size_t now = window.operation()->viewport().triangle_count();
        if (now != before) same.restart();
        before = now;
        return now > 500 && same.elapsed() > 500;
      },
      k_patience));

  // Another window of intensities is shown at once, and touched only on request.
  child<QDoubleSpinBox>(window, "low")->setValue(1500);
  EXPECT_TRUE(QTest::qWaitFor(
      [&] {
        const std::size_t now = window.operation()->viewport().triangle_count();
        return now != before && now > 100 && child<QPushButton>(window, "use_shape")->isEnabled();
      },
      k_patience));
  QTest::mouseClick(child<QPushButton>(window, "keep_shape"), Qt::LeftButton);
  EXPECT_EQ(child<QDoubleSpinBox>(window, "low")->value(), 300);
  EXPECT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->viewport().triangle_count() == before; }, k_patience));
  // A change of shape ends the clip plane and keeps the depth of a press.
  QTest::keyClick(&window, Qt::Key_C);
  child<QSlider>(window, "depth")->setValue(9);
  child<QDoubleSpinBox>(window, "low")->setValue(1200);
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return child<QPushButton>(window, "use_shape")->isEnabled(); }, k_patience));
  QTest::mouseClick(child<QPushButton>(window, "use_shape"), Qt::LeftButton);
  EXPECT_TRUE(QTest::qWaitFor([&] { return window.windowTitle().startsWith("reshaped"); }, k_patience));
  EXPECT_EQ(reshaped_low_, 1200);
  EXPECT_EQ(child<QComboBox>(window, "clip")->currentIndex(), 0);
  EXPECT_EQ(window.operation()->depth(), 4.5);
  EXPECT_EQ(reshaped_.preset, "");
  EXPECT_FALSE(reshaped_.is_largest);
  auto* shape_of = child<QComboBox>(window, "shape_of");
  shape_of->setCurrentIndex(2);
  emit shape_of->activated(2);
  EXPECT_EQ(child<QDoubleSpinBox>(window, "low")->value(), 150);
  child<QCheckBox>(window, "largest")->setChecked(true);
  QTest::mouseClick(child<QPushButton>(window, "use_shape"), Qt::LeftButton);
  EXPECT_TRUE(QTest::qWaitFor([&] { return reshaped_.preset == "spine"; }, k_patience));
  EXPECT_TRUE(reshaped_.is_largest);
  EXPECT_TRUE(QTest::qWaitFor([&] { return !window.is_opening(); }, k_patience));
  window.close();
}

TEST_F(Window, FramesCostWhatChangedInThem) {
  options_.recorder = nullptr;
  scene_ = ball(256);
  options_.start = start_on(scene_);
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  Viewport& picture = window.operation()->viewport();
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return picture.is_complete() && picture.triangle_count() > 50000; }, k_patience));
  // At rest no triangles of the bone are drawn again.
  QTest::mouseMove(window.canvas(), QPoint(5, 5));
  EXPECT_TRUE(QTest::qWaitFor([&] { return picture.view().bone().drawn_triangles() == 0; }, k_patience));
  // From each of four sides the picture, which was drawn in parts, equals one that is drawn as a whole.
  const std::string sides("APS\0", 4);
  std::vector<QImage> kept;
  const auto turn_to = [&](char side) {
    picture.look_from(side);
    let_run(100);  // a few frames: the first one detects that the view has changed
    return QTest::qWaitFor(
        [&] { return picture.is_complete() && picture.view().bone().drawn_triangles() == 0; }, k_patience);
  };
  const auto expect_whole = [&](const QImage& seen, char side) {
    picture.view().bone().complete_next_drawing();
    window.canvas()->renderWindow()->Render();
    const QImage whole = window.canvas()->grabFramebuffer();
    ASSERT_EQ(seen.size(), whole.size());
    if (const char* folder = std::getenv("TREPHINE_SCREENSHOTS")) {
      seen.save(QString("%1/seen-%2.png").arg(folder).arg(QChar(side)));
      whole.save(QString("%1/whole-%2.png").arg(folder).arg(QChar(side)));
    }
    int different = 0, bone = 0;
    for (int y = 0; y < whole.height(); ++y)
      for (int x = 0; x < whole.width(); ++x) {
        different += std::abs(qGray(seen.pixel(x, y)) - qGray(whole.pixel(x, y))) > 24;
        bone += qRed(whole.pixel(x, y)) > qBlue(whole.pixel(x, y)) + 15;
      }
    EXPECT_LT(different, whole.width() * whole.height() / 1000) << "side " << side;
    EXPECT_GT(bone, whole.width() * whole.height() / 10) << "side " << side;
  };
  for (const char side : sides) {
    ASSERT_TRUE(turn_to(side));
    kept.push_back(window.canvas()->grabFramebuffer());
  }
  for (std::size_t i = 0; i < sides.size(); ++i) {
    ASSERT_TRUE(turn_to(sides[i]));
    expect_whole(kept[i], sides[i]);
  }
  // During drilling only the surroundings of the burr are drawn.
  const QPoint middle = window.canvas()->rect().center();
  QTest::mouseMove(window.canvas(), middle);
  QTest::mousePress(window.canvas(), Qt::LeftButton, {}, middle);
  std::size_t most = 0;
  ASSERT_TRUE(QTest::qWaitFor(
      [&] {
        most = std::max(most, picture.view().bone().drawn_triangles());
        return window.operation()->state().removed_mm3 > 5;
      },
      k_patience));
  QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, middle);
  EXPECT_GT(most, 0u);
  EXPECT_LT(most, picture.triangle_count() / 3);
  // After drilling, the picture from another side shows all of the bone, although the last frames drew only
  // its part near the cut.
  QTest::mouseMove(window.canvas(), QPoint(5, 5));
  let_run(100);
  ASSERT_TRUE(turn_to('P'));
  expect_whole(window.canvas()->grabFramebuffer(), 'P');
  window.close();
}

TEST(DrillVoice, IsSilentAtRestHumsWhenPressedAndNeverClips) {
  DrillVoice voice;
  std::vector<std::int16_t> samples(DrillVoice::k_rate);
  const auto loudness = [&](double force, bool is_pressed, bool has_contact) {
    voice.fill(samples.data(), static_cast<int>(samples.size()), force, is_pressed, has_contact);
    double sum = 0;
    for (std::size_t i = samples.size() / 2; i < samples.size(); ++i) sum += std::abs(samples[i]);
    return sum / static_cast<double>(samples.size() / 2);
  };
  EXPECT_LT(loudness(0, false, false), 1);
  const double free = loudness(0, true, false), cutting = loudness(4, true, true);
  EXPECT_GT(free, 300);
  EXPECT_GT(cutting, 1.2 * free);
  EXPECT_LT(loudness(0, false, false), 60) << "it fades";
  loudness(1e6, true, true);
  for (const std::int16_t s : samples) ASSERT_LE(std::abs(s), 22000);
}

}  // namespace
}  // namespace trephine::view

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  QSurfaceFormat format = QVTKOpenGLNativeWidget::defaultFormat();
  format.setSamples(0);
  QSurfaceFormat::setDefaultFormat(format);
  QApplication::setAttribute(Qt::AA_DontUseNativeDialogs);
  QApplication app(argc, argv);
  trephine::view::apply_look();
  return RUN_ALL_TESTS();
}
