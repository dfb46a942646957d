// StepsPanel: the steps of a procedure, the hint of the current step, and buttons for the next steps.
#pragma once

#include <QDockWidget>
#include <QPushButton>
#include <functional>
#include <string>
#include <vector>

#include "apps/view/step_guide.h"

class QLabel;
class QScrollArea;
class QVBoxLayout;

namespace trephine::view {

/// A button whose text wraps at its width.
class WrappingButton : public QPushButton {
  Q_OBJECT

 public:
  explicit WrappingButton(const QString& words, QWidget* parent = nullptr);
  const QString& words() const noexcept { return words_; }

 protected:
  void resizeEvent(QResizeEvent* event) override;
  void changeEvent(QEvent* event) override;

 private:
  void wrap();
  QString words_;
};

/// List of steps, texts of the current step, and a button per next step. In the list, a visited step has a
/// check mark, and the current step has an arrow and bold text.
class StepsPanel : public QDockWidget {
  Q_OBJECT

 public:
  StepsPanel(const volume::SurgicalProcedure& procedure, QWidget* parent);
  /// Shows the state of a guide to the procedure of the constructor. No cost if the state did not change.
  void update_from(const StepGuide& guide);
  std::function<void(const std::string& step)> on_request = [](const std::string&) {};
  std::function<void()> on_score;  ///< null: the last step has no button for the score

 protected:
  void resizeEvent(QResizeEvent* event) override;
  void changeEvent(QEvent* event) override;

 private:
  void build_rows(const volume::SurgicalProcedure& procedure);
  void show_rows(const StepGuide& guide);
  void show_step(const StepGuide& guide);
  void build_buttons(const StepGuide& guide);
  void lay_out();

  struct Row {
    QLabel *mark, *title;
  };
  struct Button {
    WrappingButton* button;
    QLabel* reason;
  };
  std::vector<Row> rows_;
  std::vector<Button> buttons_;
  WrappingButton* score_ = nullptr;   ///< button that shows the score; null: not in the current step
  std::uint64_t shown_revision_ = 0;  ///< 0: nothing is shown
  int shown_step_ = -1;
  QLabel *title_ = nullptr, *hint_ = nullptr, *note_ = nullptr;
  QWidget* note_box_ = nullptr;
  QScrollArea *list_ = nullptr, *details_ = nullptr;
  QVBoxLayout* button_column_ = nullptr;
};

}  // namespace trephine::view
