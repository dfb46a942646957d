// CasePanel: makes a case of the open scan: name, procedure, forbidden structures, targets, marks and limits.
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

  /// `plan`, `forbidden`: of the open scan, with which the case begins; null: no plan.
  CasePanel(const haptics::TouchScene& scene, const volume::SurgicalPlan* plan,
            const std::vector<std::string>& forbidden, QWidget* parent);
  /// Adds what the user marked: entry and target, one position, or an outline.
  void add(Mark mark, const std::vector<glm::dvec3>& positions);
  /// Returns the case so far.
  const workbench::CaseRequest& request();

  /// Requests the positions of a mark.
  std::function<void(Mark)> on_mark = [](Mark) {};
  std::function<void()> on_save = [] {};
  std::function<void(const QString& reason)> on_refusal = [](const QString&) {};
  /// The marks changed.
  std::function<void()> on_change = [] {};

 private:
  void choose_procedure(int index);
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
  std::vector<Row> rows_;
  QLineEdit* name_;
  QComboBox* procedure_;
  QTableWidget *structures_, *limits_;
  QListWidget* marks_;
};

}  // namespace trephine::view
