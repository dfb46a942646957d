// The full window: menu, tool panel, picture, status line. Made for a person without a device.
#pragma once

#include <QMainWindow>
#include <QTimer>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>

#include "apps/view/operation_controller.h"
#include "apps/view/pane_controller.h"
#include "apps/view/qt_notices.h"
#include "apps/view/qt_pane_grid.h"
#include "apps/view/qt_panels.h"
#include "apps/view/qt_sound.h"
#include "apps/view/qt_tool_panel.h"
#include "apps/view/replay_controller.h"
#include "apps/view/view_window.h"
#include "apps/view/window_stage.h"
#include "data-tools/output_set.h"

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QProgressBar;
class QPushButton;
class QScrollArea;
class QSlider;
class QVTKOpenGLNativeWidget;

namespace trephine::view {

/// One operation or one replay at a time. Everything on the thread of the widgets; only opening a scan waits
/// on another. Remembers from one run to the next how panes were arranged, where options say so, and nothing
/// else: no recent files, no folders.
class MainWindow : public QMainWindow {
  Q_OBJECT

 public:
  /// Borrows what the options borrow.
  MainWindow(std::shared_ptr<const haptics::TouchScene> scene, const WindowOptions& options);
  ~MainWindow() override;

  /// Opens another scan in the background; errors are shown, the old operation stays then.
  void open_source(const QString& source);
  /// Continues a recorded session, in the background too.
  void resume_session(const QString& session);
  volume::Status check_save(const std::string& file, data_tools::OutputKind kind) const;
  volume::Status save_volume(const QString& path);
  volume::Status save_mesh(const QString& path);
  volume::Status save_session(const QString& path);
  volume::Status save_picture(const QString& path);
  void scale_text(double factor);

  /// Null in a replay, and the other way round.
  OperationController* operation() noexcept { return operation_.get(); }
  ReplayController* replay() noexcept { return replay_.get(); }
  QVTKOpenGLNativeWidget* canvas() noexcept { return canvas_; }
  PaneGrid* panes() noexcept { return grid_; }
  PaneController& pane_controller() noexcept { return panes_; }
  bool is_opening() const { return stage_.is_opening(); }
  /// Cancels the opening of a scan, as soon as its reading can be.
  void cancel_opening();
  /// Ends the operation and says what happened in the window.
  WindowReport finish();
  /// Why the picture that was asked for at the end was not written.
  const volume::Status& screenshot_error() const noexcept { return screenshot_error_; }

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
  void apply_where_it_touches(const sim::ValueType& type);
  void build_pieces_menu();
  void ask_and_apply(const sim::ValueType& type);
  QStringList names_of(sim::FieldInfo::Names kind);
  void say(const QString& text);
  void build_panel();
  void build_panes();
  void build_panes_menu();
  void restore_layout();
  void remember_layout();
  void show_scan_facts();
  void touch_what_is_drawn();
  void fill_structures(QMenu* menu);
  void show_panes(double elapsed);
  void build_replay_panel();
  void build_history_panel();
  void show_history();
  void ask_and_compare();
  void fit_panel();
  void begin(std::shared_ptr<const haptics::TouchScene> scene);
  void tick();
  void take_opened();
  void open_by(std::function<volume::Result<OpenedScene>(const WindowHost::Listener&)> open);
  /// For files: of this moment, whatever is cut meanwhile.
  std::shared_ptr<const volume::Version> frozen();
  void show_state();
  /// File of the session that was recorded until now; empty where nothing was done or recorded.
  QString saved_as() const;
  void show_notices();
  void press_deeper(int steps);
  void toggle_names();
  void tilt(double right, double up);
  void turn(double right, double up);
  bool move_by_key(const QKeyEvent* event);
  void offer_largest();
  void preview_shape();
  void use_shape();
  void forget_preview();
  void set_clip();
  void show_error(const volume::Error& error);
  void ask_path_and_save(const char* title, const char* suggestion, const char* filter,
                         volume::Status (MainWindow::*save)(const QString&));
  std::shared_ptr<const volume::Version> version() const;
  Viewport* viewport();
  /// Can the canvas be drawn into yet?
  bool is_drawable() const;
  void set_from_back(bool is_from_back);

