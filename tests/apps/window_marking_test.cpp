// Positions marked by clicks: a ruler in the picture, and the positions of any command's form.
#include "modules/catalogue.h"
#include "modules/measurement/measurement.h"
#include "sim/engine/engine.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

class MarkingWindow : public Window {
 protected:
  MarkingWindow() {
    const auto fine = std::make_shared<haptics::TouchScene>(*scene_);
    EXPECT_FALSE(haptics::set_smallest_burr(*fine, 4));
    auto method = std::make_shared<haptics::SubvoxelProxy>();
    EXPECT_FALSE(method->prepare(*fine));
    sim::HandStart hand{haptics::ServoHand(fine, method, haptics::TouchState(nullptr)), drilling::burr({})};
    scene_ = fine;
    options_.start = WindowStart{sim::Engine({std::move(hand)}, 1e-3, modules::catalogue())};
    options_.catalogue = &modules::catalogue();
    options_.recorder = nullptr;
    window_ = std::make_unique<MainWindow>(scene_, options_);
    window_->show();
    EXPECT_TRUE(QTest::qWaitForWindowExposed(window_.get(), k_patience));
    EXPECT_TRUE(QTest::qWaitFor([&] { return window_->operation()->viewport().triangle_count() > 1000; },
                                k_patience));
  }
  /// Moves to a position of the picture, relative to its middle, and waits until the tool touches there.
  void touch(const QPoint& off) {
    const QPoint at = window_->canvas()->rect().center() + off;
    QTest::mouseMove(window_->canvas(), at + QPoint(1, 0));
    QTest::mouseMove(window_->canvas(), at);
    let_run(300);
    EXPECT_TRUE(
        QTest::qWaitFor([&] { return window_->operation()->surface_point().has_value(); }, k_patience));
  }
  void click(const QPoint& off) {
    touch(off);
    QTest::mouseClick(window_->canvas(), Qt::LeftButton, {}, window_->canvas()->rect().center() + off);
  }
  QString prompt() {
    let_run(100);
    auto* label = window_->findChild<QLabel*>("marking_prompt");
    return label != nullptr && label->isVisible() ? label->text() : QString();
  }
  /// Number of shown measurements.
  std::size_t measurement_count() {
    std::size_t count = 0;
    if (const auto& overlays = window_->operation()->state().overlays)
      for (const sim::Overlay& overlay : *overlays)
        for (const auto& label : overlay.labels) count += label.text.find("mm") != std::string::npos;
    return count;
  }
  std::unique_ptr<MainWindow> window_;
};

TEST_F(MarkingWindow, TwoClicksOfARulerMeasureAndDrillNothing) {
  QTest::keyClick(window_.get(), Qt::Key_M);
  EXPECT_EQ(prompt(), "Ruler: click position 1 of 2. Esc cancels.");
  click({-20, 0});
  EXPECT_TRUE(prompt().startsWith("Ruler: click position 2 of 2."));
  touch({20, 10});
  save_screenshot(*window_, "ruler");
  click({20, 10});
  EXPECT_TRUE(QTest::qWaitFor([&] { return measurement_count() == 1; }, k_patience));
  EXPECT_EQ(prompt(), "");
  EXPECT_EQ(window_->operation()->state().removed_mm3, 0);
  EXPECT_EQ(window_->operation()->state().strokes, 0u);
  // The ruler also measures in slices.
  child<QAction>(*window_, "layout_slices")->trigger();
  QTest::keyClick(window_.get(), Qt::Key_M);
  ImagePane* pane = window_->panes()->pane(0);
  ASSERT_TRUE(QTest::qWaitFor([&] { return pane->isVisible() && pane->width() > 100; }, k_patience));
  let_run(500);
  QTest::mouseClick(pane, Qt::LeftButton, {}, pane->rect().center());
  EXPECT_TRUE(prompt().startsWith("Ruler: click position 2 of 2."));
  const auto* label = window_->findChild<QLabel*>("marking_prompt");
  EXPECT_TRUE(window_->canvas()->rect().contains(label->geometry())) << "the prompt fits a small picture";
  save_screenshot(*window_, "ruler-in-slices");
  QTest::mouseClick(pane, Qt::LeftButton, {}, pane->rect().center() + QPoint(0, 30));
  EXPECT_TRUE(QTest::qWaitFor([&] { return measurement_count() == 2; }, k_patience));
  child<QAction>(*window_, "layout_picture")->trigger();
  let_run(500);
  // Esc cancels; then a click drills again.
  QTest::keyClick(window_.get(), Qt::Key_M);
  click({0, 0});
  QTest::keyClick(window_.get(), Qt::Key_Escape);
  EXPECT_EQ(prompt(), "");
  touch({0, 0});
  QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, window_->canvas()->rect().center());
  EXPECT_TRUE(QTest::qWaitFor([&] { return window_->operation()->state().removed_mm3 > 0; }, k_patience));
  QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, window_->canvas()->rect().center());
}

TEST_F(MarkingWindow, APositionOfACommandIsMarkedInsteadOfTyped) {
  QString form_text;
  in_next_dialog([](QDialog& dialog) {
    auto* mark = dialog.findChild<QAction*>("mark_entry");
    ASSERT_NE(mark, nullptr);
    mark->trigger();
  });
  child<QAction>(*window_, "command_place-screw")->trigger();
  const QString words = prompt();
  EXPECT_TRUE(words.startsWith("Place screw, entry: click a position.")) << words.toStdString();
  in_next_dialog([&](QDialog& dialog) {
    form_text = dialog.findChild<QLineEdit*>("entry")->text();
    EXPECT_TRUE(dialog.findChild<QLineEdit*>("entry")->isVisible()) << "the section More settings is open";
    dialog.reject();
  });
  click({5, 5});
  EXPECT_TRUE(QTest::qWaitFor([&] { return !form_text.isEmpty(); }, k_patience));
  const glm::dvec3 at = *window_->operation()->picked_point();
  const QStringList numbers = form_text.split(',');
  ASSERT_EQ(numbers.size(), 3) << form_text.toStdString();
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(numbers[a].toDouble(), at[a], 1.5);
}

}  // namespace
}  // namespace trephine::view
