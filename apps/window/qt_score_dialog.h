// ScoreDialog: findings and points of the operation so far, and its report.
#pragma once

#include <QDialog>
#include <QTemporaryDir>
#include <QTimer>
#include <atomic>
#include <functional>
#include <future>
#include <mutex>

#include "apps/view/view_window.h"
#include "apps/view/window_stage.h"

class QLabel;
class QProgressBar;
class QPushButton;
class QTableWidget;

namespace trephine::view {

/// Judges a copy of the recording on another thread, while the operation continues. Each verdict has a shape
/// and a word, so that it can be identified without its colour.
class ScoreDialog : public QDialog {
  Q_OBJECT

 public:
  /// `check_output`: returns an error if a file cannot be written or is in use. `stage`: stage of the window.
  /// The dialog marks itself as open there while it asks for a file: the window then keeps the operation.
  ScoreDialog(const WindowHost& host, std::function<Status(const std::string& file)> check_output,
              WindowStage& stage, QWidget* parent);
  /// Cancels the work and waits for it.
  ~ScoreDialog() override;

  /// Copies the recording and judges the copy. `scan`: path of the scan, if the session does not contain it.
  void judge(const QString& session, const std::string& scan);
  /// Writes the report of the judged copy.
  void write_report(const QString& page);
  bool is_working() const { return work_.valid(); }
  /// Called with the result of a report that ended while the dialog was closed.
  std::function<void(const QString& text)> on_report = [](const QString&) {};
  /// The findings; empty until they are known. Preliminary while is_working(): without the motion of the
  /// hands.
  const std::optional<sim::Score>& score() const noexcept { return score_; }

 private:
  /// Returns the findings, or an empty score after a report was written.
  using Work = std::function<Result<sim::Score>(const WindowHost::Listener& listener)>;
  void start(const QString& text, Work work);
  void stop();
  void poll();
  void show_findings();
  void ask_for_report();

  WindowHost host_;
  std::function<Status(const std::string&)> check_output_;
  WindowStage& stage_;
  QTemporaryDir folder_;  ///< folder of the copy
  std::string scan_;
  std::shared_ptr<std::atomic<double>> share_;
  std::shared_ptr<std::atomic<bool>> is_cancelled_;
  std::future<Result<sim::Score>> work_;
  bool is_report_ = false;  ///< the last started work writes a report
  QString page_;            ///< path of that report
  std::optional<sim::Score> score_;
  /// Score of the final state, from the thread of the work.
  struct Preliminary {
    std::mutex lock;
    std::optional<sim::Score> score;  ///< guarded by `lock`
  };
  std::shared_ptr<Preliminary> preliminary_;
  QTimer timer_;
  QLabel *points_, *critical_, *status_;
  QProgressBar* bar_;
  QTableWidget *judged_, *reported_;
  QPushButton* report_button_;
};

}  // namespace trephine::view
