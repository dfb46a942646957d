#include "apps/window/qt_window.h"

#include <QAction>
#include <QApplication>
#include <QCheckBox>
#include <QCloseEvent>
#include <QComboBox>
#include <QDockWidget>
#include <QDoubleSpinBox>
#include <QDragEnterEvent>
#include <QKeyEvent>
#include <QLabel>
#include <QMessageBox>
#include <QMimeData>
#include <QProgressBar>
#include <QPushButton>
#include <QSlider>
#include <QStatusBar>
#include <QTimer>
#include <QVTKOpenGLNativeWidget.h>
#include <cmath>
#include <glm/geometric.hpp>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

#include "apps/view/render_window.h"
#include "apps/view/stylus_style.h"
#include "apps/window/qt_application.h"
#include "apps/window/qt_elided_label.h"
#include "apps/window/qt_localizer.h"
#include "apps/window/qt_score_dialog.h"
#include "apps/window/qt_structure_panel.h"
#include "apps/workbench/clock.h"
#include "apps/workbench/operation.h"
#include "apps/workbench/plan_overlays.h"
#include "volume/cuts/shape_choice.h"
#include "volume/scan/bone_labels.h"

namespace trephine::view {

using workbench::Clock;
using workbench::seconds_since;

MainWindow::MainWindow(std::shared_ptr<const haptics::TouchScene> scene, const WindowOptions& options)
    : options_(options), opened_at_(Clock::now()), last_tick_(Clock::now()) {
  setObjectName("main_window");
  setAcceptDrops(true);
  resize(static_cast<int>(options.width), static_cast<int>(options.height));
  report_.window = "qt";
  build_panel();
  log_ = new EventLog(this);
  addDockWidget(Qt::BottomDockWidgetArea, log_);
  options.replay ? build_replay_panel() : build_history_panel();
  build_menu();
  servo_ = new QLabel;
  servo_->setObjectName("servo");
  servo_->setContentsMargins(0, 0, 2 * fontMetrics().averageCharWidth(), 0);
  state_text_ = new ElidedLabel;
  state_text_->setObjectName("fault");
  state_text_->setMinimumWidth(state_text_->fontMetrics().horizontalAdvance(tr("drawing, %1 %").arg(99)));
  notice_ = new ElidedLabel;
  notice_->setObjectName("notice");
  statusBar()->addWidget(servo_);
  statusBar()->addWidget(notice_, 1);
  opening_bar_ = new QProgressBar;
  opening_bar_->setObjectName("opening");
  opening_bar_->setMaximumWidth(160);
  opening_bar_->hide();
  cancel_ = new QPushButton(tr("Cancel"));
  cancel_->setObjectName("cancel_opening");
  cancel_->setFocusPolicy(Qt::NoFocus);
  cancel_->hide();
  connect(cancel_, &QPushButton::clicked, this, &MainWindow::cancel_opening);
  statusBar()->addPermanentWidget(opening_bar_);
  statusBar()->addPermanentWidget(cancel_);
  statusBar()->addPermanentWidget(state_text_);
  build_panes();
  panes_.apply = [this](sim::Value command) {
    if (operation_) operation_->apply(std::move(command));
  };
  if (options_.replay) panes_.apply = nullptr;
  begin(options.start ? options.start->scene() : std::move(scene));
  restore_layout();
  close_unusable_xray_pane();
  help_ = new HelpOverlay(this);
  connect(&timer_, &QTimer::timeout, this, &MainWindow::tick);
  timer_.start(16);
  preview_timer_.setSingleShot(true);
  connect(&preview_timer_, &QTimer::timeout, this, &MainWindow::preview_shape);
}

MainWindow::~MainWindow() {
  timer_.stop();
  *opening_.is_cancelled = true;
  if (opening_.result.valid()) opening_.result.wait();
  if (parts_.valid()) parts_.wait();
  operation_.reset();  // destroyed before the canvas that it draws on
  replay_.reset();
}

void MainWindow::begin(std::shared_ptr<const haptics::TouchScene> scene) {
  operation_.reset();
  delete score_;
  score_ = nullptr;
  delete case_panel_;
  case_panel_ = nullptr;
  cursor_.reset();
  panes_.begin();
  followed_clip_.reset();
  scene_ = std::move(scene);
  canvas_ = new QVTKOpenGLNativeWidget;
  canvas_->setObjectName("canvas");
  canvas_->setMinimumHeight(240);  // the grid sets the least width
  canvas_->setMouseTracking(true);
  canvas_->setFocusPolicy(Qt::StrongFocus);
  canvas_->installEventFilter(this);
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  canvas_->setRenderWindow(window);
  grid_->set_canvas(canvas_);
  tool_notice_ = new NoticeLabel(canvas_);
  has_been_whole_ = false;
  drawing_ = new QLabel(canvas_);
  drawing_->setObjectName("drawing");
  drawing_->setStyleSheet(
      "color: #e8ecf2; background: rgba(14, 16, 20, 205); border-radius: 4px; padding: 4px 10px");
  drawing_->setAttribute(Qt::WA_TransparentForMouseEvents);
  build_prompt();
  log_->clear();
  Viewport* picture = nullptr;
  if (options_.replay) {
    begin_replay(window);
    picture = &replay_->viewport();
    begin_steps();
  } else {
    operation_ = std::make_unique<OperationController>(*scene_, options_, window);
    shown_tool_ = operation_->tool(tool_hand_);
    begin_steps();
    tool_panel_->show(shown_tool_);
    fit_panel();
    show_assumptions();
    if (!options_.host.interrupted_session.empty())
      show_message(tr("A session was interrupted. Continue it in the File menu."));
    operation_->set_depth(0.5 * depth_->value());
    if (const auto* workspace = findChild<QAction*>("workspace"))
      operation_->show_workspaces(workspace->isChecked());
    picture = &operation_->viewport();
  }
  // A spine is operated on from the back: select this view for the picture and all panes.
  const bool is_from_back = options_.side == 'P' || (options_.side == 0 && volume::is_spine(*scene_->base));
  picture->look_from(is_from_back ? 'P' : options_.side);
  set_from_back(is_from_back);
  // Start after the camera is aimed, because a haptic device begins in front of the camera.
  if (operation_)
    if (const Status error = operation_->start()) show_error(*error);
  if (options_.side == 0 && !is_from_back)
    if (const std::optional<glm::dvec3> work = work_position()) picture->look_at_work(*work);
  if (const Status error = picture->set_opacities(std::exchange(options_.opacities, {}))) show_error(*error);
  picture->view().set_display(options_.display, options_.head_tracker, options_.hmd);
  structures_->show_list(picture->structures());
  if (options_.plan) picture->set_plan(workbench::plan_overlays(*options_.plan, *scene_));
  picture->view().set_text_scale(QApplication::font().pointSizeF() / initial_text_size());
  vtkNew<StylusStyle> style;
  style->SetDefaultRenderer(picture->view().renderer());
  style->on_press = [this](bool is_down) {
    if (marking_.is_active()) {
      if (is_down) mark_picked_point();
    } else if (operation_) {
      operation_->press(is_down);
    }
  };
  style->on_shift_press = [this](bool is_down) {
    if (!operation_) return;
    if (!is_down) return operation_->release_handle();
    if (!operation_->grasp_handle())
      show_refusal(tr("Touch a point of the outline (an anchor) or a pin of the clamp to drag it."));
  };
  style->on_wheel = [this](int steps) { press_deeper(steps); };
  style->on_roll = [this](int steps) {
    if (operation_) operation_->roll(steps);
  };
  style->on_tilt = [this](bool is_down) {
    if (operation_) operation_->hold_tip(is_down);
  };
  style->on_tilt_move = [this](double right, double up) {
    constexpr double k_degrees = 0.3;  // per pixel
    tilt(k_degrees * right, k_degrees * up);
  };
  style->on_zoom = [this](int direction, double x, double y) {
    viewport()->zoom(*version(), direction > 0 ? 1.15 : 1 / 1.15, x, y);
  };
  style->on_turn = [this](double right, double up) { turn(right, up); };
  canvas_->interactor()->SetInteractorStyle(style);
  canvas_->setFocus();
  setWindowTitle(QString::fromStdString(options_.title) + " - trephine");
  const volume::Shape& shape = scene_->items[0].field.shape();
  const bool can_reshape = operation_ && !shape.is_label() && options_.host.reshape;
  const QSignalBlocker quiet_largest(largest_);
  largest_->setChecked(false);
  shape_of_->setCurrentIndex(0);
  for (QWidget* w : std::initializer_list<QWidget*>{low_, high_, largest_, shape_of_})
    w->setEnabled(can_reshape);
  has_checked_parts_ = !can_reshape;
  // Presets require CT.
  if (!scene_->base->is_hounsfield) shape_of_->setEnabled(false);
  for (QDoubleSpinBox* box : {low_, high_}) {
    const QSignalBlocker quiet(box);
    const double value = box == low_ ? shape.low : shape.high;
    box->setValue(std::isfinite(value) ? value : value > 0 ? box->maximum() : box->minimum());
  }
  forget_preview();
}

Viewport* MainWindow::viewport() {
  return operation_ ? &operation_->viewport() : replay_ ? &replay_->viewport() : nullptr;
}

std::shared_ptr<const volume::Version> MainWindow::version() const {
  return operation_ ? operation_->version() : replay_->engine().version();
}

// ---- user events ----------------------------------------------------------------------------------------

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (options_.host.open && event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  const QList<QUrl> urls = event->mimeData()->urls();
  if (!urls.isEmpty()) open_source(urls.first().toLocalFile());
}

void MainWindow::resizeEvent(QResizeEvent* event) {
  QMainWindow::resizeEvent(event);
  if (help_) help_->setGeometry(rect());
}

void MainWindow::scale_text(double factor) {
  QFont font = QApplication::font();
  font.setPointSizeF(std::clamp(font.pointSizeF() * factor, 6.0, 30.0));
  QApplication::setFont(font);
  QApplication::setFont(font, "QDockWidgetTitle");
  for (QDockWidget* dock : findChildren<QDockWidget*>()) dock->setFont(font);
  if (Viewport* picture = viewport()) picture->view().set_text_scale(font.pointSizeF() / initial_text_size());
  for (std::size_t i = 0; i < PaneGrid::k_panes; ++i) grid_->pane(i)->lay_out();
  fit_panel();
}

void MainWindow::set_clip() {
  if (viewport() == nullptr) return;
  using Axis = ClipChoice::Axis;
  constexpr Axis axes[] = {Axis::none, Axis::left, Axis::back, Axis::up, Axis::view, Axis::plane};
  clip_share_->setEnabled(clip_->currentIndex() > 0 && clip_->currentIndex() < 5);
  const imaging::Panes& panes = panes_.panes();
  viewport()->set_clip({axes[clip_->currentIndex()], 0.01 * clip_share_->value(),
                        followed_clip_ ? followed_clip_->at : panes.focus(),
                        followed_clip_ ? followed_clip_->normal : panes.section_normal()});
}

/// After the picture was drawn, searches for large disconnected parts, such as a table or a head holder, and
/// reports them.
void MainWindow::report_disconnected_parts() {
  if (!has_checked_parts_ && !parts_.valid() && viewport()->is_complete()) {
    has_checked_parts_ = true;
    parts_ = std::async(std::launch::async, [scene = scene_, owner = owner_] {
      const volume::ShapeParts parts = volume::parts_of(scene->base, scene->items[0].field.shape());
      return std::pair(scene, parts.is_other_large());
    });
  }
  if (!parts_.valid() || parts_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  const auto [scene, is_other_large] = parts_.get();
  if (!is_other_large || scene != scene_ || !operation_) return;  // another scan was opened during the search
  const char* text =
      "The solid shape has disconnected parts, such as a table, a head holder or another bone. To omit them, "
      "check \"Largest part only\" and press \"Use\".";
  operation_->note(text);
  show_message(localized(QString(text)));
}

void MainWindow::preview_shape() {
  if (!operation_ || low_->value() > high_->value()) return;
  auto preview = std::make_unique<haptics::TouchScene>();
  volume::Shape shape;
  shape.low = low_->value();
  if (high_->value() < high_->maximum()) shape.high = high_->value();
  preview->base = scene_->base;
  preview->items.push_back(
      {volume::Field(*scene_->base, shape),
       std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene_->base, shape)),
       {},
       haptics::Side::front});
  viewport()->preview(std::move(preview), version());
  is_previewing_ = true;
  use_shape_->setEnabled(true);
  reset_shape_->setEnabled(true);
}

