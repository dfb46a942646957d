// The window's keys.
#include <QComboBox>
#include <QKeyEvent>
#include <QPushButton>
#include <QSlider>
#include <string>

#include "apps/view/qt_window.h"

namespace trephine::view {

void MainWindow::press_deeper(int steps) {
  if (operation_ && operation_->slide_foot(steps)) return;
  depth_->setValue(depth_->value() + steps);
}

void MainWindow::tilt(double right, double up) {
  if (!operation_) return;
  operation_->tilt(right, up);
  say(QString("tilted %1\u00b0").arg(operation_->tilted(), 0, 'f', 0));
}

void MainWindow::toggle_names() {
  LabelLayer& names = viewport()->view().overlays().labels();
  names.set_visible(!names.is_visible());
}

void MainWindow::turn(double right, double up) {
  constexpr double k_degrees = 0.3;  // a pixel
  viewport()->turn(k_degrees * right, -k_degrees * up);
}

/// Arrows, W A S D, and Shift with the letter of a side.
bool MainWindow::move_by_key(const QKeyEvent* event) {
  const bool is_fine = (event->modifiers() & Qt::ShiftModifier) != 0,
             is_turn = (event->modifiers() & Qt::ControlModifier) != 0;
  if (event->modifiers() & Qt::AltModifier) return false;
  glm::dvec2 way(0);
  switch (event->key()) {
    case Qt::Key_Left:
      way.x = -1;
      break;
    case Qt::Key_Right:
      way.x = 1;
      break;
    case Qt::Key_Up:
      way.y = 1;
      break;
    case Qt::Key_Down:
      way.y = -1;
      break;
    default:
      break;
  }
  if (way != glm::dvec2(0)) {
    constexpr double k_turn = 20;  // pixels
    const double mm = is_fine ? 0.2 : 1;
    if (is_turn)
      turn(-k_turn * way.x, -k_turn * way.y);
    else if (operation_)
      operation_->move_tip(mm * way.x, mm * way.y);
    return true;
  }
  if (is_turn) return false;
  if (is_fine && event->key() < 128 &&
      std::string("APLRSI").find(static_cast<char>(event->key())) != std::string::npos) {
    viewport()->look_from(static_cast<char>(event->key()));
    return true;
  }
  constexpr double k_tilt = 2;  // degrees
  switch (event->key()) {
    case Qt::Key_A:
      return tilt(-k_tilt, 0), true;
    case Qt::Key_D:
      return tilt(k_tilt, 0), true;
    case Qt::Key_W:
      return tilt(0, k_tilt), true;
    case Qt::Key_S:
      return tilt(0, -k_tilt), true;
    default:
      return false;
  }
}

void MainWindow::keyPressEvent(QKeyEvent* event) {
  help_->hide();
  if (move_by_key(event)) return;
  const bool is_plain = (event->modifiers() & (Qt::ControlModifier | Qt::AltModifier)) == 0;
  if (!is_plain) return QMainWindow::keyPressEvent(event);
  switch (event->key()) {
    case Qt::Key_Space:
      if (event->isAutoRepeat()) return;
      if (operation_) operation_->press(true);
      if (replay_) play_->click();
      return;
    case Qt::Key_U:
      if (operation_) operation_->undo();
      return;
    case Qt::Key_Y:
      if (operation_) operation_->redo();
      return;
    case Qt::Key_F:
      if (operation_) operation_->reset_faults();
      return;
    case Qt::Key_T:
      if (operation_ && !operation_->take_or_put_down()) say("Touch a piece to take it.");
      return;
    case Qt::Key_E:
      log_->setVisible(log_->isHidden());
      return;
    case Qt::Key_C:
      clip_->setCurrentIndex(clip_->currentIndex() == 0 ? static_cast<int>(ClipChoice::Axis::view) : 0);
      return;
    case Qt::Key_Plus:
    case Qt::Key_Equal:
      tool_->step(1);
      return;
    case Qt::Key_Minus:
      tool_->step(-1);
      return;
    case Qt::Key_G:
      if (!operation_) return;
      if (operation_->has_point()) return operation_->drop_point();
      if (!operation_->grab_point()) say("Touch a point of an outline to drag it.");
      return;
    case Qt::Key_Comma:
    case Qt::Key_Period:
      if (operation_) operation_->roll(event->key() == Qt::Key_Comma ? -1 : 1);
      return;
    case Qt::Key_PageUp:
    case Qt::Key_PageDown:
      press_deeper(event->key() == Qt::Key_PageDown ? 1 : -1);
      return;
    case Qt::Key_N:
      toggle_names();
      return;
    case Qt::Key_K: {
      if (!operation_) return;
      constexpr const char* names[] = {"upright on the bone", "toward the viewer", "as it is now"};
      say(QString("The shaft points %1.").arg(names[static_cast<int>(operation_->hold_next())]));
      return;
    }
    case Qt::Key_0:
      viewport()->look_from(0);
      return;
    default:
      QMainWindow::keyPressEvent(event);
  }
}

/// Releases of keys and buttons outside of the window are never reported: a window that is not in front does
/// not drill.
bool MainWindow::event(QEvent* event) {
  const bool is_left = event->type() == QEvent::WindowDeactivate || event->type() == QEvent::Hide;
  if (is_left && operation_) operation_->press(false), operation_->drop_point();
  return QMainWindow::event(event);
}

void MainWindow::keyReleaseEvent(QKeyEvent* event) {
  if (event->key() == Qt::Key_Space && !event->isAutoRepeat() && operation_) operation_->press(false);
  QMainWindow::keyReleaseEvent(event);
}

}  // namespace trephine::view
