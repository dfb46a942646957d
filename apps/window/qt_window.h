// MainWindow: the full window: menu, tool panel, picture, panes, status line. Usable without a haptic device.
#pragma once

#include <QMainWindow>
#include <QTimer>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>

#include "apps/view/operation_controller.h"
#include "apps/view/pane_controller.h"
#include "apps/view/position_marking.h"
#include "apps/view/replay_controller.h"
#include "apps/view/view_window.h"
#include "apps/view/window_stage.h"
#include "apps/window/qt_case_panel.h"
#include "apps/window/qt_force_panel.h"
#include "apps/window/qt_notices.h"
#include "apps/window/qt_pane_grid.h"
#include "apps/window/qt_panels.h"
#include "apps/window/qt_replay_panel.h"
#include "apps/window/qt_sound.h"
#include "apps/window/qt_tool_panel.h"
#include "data-tools/files/output_set.h"

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QMenu;
class QProgressBar;
class QPushButton;
class QScrollArea;
class QSlider;
class QVTKOpenGLNativeWidget;

namespace trephine::view {

class ScoreDialog;
class StepsPanel;
class StructurePanel;

/// Shows one operation or one replay at a time. Widget thread only; scans are opened on another thread.
/// Stores only the layout of the panes (WindowOptions::layout_file): no recent files, no folders.
class MainWindow : public QMainWindow {
  Q_OBJECT

 public:
  /// The data that the options borrow must outlive the window.
  MainWindow(std::shared_ptr<const haptics::TouchScene> scene, const WindowOptions& options);
  ~MainWindow() override;

  /// Opens another scan in the background. If this fails, the error is shown and the current operation
  /// continues.
  void open_source(const QString& source);
  /// Continues a recorded session, which is opened in the background.
  void resume_session(const QString& session);
  /// Plays a recorded session in a window of its own.
  void watch_session(const QString& session);
  /// Starts the operation again on the uncut scan, with a further scan to touch. `shape` as in
  /// WindowHost::add_scan.
  void add_scan(const QString& scan, const QString& shape);
  Status check_save(const std::string& file, data_tools::OutputKind kind) const;
  Status save_volume(const QString& path);
  Status save_mesh(const QString& path);
  Status save_session(const QString& path);
  Status save_picture(const QString& path);
  /// Writes the case of the panel into a new folder, with progress.
  Status save_case(const QString& path);
  void scale_text(double factor);

  /// Exactly one of operation() and replay() is not null.
  OperationController* operation() noexcept { return operation_.get(); }
  ReplayController* replay() noexcept { return replay_.get(); }
  /// Makes the replay of this window follow the time and the view of the replay of `leader`. This window
  /// closes when `leader` closes; `leader` must outlive this window.
  void follow(MainWindow& leader);
  QVTKOpenGLNativeWidget* canvas() noexcept { return canvas_; }
  PaneGrid* panes() noexcept { return grid_; }
  PaneController& pane_controller() noexcept { return panes_; }
  bool is_opening() const { return stage_.is_opening(); }
  /// Cancels the opening of a scan at the next opportunity.
  void cancel_opening();
  /// Ends the operation and returns the report of the window.
  WindowReport finish();
  /// Error of the screenshot that the options request; empty: no error.
  const Status& screenshot_error() const noexcept { return screenshot_error_; }