  WindowOptions options_;
  std::shared_ptr<const haptics::TouchScene> scene_;
  std::shared_ptr<void> owner_;                   ///< of what an opened session borrows
  std::unique_ptr<sim::SessionWriter> recorder_;  ///< of a scan opened from here
  QVTKOpenGLNativeWidget* canvas_ = nullptr;
  std::unique_ptr<OperationController> operation_;
  std::unique_ptr<ReplayController> replay_;
  PaneController panes_{PaneGrid::k_panes};
  PaneGrid* grid_ = nullptr;
  std::optional<PaneController::Clip> followed_clip_;
  /// A scan that is being opened, on a thread of its own.
  struct Opening {
    std::shared_ptr<std::atomic<double>> share = std::make_shared<std::atomic<double>>(0);
    std::shared_ptr<std::atomic<bool>> is_cancelled = std::make_shared<std::atomic<bool>>(false);
    /// Assumptions that were made; read when the result is there.
    std::shared_ptr<std::vector<std::string>> notices = std::make_shared<std::vector<std::string>>();
    std::future<volume::Result<OpenedScene>> result;
    WindowHost::Listener listener() const;
  };
  Opening opening_;
  WindowStage stage_;
  DrillSound sound_;
  WindowReport report_;
  volume::Status screenshot_error_;
  bool is_quitting_ = false;          ///< by the menu
  bool is_ended_by_program_ = false;  ///< by a signal or a time that is up: without a dialog
  double first_font_ = 0;             ///< points; 0: text has the size with which it began
  bool has_first_frame_ = false, is_sound_on_ = false, is_previewing_ = false;
  /// The scene that was looked at, and whether another part of its shape is large.
  std::future<std::pair<std::shared_ptr<const haptics::TouchScene>, bool>> parts_;
  bool has_looked_for_parts_ = false;
  Notices replayed_;              ///< events of a replay, by its time
  std::optional<QPoint> cursor_;  ///< on the canvas, when it moved last
  std::chrono::steady_clock::time_point opened_at_, last_tick_, servo_shown_at_;
  QTimer timer_, preview_timer_;

  ForceBar* force_bar_ = nullptr;
  QLabel *removed_ = nullptr, *servo_ = nullptr, *fault_ = nullptr, *notice_ = nullptr,
         *session_time_ = nullptr, *history_text_ = nullptr;
  QScrollArea* panel_ = nullptr;
  ToolPanel* tool_ = nullptr;
  sim::Value shown_tool_;
  QDoubleSpinBox *low_ = nullptr, *high_ = nullptr;
  QSlider *depth_ = nullptr, *clip_share_ = nullptr, *session_slider_ = nullptr, *history_ = nullptr;
  QCheckBox* largest_ = nullptr;
  QComboBox *shape_of_ = nullptr, *clip_ = nullptr, *speed_ = nullptr;
  QPushButton *undo_ = nullptr, *redo_ = nullptr, *use_shape_ = nullptr, *keep_shape_ = nullptr,
              *play_ = nullptr;
  QProgressBar* opening_bar_ = nullptr;
  QPushButton* cancel_ = nullptr;
  QAction *from_back_ = nullptr, *undo_action_ = nullptr, *redo_action_ = nullptr;
  HelpOverlay* help_ = nullptr;
  NoticeLabel* at_tool_ = nullptr;
  EventLog* log_ = nullptr;
};

/// A dark palette that leaves the light to the bone, and keeps its contrast for every kind of sight.
void apply_look();
/// Folder of the user's settings; empty where there is no such place.
std::string default_layout_file();

}  // namespace trephine::view