void MainWindow::forget_preview() {
  is_previewing_ = false;
  use_shape_->setEnabled(false);
  reset_shape_->setEnabled(false);
}

void MainWindow::show_error(const Error& error) {
  auto* box = new QMessageBox(QMessageBox::Warning, "trephine", QString::fromStdString(error.message()),
                              QMessageBox::Ok, this);
  box->setObjectName("error");
  box->setAttribute(Qt::WA_DeleteOnClose);
  box->open();
}

// ---- the frame ------------------------------------------------------------------------------------------

void MainWindow::tick() {
  if (stage_.stage() == WindowStage::Stage::closing) return;
  if ((options_.seconds && seconds_since(opened_at_) > *options_.seconds) || options_.should_close()) {
    is_ended_by_program_ = true;
    QApplication::closeAllWindows();  // includes dialogs
    return;
  }
  adopt_opened();
  collect_replays();
  const double elapsed = seconds_since(last_tick_);
  last_tick_ = Clock::now();
  if (!is_drawable()) return;
  if (EyeDisplay* eyes = viewport()->view().eyes())
    if (const Status problem = eyes->take_problem()) {
      change_display([](DisplayMode& mode) { mode.eyes = DisplayMode::Eyes::one; });
      show_error(*problem);
    }
  if (operation_) {
    follow_cursor();
    show_marking();
    operation_->frame();
  } else if (replay_) {
    if (leader_ != nullptr) follow_leader();
    if (const Status error = replay_->frame(elapsed)) {
      replay_->play(false);
      show_error(*error);
    }
  }
  show_drawing();
  if (!has_first_frame_ && viewport()->triangle_count() > 0) {
    has_first_frame_ = true;
    report_.first_frame_seconds = seconds_since(opened_at_);
  }
  show_panes(elapsed);
  show_state();
  report_disconnected_parts();
}