 protected:
  void closeEvent(QCloseEvent* event) override;
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  void keyReleaseEvent(QKeyEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  bool eventFilter(QObject* object, QEvent* event) override;
  bool event(QEvent* event) override;

 private:
  void build_menu();
  void build_command_menu();
  void apply_at_surface_point(const sim::ValueType& type);
  void build_pieces_menu();
  enum class Rows { usual, all };
  /// Asks for the fields of a command in a form that begins with its values, and applies the command.
  /// Rows::all: the form also shows the expert fields.
  void ask_and_apply(sim::Value command, Rows rows = Rows::usual);
  void mark_for(sim::Value command, const sim::Field& field);
  void begin_marking(PositionMarking::Request request,
                     std::function<void(const PositionMarking::Positions&)> done);
  void mark_picked_point();
  bool mark_by_key(const QKeyEvent* event);
  bool explain_disabled(const QKeyEvent* event);
  void show_marking();
  void build_prompt();
  void build_measure_menu();
  QStringList names_of(sim::FieldInfo::Names kind);
  void show_message(const QString& text);
  /// Returns the message that is shown until a new tool is ready.
  static QString preparing_text() { return tr("Preparing the tool ..."); }
  void show_refusal(const QString& reason);
  void follow_cursor();
  void build_panel();
  void build_panes();
  void build_panes_menu();
  void restore_layout();
  void save_layout();
  void show_scan_facts();
  void preview_visible_values();
  void fill_structures(QMenu* menu);
  void show_panes(double elapsed);
  void build_replay_panel();
  void begin_replay(vtkRenderWindow* window);
  void collect_replay_notices();
  void show_replay_state();
  void follow_leader();
  void show_drawing();
  void toggle_force_panel();
  void show_case_panel();
  void mark_for_case(CasePanel::Mark mark);
  void ask_and_save_case();
  void build_history_panel();
  void show_history();
  void ask_and_compare();
  const StepGuide* steps() const;
  void begin_steps();
  void close_unusable_xray_pane();
  std::optional<glm::dvec3> work_position() const;
  void show_steps();
  void allow_everything();
  void set_xray_refusal(const QString& reason);
  void go_to_next_step();
  void show_score();
  void fit_panel();
  void begin(std::shared_ptr<const haptics::TouchScene> scene);
  void tick();
  void adopt_opened();
  void start_opening(std::function<Result<OpenedScene>(const WindowHost::Listener&)> open);
  /// Returns the current state for a file; later cuts do not change it.
  std::shared_ptr<const volume::Version> frozen_version();
  void show_state();
  /// File of the current session; empty if there are no strokes or no recording.
  QString saved_session() const;
  QString ask_session(const QString& title);
  void collect_replays();
  /// Adds the assumptions about the scan to the log, and shows the assumption about its shape in the status
  /// line.
  void show_assumptions();
  void show_notices();
  void press_deeper(int steps);
  void undo();
  void show_names(LabelLayer::Names names);
  void toggle_names();
  /// Changes the presentation of the picture.
  void change_display(const std::function<void(DisplayMode&)>& change);
  void tilt(double right, double up);
  void turn(double right, double up);
  bool move_by_key(const QKeyEvent* event);
  void report_disconnected_parts();
  void preview_shape();
  void use_shape();
  /// Returns true if the operation may start again on the uncut scan. Asks the user if something was cut.
  bool may_restart();
  void forget_preview();
  void set_clip();
  void explain_section_clip();
  void show_error(const Error& error);
  void ask_path_and_save(const QString& title, const char* suggestion, const QString& filter,
                         Status (MainWindow::*save)(const QString&));
  std::shared_ptr<const volume::Version> version() const;
  Viewport* viewport();
  /// Returns true if the canvas can be drawn into.
  bool is_drawable() const;
  void set_from_back(bool is_from_back);
  /// Turns the picture to a side. Shows a message if the panes then show the patient's left on the other side
  /// than the picture does.
  void look_from(char side);

  WindowOptions options_;
  std::shared_ptr<const haptics::TouchScene> scene_;
  std::shared_ptr<void> owner_;                   ///< owns the data that an opened session borrows
  std::unique_ptr<sim::SessionWriter> recorder_;  ///< recorder of a scan opened from this window
  QVTKOpenGLNativeWidget* canvas_ = nullptr;
  std::unique_ptr<OperationController> operation_;
  std::unique_ptr<ReplayController> replay_;
  PaneController panes_{PaneGrid::k_panes};
  PaneGrid* grid_ = nullptr;
  std::optional<PaneController::Clip> followed_clip_;
  PositionMarking marking_;
  std::string marking_prompt_;              ///< text that prompt_ shows
  std::optional<glm::dvec3> marking_next_;  ///< position under the cursor, where the shown line ends
  QLabel* prompt_ = nullptr;
  /// A scan that is being opened on another thread.
  struct Opening {
    std::shared_ptr<std::atomic<double>> share = std::make_shared<std::atomic<double>>(0);
    std::shared_ptr<std::atomic<bool>> is_cancelled = std::make_shared<std::atomic<bool>>(false);
    /// Assumptions about the scan; read when the result is available.
    std::shared_ptr<std::vector<std::string>> notices = std::make_shared<std::vector<std::string>>();
    std::future<Result<OpenedScene>> result;
    WindowHost::Listener listener() const;
  };
  Opening opening_;
  /// A session that is played in another window. The destructor waits for the end of its process.
  struct Replay {
    std::shared_ptr<std::atomic<bool>> is_stopped = std::make_shared<std::atomic<bool>>(false);
    std::future<Status> result;
    Replay() = default;
    Replay(Replay&&) = default;
    Replay& operator=(Replay&&) = default;
    ~Replay() {
      if (is_stopped) *is_stopped = true;
    }
  };
  std::vector<Replay> replays_;
  WindowStage stage_;
  DrillSound sound_;
  WindowReport report_;
  Status screenshot_error_;
  bool is_quitting_ = false;          ///< the menu closes the window
  bool is_ended_by_program_ = false;  ///< a signal or a time limit closes the window, without a dialog
  bool has_first_frame_ = false, is_sound_on_ = false, is_previewing_ = false;
  /// Result of the search for disconnected parts: the searched scene, and true if a part other than the
  /// largest is large.
  std::future<std::pair<std::shared_ptr<const haptics::TouchScene>, bool>> parts_;
  bool has_checked_parts_ = false;
  ReplayPanel* replay_panel_ = nullptr;  ///< null without a replay
  ForcePanel* force_panel_ = nullptr;    ///< null without a replay
  std::vector<glm::dvec3> shown_note_marks_;
  MainWindow* leader_ = nullptr;        ///< window whose replay this replay follows; null: no such window
  std::uint64_t leader_view_time_ = 0;  ///< modification time of the leader's camera when it was copied last
  CasePanel* case_panel_ = nullptr;     ///< null until it is requested
  Notices replay_notices_;              ///< events and notes of a replay, by its time
  std::optional<QPoint> cursor_;        ///< last position of the cursor on the canvas
  QSize cursor_canvas_;                 ///< size of the canvas at that position
  std::chrono::steady_clock::time_point opened_at_, last_tick_, servo_shown_at_;
  QTimer timer_, preview_timer_;

  ForceBar* force_bar_ = nullptr;
  QLabel *removed_ = nullptr, *servo_ = nullptr, *state_text_ = nullptr, *notice_ = nullptr,
         *history_text_ = nullptr;
  QScrollArea* panel_ = nullptr;
  ToolPanel* tool_panel_ = nullptr;
  FoldButton* structure_fold_ = nullptr;
  StructurePanel* structures_ = nullptr;
  int width_without_forces_ = 0;  ///< pixels, of the panel of the steps
  std::size_t tool_hand_ = 0;     ///< hand whose tool the panel shows
  sim::Value shown_tool_;
  QDoubleSpinBox *low_ = nullptr, *high_ = nullptr;
  QSlider *depth_ = nullptr, *clip_share_ = nullptr, *history_ = nullptr;
  QCheckBox* largest_ = nullptr;
  QComboBox *shape_of_ = nullptr, *clip_ = nullptr;
  QPushButton *undo_ = nullptr, *redo_ = nullptr, *use_shape_ = nullptr, *reset_shape_ = nullptr;
  QProgressBar* opening_bar_ = nullptr;
  QPushButton* cancel_ = nullptr;
  QAction *from_back_ = nullptr, *undo_action_ = nullptr, *redo_action_ = nullptr;
  /// Action that sends a command of a module. A step of a procedure can forbid the command.
  struct CommandAction {
    QAction* action;
    QMenu* menu;
    const sim::ValueType* type;
  };
  std::vector<CommandAction> command_actions_;
  QAction* next_step_action_ = nullptr;  ///< null in a replay
  StepsPanel* steps_panel_ = nullptr;    ///< null: no procedure
  int shown_step_ = -1;
  bool is_next_step_requested_ = false;  ///< go_to_next_step() runs again in the next frame
  ScoreDialog* score_ = nullptr;         ///< null until it is requested
  HelpOverlay* help_ = nullptr;
  NoticeLabel* tool_notice_ = nullptr;
  QLabel* drawing_ = nullptr;    ///< progress of drawing
  double fitted_text_size_ = 0;  ///< points, to which the panel is fitted
  int tool_panel_width_ = 0;     ///< pixels, for the widest instrument; 0: not known
  bool has_been_whole_ = false;  ///< the anatomy was drawn once
  workbench::Clock::time_point was_whole_at_ = {};
  EventLog* log_ = nullptr;
};

/// Sets a dark palette with high contrast, so that bone appears bright.
void apply_look();
/// Returns the path of the layout file in the folder of the user's settings; empty if there is no such
/// folder.
std::string default_layout_file();

}  // namespace trephine::view
