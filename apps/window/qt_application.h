// The Qt application of the window's entry points.
#pragma once

#include <QApplication>
#include <memory>

namespace trephine::view {

/// Creates the application with the look of the windows, unless the program has one; then returns null. Qt
/// stores no settings of its own. `is_offscreen`: widgets are drawn into memory, without a display.
std::unique_ptr<QApplication> begin_application(bool is_offscreen = false);

}  // namespace trephine::view
