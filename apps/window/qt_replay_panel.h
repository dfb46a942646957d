// ReplayPanel: time and speed of a replay, notes of an instructor, and a button to continue the operation.
#pragma once

#include <QDockWidget>
#include <functional>
#include <string>
#include <vector>

#include "apps/view/replay_controller.h"
#include "data-tools/cases/session_notes.h"

class QComboBox;
class QLabel;
class QPushButton;

namespace trephine::view {

class MarkedSlider;

class ReplayPanel : public QDockWidget {
  Q_OBJECT

 public:
  using Notes = std::vector<data_tools::SessionNote>;
  /// `session`: file whose notes are shown and edited; empty: no notes.
  ReplayPanel(const workbench::SessionSummary& summary, double seconds, std::string session, QWidget* parent);

  /// Sets the replay that the panel controls; it must outlive the panel.
  void control(ReplayController& replay) { replay_ = &replay; }
  /// Shows the state of the replay; call in every frame.
  void show_state();
  void show_time(double seconds, bool is_seeking);
  /// Sets the time at which the slider ends, s.
  void set_length(double seconds);
  /// Plays or pauses the replay. At its end, plays it again from the start.
  void toggle_play();
  /// Pauses, and asks for the text of a note at the shown time. If a note is less than half a second away,
  /// that note is edited; an empty text removes it.
  void ask_note();
  /// Notes in the order of their times.
  const Notes& notes() const noexcept { return notes_; }
  /// Returns the notes that are shown at a time, as marks in the picture.
  static sim::Overlays marks_of(const Notes& notes, double seconds);

  std::function<void(const Error&)> on_error = [](const Error&) {};
  std::function<void()> on_notes = [] {};
  /// Enables the button by which the user continues the operation from the shown moment, and sets the
  /// function that the button calls. Null: disables the button, with `reason` as its tool tip.
  void allow_take_over(std::function<void()> take_over, const QString& reason);

 private:
  void show_marks();
  void save_note(double seconds, const std::string& text);

  ReplayController* replay_ = nullptr;
  workbench::SessionSummary summary_;
  std::string session_;
  Notes notes_;
  std::function<void()> take_over_;
  MarkedSlider* slider_;
  QLabel* clock_;
  QComboBox* speed_;
  QPushButton *play_, *note_, *continue_;
};

}  // namespace trephine::view
