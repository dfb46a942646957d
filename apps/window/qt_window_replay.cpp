// Replay of a session in MainWindow: panel, events, notes, forces, and continuation of the operation.
#include <QLabel>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vtkCamera.h>
#include <vtkRenderer.h>

#include "apps/window/qt_steps_panel.h"
#include "apps/window/qt_window.h"

namespace trephine::view {

void MainWindow::build_replay_panel() {
  replay_panel_ = new ReplayPanel(options_.summary, options_.replay_seconds, options_.replayed_file, this);
  replay_panel_->on_error = [this](const Error& error) { show_error(error); };
  replay_panel_->on_notes = [this] {
    log_->clear();
    collect_replay_notices();
  };
  addDockWidget(Qt::BottomDockWidgetArea, replay_panel_);
  force_panel_ = new ForcePanel(this);
  force_panel_->on_visible = [this](bool is_visible) {
    if (replay_) replay_->explain_force(is_visible);
  };
  force_panel_->on_step = [this](int ticks) {
    if (const Status error = replay_->step(ticks)) show_error(*error);
  };
  addDockWidget(Qt::LeftDockWidgetArea, force_panel_);
}

void MainWindow::begin_replay(vtkRenderWindow* window) {
  replay_ = std::make_unique<ReplayController>(*scene_, *options_.replay, options_.rate_hz,
                                               options_.replay_seconds, options_.summary, window);
  replay_->start();
  replay_panel_->control(*replay_);
  const bool is_one_hand = replay_->engine().hand_count() == 1;
  std::function<void()> take_over;
  if (options_.may_take_over && is_one_hand)
    take_over = [this] {
      report_.taken_over_at = std::min(replay_->seconds(), replay_->duration());
      close();
    };
  replay_panel_->allow_take_over(std::move(take_over),
                                 is_one_hand ? tr("This session cannot be continued from here")
                                             : tr("A session of several hands cannot be continued"));
  collect_replay_notices();
}

/// Collects the events and notes of the session in the order of their times.
void MainWindow::collect_replay_notices() {
  std::vector<Notices::Entry> entries;
  for (const auto& mark : options_.summary.marks)
    entries.push_back({mark.seconds, mark.seconds, mark.level, mark.text});
  for (const data_tools::SessionNote& note : replay_panel_->notes())
    entries.push_back({note.seconds, note.seconds, workbench::EventLevel::outcome,
                       tr("Note: %1").arg(QString::fromStdString(note.text)).toStdString()});
  std::stable_sort(entries.begin(), entries.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  replay_notices_ = {};
  for (Notices::Entry& entry : entries) replay_notices_.add(std::move(entry));
  shown_note_marks_.clear();
}

/// Shows the state of the replay, and the notes of its time in the picture.
void MainWindow::show_replay_state() {
  show_steps();
  show_notices();
  replay_panel_->show_state();
  sim::Overlays marks = ReplayPanel::marks_of(replay_panel_->notes(), replay_->seconds());
  const std::size_t count = marks.empty() ? 0 : marks[0].handles.size();
  std::vector<glm::dvec3> positions;
  for (std::size_t i = 0; i < count; ++i) positions.push_back(marks[0].handles[i].at);
  if (positions != shown_note_marks_) {
    shown_note_marks_ = std::move(positions);
    viewport()->set_marks(std::move(marks));
  }
  servo_->setText(tr("Replay at %1 Hz").arg(options_.rate_hz, 0, 'f', 0));
  const double share = viewport()->drawn_share();
  state_text_->setText(replay_->record().faults & haptics::k_latched_faults
                           ? tr("\u26a0 the force was off at this time")
                       : replay_->is_seeking() ? tr("replaying the session up to this time ...")
                       : share < 1             ? tr("drawing, %1 %").arg(static_cast<int>(100 * share))
                                               : "");
}

void MainWindow::follow(MainWindow& leader) {
  leader_ = &leader;
  leader.replay_->set_length(replay_->duration());
  leader.replay_panel_->set_length(leader.replay_->length());
  replay_panel_->hide();
}

/// Goes to the time of the leader's replay, and copies the leader's view if it changed. Closes this window if
/// the leader was closed.
void MainWindow::follow_leader() {
  if (!leader_->isVisible()) {
    leader_ = nullptr;
    close();
    return;
  }
  replay_->play(false);
  const double seconds = std::min(leader_->replay_->seconds(), replay_->length());
  if (std::abs(replay_->seconds() - seconds) > 0.5 / options_.rate_hz)
    if (const Status error = replay_->begin_seek(seconds)) show_error(*error);
  vtkCamera* view = leader_->viewport()->view().renderer()->GetActiveCamera();
  if (std::exchange(leader_view_time_, view->GetMTime()) != view->GetMTime())
    viewport()->view().renderer()->GetActiveCamera()->ShallowCopy(view);
}

/// Shows or hides the parts of the force of a replay. Pauses the replay when they are shown.
void MainWindow::toggle_force_panel() {
  if (force_panel_ == nullptr) return;
  if (force_panel_->isHidden() && steps_panel_) width_without_forces_ = steps_panel_->width();
  force_panel_->setVisible(force_panel_->isHidden());
  if (force_panel_->isHidden()) {
    // The panel of the steps, in the same column, returns to its width.
    if (steps_panel_ && width_without_forces_ > 0)
      resizeDocks({steps_panel_}, {width_without_forces_}, Qt::Horizontal);
    return;
  }
  replay_->play(false);
  resizeDocks({force_panel_}, {30 * fontMetrics().averageCharWidth() + 160}, Qt::Horizontal);
}

}  // namespace trephine::view