/// Shows the progress of drawing until the anatomy has been drawn once; in a replay, also after a jump.
void MainWindow::show_drawing() {
  constexpr double k_soon = 0.5;  // s; in a replay, a shorter update needs no text
  const bool is_whole = viewport()->is_whole();
  if (is_whole) was_whole_at_ = Clock::now(), has_been_whole_ = true;
  const bool is_late = replay_ && seconds_since(was_whole_at_) > k_soon;
  if (is_whole || (has_been_whole_ && !is_late)) {
    drawing_->hide();
    return;
  }
  drawing_->setText(tr("Drawing the anatomy: %1 %").arg(static_cast<int>(100 * viewport()->drawn_share())));
  drawing_->adjustSize();
  drawing_->move(canvas_->rect().center() - drawing_->rect().center());
  drawing_->show();
}

bool MainWindow::is_drawable() const {
  return vtkGenericOpenGLRenderWindow::SafeDownCast(canvas_->renderWindow())->GetReadyForRendering() &&
         canvas_->width() >= 2;
}

/// Shows a message in the status line for 10 s.
void MainWindow::show_message(const QString& text) {
  notice_->setText(text);
  QTimer::singleShot(std::chrono::seconds(10), notice_, [notice = notice_, text] {
    if (notice->text() == text) notice->clear();
  });
}

