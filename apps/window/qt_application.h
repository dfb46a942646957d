// The Qt application of the window's entry points.
#pragma once

#include <QApplication>
#include <QWidget>
#include <memory>
#include <string>

namespace trephine::view {

/// Creates the Qt application; returns null if the program already has one. In both cases, sets the look of
/// the windows, and redirects Qt's own settings to a temporary folder. `is_offscreen`: a new application
/// draws its widgets into memory, without a display. `language`: one of k_languages; empty: the language that
/// a previous call selected, or that of the system.
std::unique_ptr<QApplication> begin_application(bool is_offscreen = false, const std::string& language = {});

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
/// Returns the kept page and stops keeping it; both pointers are null if no page was kept.
OpeningPage take_opening_page();

}  // namespace trephine::view
