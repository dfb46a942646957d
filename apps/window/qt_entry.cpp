// Entry point of the window's library, which run_window() finds by name.
#include <QApplication>
#include <QScreen>
#include <optional>

#include "apps/window/qt_application.h"
#include "apps/window/qt_window.h"

extern "C" trephine::Result<trephine::view::WindowReport> trephine_run_qt_window(
    std::shared_ptr<const trephine::haptics::TouchScene> scene, const trephine::view::WindowOptions& options);

trephine::Result<trephine::view::WindowReport> trephine_run_qt_window(
    std::shared_ptr<const trephine::haptics::TouchScene> scene,
    const trephine::view::WindowOptions& options) {
  using namespace trephine::view;
  OpeningPage opening = take_opening_page();
  const auto application =
      opening.application ? std::move(opening.application) : begin_application(false, options.language);
  WindowOptions window_options = options;
  if (window_options.layout_file.empty()) window_options.layout_file = default_layout_file();
  MainWindow window(std::move(scene), window_options);
  window.show();
  std::optional<MainWindow> companion;
  if (options.companion) {
    // Show the two windows side by side.
    companion.emplace(options.companion->scene, options.companion->options);
    companion->follow(window);
    const QRect screen = QApplication::primaryScreen()->availableGeometry();
    window.setGeometry(screen.left(), screen.top() + 30, screen.width() / 2, screen.height() - 30);
    companion->setGeometry(screen.center().x(), screen.top() + 30, screen.width() / 2, screen.height() - 30);
    companion->show();
  }
  opening.page.reset();
  QApplication::exec();
  WindowReport report = window.finish();
  if (window.screenshot_error()) return *window.screenshot_error();
  return report;
}
