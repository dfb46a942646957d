#include "apps/window/qt_case_panel.h"

#include <QAction>
#include <QComboBox>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QInputDialog>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QLocale>
#include <QPushButton>
#include <QScrollArea>
#include <QSignalBlocker>
#include <QTableWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/window/qt_localizer.h"
#include "apps/window/qt_text.h"
#include "apps/workbench/procedure_names.h"
#include "apps/workbench/text.h"
#include "data-tools/cases/procedure_file.h"
#include "volume/scan/bone_labels.h"

namespace trephine::view {

namespace {

enum StructureColumn { structure_name, is_forbidden, is_target, structure_columns };
enum LimitColumn { finding, full_at, zero_at, weight, limit_columns };

QTableWidget* make_table(const char* name, const QStringList& headers) {
  auto* table = new QTableWidget(0, headers.size());
  table->setObjectName(name);
  table->setHorizontalHeaderLabels(headers);
  table->verticalHeader()->hide();
  table->setSelectionMode(QAbstractItemView::NoSelection);
  table->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
  table->horizontalHeader()->setSectionResizeMode(0, QHeaderView::Stretch);
  // Draw a border around check boxes: without it, unchecked boxes are hardly visible in the style of the
  // window.
  table->setStyleSheet(
      "QTableWidget::indicator { width: 12px; height: 12px; border: 1px solid #9aa3b2; }"
      "QTableWidget::indicator:checked { background: #6fa8dc; }");
  return table;
}

/// Data of entries in the list of procedures: steps of a file, and the action that opens one.
constexpr const char *k_own = "own procedure", *k_file = "procedure file";

/// Sets the height so that all rows are visible, up to eight; a longer table is scrolled.
void fit_height(QTableWidget* table) {
  constexpr int k_most = 8;  // rows
  const int row = table->rowCount() > 0 ? table->rowHeight(0) : table->fontMetrics().height();
  table->setFixedHeight(table->horizontalHeader()->sizeHint().height() +
                        std::clamp(table->rowCount(), 1, k_most) * row + 4);
}

QTableWidgetItem* check_box(bool is_checked) {
  auto* item = new QTableWidgetItem;
  item->setFlags(Qt::ItemIsEnabled | Qt::ItemIsUserCheckable);
  item->setCheckState(is_checked ? Qt::Checked : Qt::Unchecked);
  return item;
}

/// Returns a name that no object of a list has: "trajectory 2".
template <class List>
std::string new_name(const List& list, const std::string& kind) {
  for (std::size_t i = 1;; ++i) {
    const std::string name = kind + " " + std::to_string(i);
    if (std::none_of(list.begin(), list.end(), [&](const auto& one) { return one.name == name; }))
      return name;
  }
}

}  // namespace

CasePanel::CasePanel(const haptics::TouchScene& scene, const volume::SurgicalPlan* plan,
                     const std::vector<std::string>& forbidden,
                     const std::vector<data_tools::CaseModel>& models, QWidget* parent)
    : QDockWidget(tr("Make a case"), parent),
      name_(new QLineEdit),
      procedure_(new QComboBox),
      structures_(make_table("case_structures", {tr("structure"), tr("do not enter"), tr("target")})),
      limits_(make_table("case_limits", {tr("finding"), tr("all points at"), tr("none at"), tr("points")})),
      marks_(new QListWidget) {
  setObjectName("case_panel");
  if (plan != nullptr) request_.plan = *plan;
  request_.models = models;
  name_->setObjectName("case_name");
  name_->setPlaceholderText(tr("not the name of a patient"));
  procedure_->setObjectName("case_procedure");
  procedure_->addItem(tr("No procedure: free practice"), QString());
  for (const data_tools::ShippedProcedure& shipped : data_tools::shipped_procedures()) {
    const std::string name(shipped.name);
    const auto file = data_tools::shipped_procedure(name);
    procedure_->addItem(
        localized(file && !file.value().procedure.title.empty() ? file.value().procedure.title : name),
        text_of(name));
  }
  if (const auto& current = request_.plan.procedure;
      !current.steps.empty() && procedure_->findData(text_of(current.name)) < 0) {
    own_procedure_ = current;
    procedure_->addItem(localized(current.title), k_own);
  }
  procedure_->addItem(tr("Steps of a file ..."), k_file);
  shown_procedure_ =
      std::max(0, own_procedure_.steps.empty() ? procedure_->findData(text_of(request_.plan.procedure.name))
                                               : procedure_->findData(k_own));
  procedure_->setCurrentIndex(shown_procedure_);
  marks_->setObjectName("case_marks");
  marks_->setFixedHeight(9 * marks_->fontMetrics().height() + 8);

  const volume::Volume& scan = *scene.base;
  for (std::size_t label = 1; label < scan.label_names.size(); ++label) {
    const std::string& name = scan.label_names[label];
    if (name.empty() || volume::is_bone_name(name)) continue;
    const int row = structures_->rowCount();
    structures_->insertRow(row);
    auto* item = new QTableWidgetItem(localized(workbench::words_of(name)));
    item->setFlags(Qt::ItemIsEnabled);
    item->setData(Qt::UserRole, text_of(name));
    structures_->setItem(row, structure_name, item);
    structures_->setItem(row, is_forbidden,
                         check_box(std::count(forbidden.begin(), forbidden.end(), name) > 0));
    const auto& targets = request_.plan.targets;
    structures_->setItem(row, is_target,
                         check_box(std::any_of(targets.begin(), targets.end(),
                                               [&](const auto& target) { return target.label == name; })));
  }
  fit_height(structures_);

  auto* content = new QWidget;
  auto* column = new QVBoxLayout(content);
  auto* form = new QFormLayout;
  form->addRow(tr("Name"), name_);
  form->addRow(tr("Procedure"), procedure_);
  column->addLayout(form);
  column->addWidget(
      new QLabel(structures_->rowCount() > 0
                     ? tr("Structures of the scan's labels")
                     : tr("This scan has no labels: no structure can be forbidden or a target.")));
  structures_->setVisible(structures_->rowCount() > 0);
  column->addWidget(structures_);
  column->addWidget(new QLabel(tr("Plan (double click: rename; Delete: remove)")));
  column->addWidget(marks_);
  auto* row = new QHBoxLayout;
  const auto add_button = [&](const char* id, const QString& words, const QString& tip, auto on_click) {
    auto* button = new QPushButton(words);
    button->setObjectName(id);
    button->setToolTip(tip);
    button->setFocusPolicy(Qt::NoFocus);
    connect(button, &QPushButton::clicked, this, on_click);
    row->addWidget(button);
  };
  add_button("mark_trajectory", tr("Trajectory"), tr("Mark entry and target, in the picture or in slices"),
             [this] { on_mark(Mark::trajectory); });
  add_button("mark_landmark", tr("Landmark"), tr("Mark one position"), [this] { on_mark(Mark::landmark); });
  add_button("mark_outline", tr("Outline"), tr("Mark three or more positions around an opening, then Enter"),
             [this] { on_mark(Mark::outline); });
  column->addLayout(row);
  column->addWidget(new QLabel(tr("Limits of the score")));
  column->addWidget(limits_);
  row = new QHBoxLayout;
  row->addStretch(1);
  add_button("save_case", tr("Save the case ..."),
             tr("Write the case into a new folder, which can be copied to others"), [this] { on_save(); });
  column->addLayout(row);
  column->addStretch(1);
  auto* area = new QScrollArea;
  area->setWidget(content);
  area->setWidgetResizable(true);
  area->setMinimumWidth(content->minimumSizeHint().width() + 24);
  setWidget(area);
  fill_marks();
  fill_limits();
  connect(procedure_, QOverload<int>::of(&QComboBox::activated), this,
          [this](int index) { choose_procedure(index); });
  connect(limits_, &QTableWidget::itemChanged, this, [this](QTableWidgetItem* item) { check_number(item); });
  connect(marks_, &QListWidget::itemDoubleClicked, this, [this] { rename_mark(); });
  auto* remove = new QAction(tr("Remove"), this);
  remove->setShortcut(QKeySequence::Delete);
  remove->setShortcutContext(Qt::WidgetShortcut);
  marks_->addAction(remove);
  marks_->setContextMenuPolicy(Qt::ActionsContextMenu);
  connect(remove, &QAction::triggered, this, [this] { remove_mark(); });
}

void CasePanel::choose_procedure(int index) {
  const QString choice = procedure_->itemData(index).toString();
  if (choice == k_file) return open_procedure();
  shown_procedure_ = index;
  const std::string name = choice.toStdString();
  request_.plan.procedure = choice == k_own ? own_procedure_ : volume::SurgicalProcedure();
  if (auto file = data_tools::shipped_procedure(name)) request_.plan.procedure = file.value().procedure;
  request_.plan.score.clear();  // without own limits, the table shows those of the procedure
  fill_limits();
}

/// Opens a procedure with own steps, which becomes an entry of the list. After an error the previous choice
/// remains.
void CasePanel::open_procedure() {
  const QString path = on_ask_procedure();
  const auto file = path.isEmpty() ? Result<data_tools::ProcedureFile>(Error{})
                                   : workbench::open_known_procedure(path.toStdString());
  if (!file) {
    procedure_->setCurrentIndex(shown_procedure_);
    if (!path.isEmpty()) on_refusal(text_of(file.error().message()));
    return;
  }
  own_procedure_ = file.value().procedure;
  const QString title = text_of(own_procedure_.title.empty() ? own_procedure_.name : own_procedure_.title);
  int index = procedure_->findData(k_own);
  if (index < 0) procedure_->insertItem(index = procedure_->findData(k_file), title, k_own);
  procedure_->setItemText(index, title);
  procedure_->setCurrentIndex(index);
  choose_procedure(index);
}

void CasePanel::fill_marks() {
  rows_.clear();
  marks_->clear();
  const volume::SurgicalPlan& plan = request_.plan;
  const auto add_row = [&](Mark mark, std::size_t index, const QString& text) {
    rows_.push_back({mark, index});
    marks_->addItem(text);
  };
  for (std::size_t i = 0; i < plan.trajectories.size(); ++i) {
    const volume::PlannedTrajectory& t = plan.trajectories[i];
    add_row(Mark::trajectory, i,
            tr("%1: trajectory, %L2 mm")
                .arg(text_of(t.name))
                .arg(glm::distance(t.entry_world, t.target_world), 0, 'f', 1));
  }
  for (std::size_t i = 0; i < plan.landmarks.size(); ++i)
    add_row(Mark::landmark, i, tr("%1: landmark").arg(text_of(plan.landmarks[i].name)));
  for (std::size_t i = 0; i < plan.outlines.size(); ++i)
    add_row(Mark::outline, i,
            tr("%1: outline of %2 positions")
                .arg(text_of(plan.outlines[i].name))
                .arg(plan.outlines[i].points_world.size()));
}

/// Stores the number of a cell. If the text of the cell is not a finite number, restores the previous number.
/// A decimal comma is read as a decimal point.
void CasePanel::check_number(QTableWidgetItem* item) {
  if (item->column() == finding) return;
  bool is_number = false;
  const double value = QLocale::c().toDouble(item->text().trimmed().replace(',', '.'), &is_number);
  const QSignalBlocker blocker(limits_);
  if (is_number && std::isfinite(value)) item->setData(Qt::UserRole, value);
  item->setText(QString::number(item->data(Qt::UserRole).toDouble(), 'g', 10));
  if (!is_number) on_refusal(tr("This is not a number: the previous value remains."));
}

void CasePanel::fill_limits() {
  const QSignalBlocker blocker(limits_);
  const std::vector<volume::ScoreLimit> limits = volume::score_limits(request_.plan);
  limits_->setRowCount(static_cast<int>(limits.size()));
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const int row = static_cast<int>(i);
    auto* item = new QTableWidgetItem(localized(workbench::words_of(limits[i].finding)));
    item->setFlags(Qt::ItemIsEnabled);
    item->setData(Qt::UserRole, text_of(limits[i].finding));
    item->setToolTip(item->text());
    limits_->setItem(row, finding, item);
    const double values[] = {limits[i].full_at, limits[i].zero_at, limits[i].weight};
    for (int column = full_at; column < limit_columns; ++column) {
      const double value = values[column - full_at];
      auto* cell = new QTableWidgetItem(QString::number(value, 'g', 10));
      cell->setData(Qt::UserRole, value);
      limits_->setItem(row, column, cell);
    }
  }
  fit_height(limits_);
}

