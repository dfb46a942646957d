// Keyboard controls of MainWindow, and events of its picture.
#include <QAction>
#include <QComboBox>
#include <QCursor>
#include <QKeyEvent>
#include <QLabel>
#include <QPushButton>
#include <QSlider>
#include <QVTKOpenGLNativeWidget.h>
#include <string>

#include "apps/window/qt_window.h"

namespace trephine::view {

bool MainWindow::eventFilter(QObject* object, QEvent* event) {
  // The picture gets the keyboard focus when the cursor enters it.
  if (object == canvas_ && event->type() == QEvent::Enter) canvas_->setFocus();
  // The picture is outdated until it is drawn in the new size.
  if (object == canvas_ && event->type() == QEvent::Resize && state_text_->text() == tr("ready"))
    state_text_->setText(tr("drawing"));
  return QMainWindow::eventFilter(object, event);
}

void MainWindow::press_deeper(int steps) {
  if (operation_ && operation_->slide_tool(steps)) return;
  depth_->setValue(depth_->value() + steps);
}

void MainWindow::tilt(double right, double up) {
  if (!operation_) return;
  operation_->tilt(right, up);
  show_message(tr("tilted %1\u00b0").arg(operation_->tilt_angle(), 0, 'f', 0));
}

void MainWindow::change_display(const std::function<void(DisplayMode&)>& change) {
  DisplayMode mode = options_.display;
  change(mode);
  const bool is_headset = mode.eyes == DisplayMode::Eyes::headset;
  Status error;
  if (is_headset && (!options_.hmd || options_.hmd->problem())) {
    options_.hmd.reset();  // a runtime may allow one instance only
    auto hmd = open_hmd();
    if (hmd)
      options_.hmd = std::move(hmd).value();
    else
      error = hmd.error();
  }
  if (!error) options_.display = mode;
  constexpr const char* actions[] = {"eyes_one", "eyes_anaglyph", "eyes_side_by_side", "eyes_headset"};
  findChild<QAction*>(actions[static_cast<std::size_t>(options_.display.eyes)])->setChecked(true);
  if (error) return show_error(*error);
  if (viewport() != nullptr) viewport()->view().set_display(mode, options_.head_tracker, options_.hmd);
}

/// Undoes the last change, or explains why this is not possible.
void MainWindow::undo() {
  const sim::LiveState& state = operation_->state();
  operation_->undo();
  // can_undo may still be false for a stroke that is just ending, which this undo reverts. This is possible
  // only if matter was removed.
  if (state.can_undo || state.removed_mm3 > 0) return;
  show_refusal(
      tr("There is no change of bone or bodies to undo. Injuries stay recorded; anchors, pins and "
         "measurements are removed with their own commands."));
}

void MainWindow::show_names(LabelLayer::Names names) {
  viewport()->view().overlays().labels().set_names(names);
  for (std::size_t i = 0; i < PaneGrid::k_panes; ++i)
    grid_->pane(i)->set_names_visible(names != LabelLayer::Names::none);
}

void MainWindow::toggle_names() {
  using Names = LabelLayer::Names;
  const Names shown = viewport()->view().overlays().labels().names();
  const Names next = shown == Names::in_front ? Names::all
                     : shown == Names::all    ? Names::none
                                              : Names::in_front;
  show_names(next);
  show_message(next == Names::in_front ? tr("Names are shown for points in front of the bone.")
               : next == Names::all    ? tr("Names are shown for all points.")
                                       : tr("Names are hidden."));
}

void MainWindow::turn(double right, double up) {
  constexpr double k_degrees = 0.3;  // per pixel
  viewport()->turn(k_degrees * right, -k_degrees * up);
}

/// Handles arrows, W A S D, and Shift with the letter of a side. Returns false for other keys.
bool MainWindow::move_by_key(const QKeyEvent* event) {
  const bool has_shift = (event->modifiers() & Qt::ShiftModifier) != 0,
             has_control = (event->modifiers() & Qt::ControlModifier) != 0;
  if (event->modifiers() & Qt::AltModifier) return false;
  glm::dvec2 direction(0);
  switch (event->key()) {
    case Qt::Key_Left:
      direction.x = -1;
      break;
    case Qt::Key_Right:
      direction.x = 1;
      break;
    case Qt::Key_Up:
      direction.y = 1;
      break;
    case Qt::Key_Down:
      direction.y = -1;
      break;
    default:
      break;
  }
  if (direction != glm::dvec2(0)) {
    constexpr double k_turn = 20;  // pixels
    const double mm = has_shift ? 0.2 : 1;
    if (has_control)
      turn(-k_turn * direction.x, -k_turn * direction.y);
    else if (operation_)
      operation_->move_tip(mm * direction.x, mm * direction.y);
    return true;
  }
  if (has_control) return false;
  if (has_shift && event->key() < 128 &&
      std::string("APLRSI").find(static_cast<char>(event->key())) != std::string::npos) {
    look_from(static_cast<char>(event->key()));
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

/// Moves the tool to the cursor. The position of the cursor is read directly, because another widget may have
/// received the last event of the mouse.
void MainWindow::follow_cursor() {
  const QPoint at = canvas_->mapFromGlobal(QCursor::pos());
  if (canvas_->width() < 2 || canvas_->height() < 2) return;  // not laid out yet
  if (!canvas_->isVisible()) {
    operation_->set_cursor(-10, -10);  // the picture is hidden by a pane: touch nothing
    cursor_.reset();
  } else if (cursor_ != at || cursor_canvas_ != canvas_->size()) {
    // A resting cursor does not move the tool, because keys may move the tip.
    operation_->set_cursor(static_cast<double>(at.x()) / canvas_->width(),
                           1 - static_cast<double>(at.y()) / canvas_->height());
    cursor_ = at, cursor_canvas_ = canvas_->size();
  }
}

/// Shows the reason why an action is not possible, at the tool and in the status line.
void MainWindow::show_refusal(const QString& reason) {
  show_message(reason);
  if (operation_) operation_->show_refusal(reason.toUtf8().constData());
}

/// Shows the reason why the command of a key is disabled. Returns false if the key is not that of a disabled
/// command with a reason.
bool MainWindow::explain_disabled(const QKeyEvent* event) {
  const QKeySequence key(static_cast<int>(event->modifiers()) | event->key());
  for (const CommandAction& one : command_actions_)
    if (one.action->shortcut() == key && !one.action->isEnabled() && !one.action->toolTip().isEmpty()) {
      show_refusal(one.action->toolTip());
      return true;
    }
  return false;
}

void MainWindow::keyPressEvent(QKeyEvent* event) {
  help_->hide();
  if (mark_by_key(event) || move_by_key(event)) return;
  const bool is_plain = (event->modifiers() & (Qt::ControlModifier | Qt::AltModifier)) == 0;
  if (!is_plain) {
    if (!explain_disabled(event)) QMainWindow::keyPressEvent(event);
    return;
  }
  switch (event->key()) {
    case Qt::Key_Space:
      if (event->isAutoRepeat()) return;
      if (operation_) operation_->press(true);
      if (replay_) replay_panel_->toggle_play();
      return;
    case Qt::Key_U:
      if (operation_) undo();
      return;
    case Qt::Key_Y:
      if (operation_) operation_->redo();
      return;
    case Qt::Key_F:
      if (operation_) operation_->reset_faults();
      return;
    case Qt::Key_T:
      if (!operation_) return;
      if (event->modifiers() & Qt::ShiftModifier) {
        if (!operation_->put_piece_back())
          show_refusal(tr("Grasp or touch a detached piece to put it back."));
      } else if (!operation_->grasp_or_release()) {
        show_refusal(tr("Touch a piece to grasp it."));
      }
      return;
    case Qt::Key_X:
      toggle_force_panel();
      return;
    case Qt::Key_E:
      log_->setVisible(log_->isHidden());
      return;
    case Qt::Key_C:
      clip_->setCurrentIndex(clip_->currentIndex() == 0 ? static_cast<int>(ClipChoice::Axis::view) : 0);
      return;
    case Qt::Key_Plus:
    case Qt::Key_Equal:
      tool_panel_->step(1);
      return;
    case Qt::Key_Minus:
      tool_panel_->step(-1);
      return;
    case Qt::Key_G:
      if (!operation_) return;
      if (operation_->has_handle()) return operation_->release_handle();
      if (!operation_->grasp_handle())
        show_refusal(tr("Touch a point of the outline (an anchor) or a pin of the clamp to drag it."));
      return;
    case Qt::Key_Comma:
    case Qt::Key_Period:
      if (operation_) operation_->roll(event->key() == Qt::Key_Comma ? -1 : 1);
      return;
    case Qt::Key_PageUp:
    case Qt::Key_PageDown:
      press_deeper(event->key() == Qt::Key_PageDown ? 1 : -1);
      return;
    case Qt::Key_M:
      if (QAction* ruler = findChild<QAction*>("measure_ruler"); ruler && ruler->isEnabled())
        ruler->trigger();
      return;
    case Qt::Key_N:
      toggle_names();
      return;
    case Qt::Key_K: {
      if (!operation_) return;
      constexpr const char* names[] = {QT_TR_NOOP("The shaft points upright on the bone."),
                                       QT_TR_NOOP("The shaft points toward the viewer."),
                                       QT_TR_NOOP("The shaft points in a fixed direction.")};
      show_message(tr(names[static_cast<int>(operation_->select_next_shaft_mode())]));
      return;
    }
    case Qt::Key_0:
      look_from(0);
      return;
    default:
      QMainWindow::keyPressEvent(event);
  }
}

/// Stops drilling when the window is deactivated, because the window then receives no releases of keys and
/// buttons.
bool MainWindow::event(QEvent* event) {
  const bool is_deactivated = event->type() == QEvent::WindowDeactivate || event->type() == QEvent::Hide;
  if (is_deactivated && operation_) operation_->press(false), operation_->release_handle();
  return QMainWindow::event(event);
}

void MainWindow::keyReleaseEvent(QKeyEvent* event) {
  if (event->key() == Qt::Key_Space && !event->isAutoRepeat() && operation_) operation_->press(false);
  QMainWindow::keyReleaseEvent(event);
}

}  // namespace trephine::view