/// Shows the messages at the tip of the tool, and updates the log.
void MainWindow::show_notices() {
  const haptics::ServoRecord& newest = operation_ ? operation_->state().newest : replay_->record();
  const glm::dvec2 tip = viewport()->project(newest.proxy_world);
  const QString text =
      localized(operation_ ? operation_->notice_text() : replay_notices_.shown(replay_->seconds()));
  const double scale = 1 / canvas_->devicePixelRatioF();
  std::vector<QRect> labels;
  if (tool_notice_->needs_layout(text))
    for (const auto& [low, high] : viewport()->view().label_boxes())
      labels.push_back(QRectF(scale * low.x, canvas_->height() - scale * high.y, scale * (high.x - low.x),
                              scale * (high.y - low.y))
                           .toAlignedRect());
  tool_notice_->show_at(
      text, operation_ ? operation_->notice_level() : replay_notices_.shown_level(replay_->seconds()),
      {static_cast<int>(tip.x * canvas_->width()), static_cast<int>((1 - tip.y) * canvas_->height())},
      labels);
  log_->update_from(operation_ ? operation_->notices() : replay_notices_);
  if (replay_) log_->show_time(replay_notices_, replay_->seconds());
  if (force_panel_ && force_panel_->isVisible())
    force_panel_->show_parts(replay_->force_parts(), *replay_->touch_scene(), replay_->is_playing());
}