std::string* CasePanel::name_of(const Row& row) {
  volume::SurgicalPlan& plan = request_.plan;
  return row.mark == Mark::trajectory ? &plan.trajectories[row.index].name
         : row.mark == Mark::landmark ? &plan.landmarks[row.index].name
                                      : &plan.outlines[row.index].name;
}

void CasePanel::rename_mark() {
  const int row = marks_->currentRow();
  if (row < 0) return;
  std::string* name = name_of(rows_[static_cast<std::size_t>(row)]);
  bool is_accepted = false;
  const QString text = QInputDialog::getText(this, tr("Rename"), tr("Name, such as \"L4 left pedicle\":"),
                                             QLineEdit::Normal, text_of(*name), &is_accepted);
  if (!is_accepted || text.trimmed().isEmpty()) return;
  *name = text.trimmed().toStdString();
  fill_marks();
  on_change();
}

void CasePanel::remove_mark() {
  const int row = marks_->currentRow();
  if (row < 0) return;
  const Row one = rows_[static_cast<std::size_t>(row)];
  const auto at = static_cast<std::ptrdiff_t>(one.index);
  volume::SurgicalPlan& plan = request_.plan;
  if (one.mark == Mark::trajectory) plan.trajectories.erase(plan.trajectories.begin() + at);
  if (one.mark == Mark::landmark) plan.landmarks.erase(plan.landmarks.begin() + at);
  if (one.mark == Mark::outline) plan.outlines.erase(plan.outlines.begin() + at);
  fill_marks();
  on_change();
}

