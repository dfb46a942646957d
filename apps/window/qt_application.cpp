#include "apps/window/qt_application.h"

#include <QPalette>
#include <QSettings>
#include <QStyleFactory>
#include <QSurfaceFormat>
#include <QTemporaryDir>
#include <QVTKOpenGLNativeWidget.h>
#include <clocale>
#include <utility>

#include "apps/window/qt_localizer.h"
#include "apps/window/qt_window.h"

namespace trephine::view {

void apply_look() {
  QApplication::setStyle(QStyleFactory::create("Fusion"));
  QPalette p;
  p.setColor(QPalette::Window, QColor(37, 42, 51));
  p.setColor(QPalette::WindowText, QColor(232, 236, 242));
  p.setColor(QPalette::Base, QColor(26, 30, 37));
  p.setColor(QPalette::AlternateBase, QColor(44, 50, 60));
  p.setColor(QPalette::Text, QColor(232, 236, 242));
  p.setColor(QPalette::Button, QColor(55, 63, 76));
  p.setColor(QPalette::ButtonText, QColor(238, 241, 246));
  p.setColor(QPalette::ToolTipBase, QColor(18, 22, 30));
  p.setColor(QPalette::ToolTipText, QColor(236, 239, 244));
  p.setColor(QPalette::Highlight, QColor(60, 130, 200));
  p.setColor(QPalette::HighlightedText, Qt::white);
  p.setColor(QPalette::Mid, QColor(92, 102, 118));
  p.setColor(QPalette::Link, QColor(126, 190, 255));
  p.setColor(QPalette::LinkVisited, QColor(126, 190, 255));
  for (const QPalette::ColorRole role : {QPalette::Text, QPalette::ButtonText, QPalette::WindowText})
    p.setColor(QPalette::Disabled, role, QColor(128, 136, 148));
  // The style draws the text of disabled items a second time in this colour, one pixel lower. The colour of
  // the background makes this second text invisible.
  p.setColor(QPalette::Disabled, QPalette::Light, QColor(37, 42, 51));
  QApplication::setPalette(p);
}

std::unique_ptr<QApplication> begin_application(bool is_offscreen, const std::string& language) {
  // Qt's file dialogs store visited folders in the settings. Redirect the settings to a temporary folder.
  static const QTemporaryDir k_settings;
  QSettings::setPath(QSettings::NativeFormat, QSettings::UserScope, k_settings.path());
  QSurfaceFormat format = QVTKOpenGLNativeWidget::defaultFormat();
  format.setSamples(0);
  QSurfaceFormat::setDefaultFormat(format);
  std::unique_ptr<QApplication> application;
  static char name[] = "trephine", option[] = "-platform", platform[] = "offscreen";
  static char* argv[] = {name, option, platform, nullptr};
  static int argc = 1;
  argc = is_offscreen ? 3 : 1;  // set again, because Qt removes the options that it knows
  if (QApplication::instance() == nullptr) application = std::make_unique<QApplication>(argc, argv);
  // Qt adopts the system's locale for the C library, too. Numbers in files, options and sessions have a
  // decimal point.
  std::setlocale(LC_NUMERIC, "C");
  QApplication::setAttribute(Qt::AA_DontUseNativeDialogs);
  apply_look();
  initial_text_size();
  static bool is_language_selected = false;
  if (!std::exchange(is_language_selected, true) || !language.empty())
    select_language(QString::fromStdString(language));
  return application;
}

double initial_text_size() {
  static const double k_points = QApplication::font().pointSizeF();
  return k_points;
}

namespace {
/// Never destroyed: an application must not be destroyed after main().
OpeningPage& kept_page() {
  static auto* page = new OpeningPage;
  return *page;
}
}  // namespace

void keep_opening_page(OpeningPage page) { kept_page() = std::move(page); }
OpeningPage take_opening_page() { return std::exchange(kept_page(), {}); }

}  // namespace trephine::view
