// Positions marked in the picture and in slices of MainWindow, and its menu of measurements.
#include <QKeyEvent>
#include <QLabel>
#include <QMenuBar>
#include <QVTKOpenGLNativeWidget.h>
#include <algorithm>
#include <glm/geometric.hpp>

#include "apps/window/qt_localizer.h"
#include "apps/window/qt_window.h"

namespace trephine::view {

using glm::dvec3;

/// Lets the user mark positions, and passes them to `done`. Until then, clicks mark positions and do not
/// drill.
void MainWindow::begin_marking(PositionMarking::Request request,
                               std::function<void(const PositionMarking::Positions&)> done) {
  if (!operation_) return;
  operation_->press(false);
  marking_.begin(std::move(request), std::move(done));
  canvas_->setFocus();
}

/// Marks the position under the cursor.
void MainWindow::mark_picked_point() {
  if (!operation_) return;
  follow_cursor();  // the cursor may have moved since the last frame
  if (const std::optional<dvec3> at = operation_->picked_point())
    marking_.add(*at);
  else
    show_refusal(tr("Point at a position on the bone, or click in a slice."));
}

/// Handles the keys of a marking. Returns false for other keys, and if no marking is active.
bool MainWindow::mark_by_key(const QKeyEvent* event) {
  if (!marking_.is_active()) return false;
  switch (event->key()) {
    case Qt::Key_Space:
      if (!event->isAutoRepeat()) mark_picked_point();
      return true;
    case Qt::Key_Return:
    case Qt::Key_Enter:
      if (!marking_.finish()) show_refusal(tr("Mark more positions first."));
      return true;
    case Qt::Key_Backspace:
      marking_.remove_last();
      return true;
    case Qt::Key_Escape:
      marking_.cancel();
      return true;
    default:
      return false;
  }
}

/// Shows the marked positions, the line to the position under the cursor, and the prompt.
void MainWindow::show_marking() {
  constexpr double k_moved = 0.2;  // mm
  const std::string prompt = marking_.prompt();
  const std::optional<dvec3> next = marking_.is_active() ? operation_->picked_point() : std::nullopt;
  const bool has_moved = next.has_value() != marking_next_.has_value() ||
                         (next && glm::length(*next - *marking_next_) > k_moved);
  if (prompt == marking_prompt_ && !has_moved) return;
  marking_next_ = next;
  viewport()->set_marks(marking_.overlays(next));
  if (prompt == marking_prompt_) return;
  for (std::size_t i = 0; i < PaneGrid::k_panes; ++i) grid_->pane(i)->set_marks(marking_.positions());
  marking_prompt_ = prompt;
  prompt_->setVisible(!prompt.empty());
  prompt_->setText(localized(prompt));
  constexpr int k_border = 8, k_top = 34;  // pixels
  const int text_width =
                prompt_->fontMetrics().horizontalAdvance(prompt_->text()) + 2 * prompt_->margin() + 8,
            width = std::min(text_width, std::max(80, canvas_->width() - 2 * k_border));
  prompt_->resize(width, prompt_->heightForWidth(width));
  prompt_->move((canvas_->width() - width) / 2, k_top);
  prompt_->raise();
}

void MainWindow::build_prompt() {
  prompt_ = new QLabel(canvas_);
  prompt_->setObjectName("marking_prompt");
  prompt_->setAttribute(Qt::WA_TransparentForMouseEvents);
  prompt_->setMargin(8);
  prompt_->setWordWrap(true);
  prompt_->setStyleSheet(
      "background: #12161e; color: #ecedf4; border: 2px solid #f6c944; border-radius: 6px");
  prompt_->hide();
  marking_.cancel();
  marking_prompt_.clear();
}

/// Builds the menu of measurements, if the catalogue has them.
void MainWindow::build_measure_menu() {
  const sim::JobType* measure = nullptr;
  const sim::ValueType* clear = nullptr;
  for (const sim::Module* module :
       options_.catalogue ? options_.catalogue->modules() : std::span<const sim::Module* const>()) {
    for (const sim::JobType* job : module->jobs())
      if (job->parameters->schema->name == "measure") measure = job;
    for (const sim::ValueType* command : module->commands())
      if (command->schema->name == "clear-measures") clear = command;
  }
  if (measure == nullptr || options_.replay) return;
  using Quantity = PositionMarking::Request::Quantity;
  constexpr std::size_t k_any = std::numeric_limits<std::size_t>::max();
  struct Row {
    const char* kind;
    QString text;
    PositionMarking::Request request;
    QKeySequence keys = {};
  };
  const Row rows[] = {
      {"ruler", tr("&Ruler\tM"), {"Ruler", 2, 2}},
      {"angle", tr("&Angle"), {"Angle", 3, 3, Quantity::angle}, QKeySequence("Ctrl+Shift+A")},
      {"tape",
       tr("&Tape along the bone"),
       {"Tape", 2, k_any, Quantity::straight},
       QKeySequence("Ctrl+Shift+T")},
      {"patch", tr("Area of an &outline"), {"Area", 3, k_any, Quantity::outline}},
      {"region", tr("&Values within 5 mm of a position"), {"Values within 5 mm", 1, 1}},
  };
  QMenu* menu = menuBar()->addMenu(tr("&Measure"));
  for (const Row& row : rows) {
    QAction* action = menu->addAction(row.text);
    action->setObjectName(QString("measure_%1").arg(row.kind));
    if (!row.keys.isEmpty()) action->setShortcut(row.keys);
    command_actions_.push_back({action, menu, measure->parameters});
    connect(action, &QAction::triggered, this,
            [this, type = measure->parameters, kind = std::string(row.kind), request = row.request] {
              begin_marking(request, [this, type, kind](const PositionMarking::Positions& positions) {
                sim::Value command = sim::Value::of(*type);
                if (command.set("kind=" + kind)) return;
                // A tape and an outline lie on the shape at their first position.
                const std::size_t item = viewport()->shape_near(positions.front());
                if (command.set("item=" + std::to_string(item))) return;
                for (const sim::Field& field : type->schema->fields)
                  if (field.name == "at") set_positions(command, field, positions);
                if (operation_) operation_->apply(std::move(command));
              });
            });
  }
  if (clear == nullptr) return;
  menu->addSeparator();
  QAction* action = menu->addAction(tr("&Clear the measurements"));
  action->setObjectName("measure_clear");
  command_actions_.push_back({action, menu, clear});
  connect(action, &QAction::triggered, this, [this, clear] {
    if (operation_) operation_->apply(sim::Value::of(*clear));
  });
}

}  // namespace trephine::view
