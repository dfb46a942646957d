// Procedure of MainWindow: panel of the steps, and instruments and commands that the current step allows.
#include <QAction>
#include <QMenu>
#include <algorithm>
#include <utility>

#include "apps/window/qt_localizer.h"
#include "apps/window/qt_score_dialog.h"
#include "apps/window/qt_steps_panel.h"
#include "apps/window/qt_window.h"
#include "modules/fluoroscopy/fluoroscopy.h"

namespace trephine::view {

/// Shows the panel of steps if the operation or the replay has a procedure. Otherwise enables all instruments
/// and commands of an operation.
void MainWindow::begin_steps() {
  delete steps_panel_;
  steps_panel_ = nullptr;
  shown_step_ = -1;
  is_next_step_requested_ = false;
  const StepGuide* guide = steps();
  if (next_step_action_) next_step_action_->setVisible(operation_ && guide != nullptr);
  if (operation_ && guide == nullptr) return allow_everything();
  if (guide == nullptr) return;
  steps_panel_ = new StepsPanel(guide->procedure(), this);
  steps_panel_->on_request = [this](const std::string& step) {
    if (operation_) operation_->go_to_step(step);
  };
  if (operation_ && options_.host.score) steps_panel_->on_score = [this] { show_score(); };
  addDockWidget(Qt::LeftDockWidgetArea, steps_panel_);
  close_unusable_xray_pane();
  show_steps();
}

/// Shows the picture alone if the layout of the last run has an X-ray pane that no step allows to use.
void MainWindow::close_unusable_xray_pane() {
  const StepGuide* guide = steps();
  if (operation_ && guide != nullptr && grid_->arrangement() == Layout::xray &&
      !guide->is_ever_allowed(sim::value_type<fluoroscopy::Shoot>()))
    grid_->arrange(Layout::picture);
}

/// Returns the position that the first picture shows: that of the last work, or if a step cuts a flap, the
/// middle of the planned outline.
std::optional<glm::dvec3> MainWindow::work_position() const {
  if (options_.summary.work_position) return options_.summary.work_position;
  const StepGuide* guide = steps();
  if (!operation_ || guide == nullptr || !options_.plan || options_.plan->outlines.empty())
    return std::nullopt;
  const auto cuts_flap = [](const volume::ProcedureStep& step) {
    return std::find(step.commands.begin(), step.commands.end(), "cut-flap") != step.commands.end();
  };
  const auto& all = guide->procedure().steps;
  if (std::none_of(all.begin(), all.end(), cuts_flap)) return std::nullopt;
  glm::dvec3 middle(0);
  const auto& points = options_.plan->outlines.front().points_world;
  for (const glm::dvec3& p : points) middle += p / static_cast<double>(points.size());
  return middle;
}

/// Returns the steps of the operation or of the replayed session; null without a procedure.
const StepGuide* MainWindow::steps() const {
  return operation_ ? operation_->steps() : replay_ ? replay_->steps() : nullptr;
}

/// Updates the panel. After a change of the step, also enables the instruments and commands that it allows.
void MainWindow::show_steps() {
  if (steps_panel_ == nullptr) return;
  const StepGuide& guide = *steps();
  if (guide.revision() == 0) return;  // no state yet
  steps_panel_->update_from(guide);
  if (!operation_) return;
  if (std::exchange(is_next_step_requested_, false)) go_to_next_step();
  const int step = static_cast<int>(guide.index());
  if (std::exchange(shown_step_, step) == step) return;
  tool_panel_->permit(
      [&guide](const sim::InstrumentType& instrument) { return guide.allowed_parameters(instrument); });
  tool_panel_->show(operation_->tool(tool_hand_));
  set_xray_refusal(localized(guide.reason_against(sim::value_type<fluoroscopy::Shoot>())));
  for (const CommandAction& one : command_actions_) {
    const QString reason = localized(guide.reason_against(*one.type));
    one.action->setEnabled(reason.isEmpty());
    one.action->setToolTip(reason);  // if empty: the text of the action
    one.menu->setToolTipsVisible(true);
  }
}

/// Enables the C-arms of all panes, or disables them for a reason.
void MainWindow::set_xray_refusal(const QString& reason) {
  for (std::size_t i = 0; i < PaneGrid::k_panes; ++i) grid_->pane(i)->set_xray_refusal(reason);
}

void MainWindow::allow_everything() {
  set_xray_refusal({});
  tool_panel_->permit(nullptr);
  for (const CommandAction& one : command_actions_) {
    one.action->setEnabled(true);
    one.action->setToolTip({});
    one.menu->setToolTipsVisible(false);
  }
}

/// Requests the first next step that is allowed. If no next step is allowed, shows the reason.
void MainWindow::go_to_next_step() {
  if (!operation_ || operation_->steps() == nullptr) return;
  const StepGuide& guide = *operation_->steps();
  // A step before the current one is requested by its button only.
  const auto is_later = [&](const std::string& step) {
    return guide.procedure().find(step) > static_cast<int>(guide.index());
  };
  std::vector<StepGuide::Next> all = guide.next();
  std::erase_if(all, [&](const StepGuide::Next& next) { return !is_later(next.step); });
  for (const StepGuide::Next& next : all)
    if (next.is_allowed) return operation_->go_to_step(next.step);
  if (all.empty()) {
    const auto& transitions = guide.step().transitions;
    const auto later = std::find_if(transitions.begin(), transitions.end(),
                                    [&](const auto& transition) { return is_later(transition.to); });
    if (later == transitions.end()) return show_refusal(tr("This is the last step."));
    const int next = guide.procedure().find(later->to);
    const std::string& title = StepGuide::title_of(guide.procedure().steps[static_cast<std::size_t>(next)]);
    return show_refusal(
        tr("The next step, \"%1\", begins by itself when its conditions are met.").arg(localized(title)));
  }
  const QString reason = localized(all.front().reason);
  if (reason.isEmpty())
    is_next_step_requested_ = true;  // its conditions are being checked
  else
    show_refusal(reason);
}

/// Judges the recording so far in a dialog.
void MainWindow::show_score() {
  if (!operation_ || !options_.host.score) return;
  if (options_.session_file.empty())
    return show_refusal(
        tr("This operation is not recorded, so there is no score. Start it from the simulator, or record it "
           "(option record FILE)."));
  operation_->press(false);
  if (score_ == nullptr) {
    score_ = new ScoreDialog(
        options_.host,
        [this](const std::string& file) { return check_save(file, data_tools::OutputKind::any); }, stage_,
        this);
    score_->on_report = [this](const QString& text) { show_message(text); };
  }
  score_->show();
  score_->raise();
  // Wait until the recorder has written the last ticks.
  QTimer::singleShot(std::chrono::milliseconds(200), score_,
                     [this] { score_->judge(QString::fromStdString(options_.session_file), options_.scan); });
}

}  // namespace trephine::view
