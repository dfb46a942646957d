// Frames of the window: an unchanged picture is not drawn again. Closing of the window by the program.
#include <QTimer>
#include <utility>

#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

/// A picture that equals the previous one is not drawn again.
TEST_F(Window, DrawsNothingWithoutChanges) {
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  const QPoint middle = window.canvas()->rect().center();
  QTest::mouseMove(window.canvas(), middle);
  ASSERT_TRUE(QTest::qWaitFor(
      [&] {
        return window.operation()->viewport().is_complete() && window.operation()->state().newest.has_contact;
      },
      k_patience));
  const auto drawn = [&] { return window.operation()->frames() - window.operation()->frames_skipped(); };
  // Wait until the tool, and therefore the picture, is at rest.
  int last = -1;
  ASSERT_TRUE(QTest::qWaitFor([&] { return std::exchange(last, drawn()) == drawn(); }, k_patience));
  const int frames = window.operation()->frames(), before = drawn();
  ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->frames() > frames + 20; }, k_patience));
  EXPECT_EQ(drawn(), before);
  // Changes of the tool, the view, the size of the text and the size of the window are drawn.
  QTest::mouseMove(window.canvas(), middle + QPoint(9, 5));
  EXPECT_TRUE(QTest::qWaitFor([&] { return drawn() > before; }, k_patience));
  const auto is_drawn_after = [&](auto change) {
    last = -1;
    EXPECT_TRUE(QTest::qWaitFor([&] { return std::exchange(last, drawn()) == drawn(); }, k_patience));
    const int count = drawn();
    change();
    return QTest::qWaitFor([&] { return drawn() > count; }, k_patience);
  };
  EXPECT_TRUE(
      is_drawn_after([&] { QTest::mouseClick(child<QPushButton>(window, "view_A"), Qt::LeftButton); }));
  EXPECT_TRUE(is_drawn_after([&] { window.scale_text(1.3); }));
  EXPECT_TRUE(is_drawn_after([&] { window.resize(940, 720); }));
}

/// should_close() returns true after the program received a signal, such as SIGINT. The window then closes
/// without a dialog, although bone was cut.
TEST_F(Window, AProgramCanCloseItWithoutWaiting) {
  std::atomic<bool> is_asked = false;
  options_.should_close = [&] { return is_asked.load(); };
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  const QPoint middle = window.canvas()->rect().center();
  QTest::mouseMove(window.canvas(), middle);
  ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().newest.has_contact; }, k_patience));
  QTest::mousePress(window.canvas(), Qt::LeftButton, {}, middle);
  ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().removed_mm3 > 1; }, k_patience));
  QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, middle);
  ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().strokes == 1; }, k_patience));
  bool has_dialog = false;
  QTimer watch;
  QObject::connect(&watch, &QTimer::timeout, [&] {
    auto* dialog = QApplication::activeModalWidget();
    if (dialog == nullptr) return;
    has_dialog = true;
    dialog->close();
  });
  watch.start(50);
  is_asked = true;
  EXPECT_TRUE(QTest::qWaitFor([&] { return !window.isVisible(); }, k_patience));
  EXPECT_FALSE(has_dialog);
}

}  // namespace
}  // namespace trephine::view