void MainWindow::show_state() {
  const haptics::ServoRecord& record = operation_ ? operation_->state().newest : replay_->record();
  const double force = glm::length(record.force_world);
  force_bar_->show_force(force, options_.force.force_limit);
  if (is_sound_on_) sound_.show(force, record.pose.is_pressed(), record.has_contact);
  const double removed = operation_ ? operation_->state().removed_mm3 : replay_->engine().removed_mm3();
  const std::size_t changes = operation_ ? operation_->state().strokes : replay_->engine().stroke_count();
  removed_->setText(
      removed > 0 ? changes == 1 ? tr("%L1 mm\u00b3 removed, 1 change").arg(removed, 0, 'f', 1)
                                 : tr("%L1 mm\u00b3 removed, %2 changes").arg(removed, 0, 'f', 1).arg(changes)
                  : tr("nothing removed yet"));
  const bool can_undo = operation_ && operation_->state().can_undo,
             can_redo = operation_ && operation_->state().can_redo;
  undo_->setEnabled(can_undo), undo_action_->setEnabled(operation_ != nullptr);  // undo() explains refusals
  redo_->setEnabled(can_redo), redo_action_->setEnabled(can_redo);
  if (operation_) {
    show_history();
    const std::string refused = operation_->take_refusal();
    if (!refused.empty() || !(operation_->tool(tool_hand_) == shown_tool_)) {
      shown_tool_ = operation_->tool(tool_hand_);
      tool_panel_->show(shown_tool_);
      fit_panel();
    }
    if (!operation_->is_changing_instrument() && notice_->text() == preparing_text()) notice_->clear();
    if (!refused.empty()) {
      show_message(localized("The command was refused: " + refused));
    }
    show_steps();
    show_notices();
    constexpr double k_servo_seconds = 1;  // between two updates of the servo's times
    if (seconds_since(servo_shown_at_) > k_servo_seconds || servo_->text().isEmpty()) {
      servo_shown_at_ = Clock::now();
      const haptics::ServoReport servo = operation_->servo();
      servo_->setText(tr("Forces: %1 Hz, step %L2 \u00b5s, delay %3 \u00b5s")
                          .arg(options_.rate_hz, 0, 'f', 0)
                          .arg(servo.step_p50_us, 0, 'f', 1)
                          .arg(servo.late_p50_us, 0, 'f', 0));
    }
    const std::string fault = operation_->fault_text();
    const double share = viewport()->drawn_share();
    const Status recording = options_.recorder ? options_.recorder->status() : std::nullopt;
    state_text_->setText(!fault.empty() ? "\u26a0 " + localized(fault)
                         : recording
                             ? QString::fromStdString("\u26a0 " + recording->what + ": " + recording->found)
                         : record.is_escaping                   ? tr("guiding the tool out of restored bone")
                         : operation_->is_changing_instrument() ? ""
                         : operation_->state().pending_jobs > 0 ? localized(operation_->job_text())
                         : share < 1 ? tr("drawing, %1 %").arg(static_cast<int>(100 * share))
                         : panes_.panes().is_waiting() ? tr("computing images ...")
                                                       : tr("ready"));
    const QString style = fault.empty() && !recording ? "" : "color: #f6c944; font-weight: bold";
    if (state_text_->styleSheet() != style) state_text_->setStyleSheet(style);
  } else {
    show_replay_state();
  }
}

WindowReport MainWindow::finish() {
  timer_.stop();
  if (stage_.close() && operation_) {
    const double first_frame_seconds = report_.first_frame_seconds;
    report_ = operation_->finish();
    report_.window = "qt";
    report_.first_frame_seconds = first_frame_seconds;
  }
  return report_;
}

void MainWindow::closeEvent(QCloseEvent* event) {
  save_layout();
  // Show a message only if the user closes the window: a program or a time limit must not wait for a dialog.
  if (const QString session = saved_session();
      !session.isEmpty() && !is_ended_by_program_ && (event->spontaneous() || is_quitting_)) {
    const WindowStage::Dialog dialog(stage_);
    QMessageBox::information(
        this, "trephine",
        tr("The session is saved as\n%1\n\nTo continue it later, choose it on the start page of trephine "
           "simulator, or run trephine resume.")
            .arg(session));
  }
  if (!options_.screenshot.empty())
    screenshot_error_ = save_picture(QString::fromStdString(options_.screenshot));
  finish();
  QMainWindow::closeEvent(event);
}

}  // namespace trephine::view