void CasePanel::add(Mark mark, const std::vector<glm::dvec3>& positions) {
  volume::SurgicalPlan& plan = request_.plan;
  if (mark == Mark::trajectory && positions.size() >= 2)
    plan.trajectories.push_back({new_name(plan.trajectories, "trajectory"), positions[0], positions[1]});
  if (mark == Mark::landmark && !positions.empty())
    plan.landmarks.push_back({new_name(plan.landmarks, "landmark"), positions[0]});
  if (mark == Mark::outline && positions.size() >= 3)
    plan.outlines.push_back({new_name(plan.outlines, "outline"), positions});
  fill_marks();
  for (std::size_t i = 0; i < rows_.size(); ++i)  // the new mark is the last one of its kind
    if (rows_[i].mark == mark) marks_->setCurrentRow(static_cast<int>(i));
  on_change();
}

const workbench::CaseRequest& CasePanel::request() {
  request_.name = name_->text().trimmed().toStdString();
  request_.forbidden.clear();
  request_.plan.targets.clear();
  for (int row = 0; row < structures_->rowCount(); ++row) {
    const std::string name =
        structures_->item(row, structure_name)->data(Qt::UserRole).toString().toStdString();
    if (structures_->item(row, is_forbidden)->checkState() == Qt::Checked) request_.forbidden.push_back(name);
    if (structures_->item(row, is_target)->checkState() == Qt::Checked)
      request_.plan.targets.push_back({workbench::words_of(name), name});
  }
  request_.plan.score.clear();
  for (int row = 0; row < limits_->rowCount(); ++row)
    request_.plan.score.push_back({limits_->item(row, finding)->data(Qt::UserRole).toString().toStdString(),
                                   limits_->item(row, full_at)->data(Qt::UserRole).toDouble(),
                                   limits_->item(row, zero_at)->data(Qt::UserRole).toDouble(),
                                   limits_->item(row, weight)->data(Qt::UserRole).toDouble()});
  return request_;
}

}  // namespace trephine::view
