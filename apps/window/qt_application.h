// The Qt application of the window's entry points.
#pragma once

#include <QApplication>
#include <QWidget>
#include <memory>

namespace trephine::view {

/// Creates the application with the look of the windows, unless the program has one; then returns null. Qt
/// stores no settings of its own. `is_offscreen`: widgets are drawn into memory, without a display.
std::unique_ptr<QApplication> begin_application(bool is_offscreen = false);

/// Returns the text size (points) that the application began with.
double initial_text_size();

/// A page that remains visible while the chosen operation is opened, and its application; both may be null.
/// The page is destroyed before the application.
struct OpeningPage {
  std::unique_ptr<QApplication> application;
  std::unique_ptr<QWidget> page;
};
/// Keeps a page until take_opening_page().
void keep_opening_page(OpeningPage page);
/// Returns the kept page; empty if none is kept.
OpeningPage take_opening_page();

}  // namespace trephine::view
