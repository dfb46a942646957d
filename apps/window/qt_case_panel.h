// CasePanel: panel to make a case of the open scan: name, procedure, forbidden structures, targets, marks,
// limits.
#pragma once

#include <QDockWidget>
#include <functional>

#include "apps/workbench/case_maker.h"

class QComboBox;
class QLabel;
class QLineEdit;
class QListWidget;
class QTableWidget;
class QTableWidgetItem;

namespace trephine::view {

/// The user enters what a case contains, and marks positions in the picture and in slices. Widget thread
/// only.
class CasePanel : public QDockWidget {
  Q_OBJECT

 public:
  enum class Mark { trajectory, landmark, outline };

  /// `plan`, `forbidden`: plan and names of the forbidden structures of the open scan, which are the initial
  /// values of the case. Null: no plan. `models`: of an open case, which the new case copies.
  CasePanel(const haptics::TouchScene& scene, const volume::SurgicalPlan* plan,
            const std::vector<std::string>& forbidden, const std::vector<data_tools::CaseModel>& models,
            QWidget* parent);
  /// Adds a mark at positions (world, mm): entry and target of a trajectory, the position of a landmark, or
  /// the positions of an outline. Too few positions add no mark.
  void add(Mark mark, const std::vector<glm::dvec3>& positions);
  /// Returns the case with the current entries of the panel. The entries may be incomplete.
  const workbench::CaseRequest& request();

  /// The user requested a mark: the window must ask for its positions, and pass them to add().
  std::function<void(Mark)> on_mark = [](Mark) {};
  /// Asks for the file of a procedure; returns an empty path if the user cancels.
  std::function<QString()> on_ask_procedure = [] { return QString(); };
  std::function<void()> on_save = [] {};
  std::function<void(const QString& reason)> on_refusal = [](const QString&) {};
  /// The marks changed.
  std::function<void()> on_change = [] {};

 private:
  void choose_procedure(int index);
  void open_procedure();
  void fill_marks();
  void fill_limits();
  void check_number(QTableWidgetItem* item);
  void rename_mark();
  void remove_mark();
  /// A mark in the order of the list: its kind, and its index in the list of that kind.
  struct Row {
    Mark mark;
    std::size_t index;
  };
  std::string* name_of(const Row& row);

  workbench::CaseRequest request_;
  volume::SurgicalProcedure own_procedure_;  ///< of a file
  int shown_procedure_ = 0;                  ///< index in the list of procedures
  std::vector<Row> rows_;
  QLineEdit* name_;
  QComboBox* procedure_;
  QTableWidget *structures_, *limits_;
  QListWidget* marks_;
};

}  // namespace trephine::view
