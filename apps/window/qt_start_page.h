// StartPage: tiles of operations, the user's sessions, and buttons to open the user's own scans.
#pragma once

#include <QWidget>
#include <functional>

#include "apps/view/start_page.h"

class QComboBox;
class QLabel;
class QListWidget;
class QPushButton;

namespace trephine::view {

class StartPage : public QWidget {
  Q_OBJECT

 public:
  explicit StartPage(const StartPageOptions& options, QWidget* parent = nullptr);
  /// Called after a choice, when the heading names the operation that is being opened.
  std::function<void()> on_choice = [] {};
  /// The choice; StartChoice::Kind::none before it.
  const StartChoice& choice() const noexcept { return choice_; }
  /// Chooses the scan at a path, with the selected procedure. An empty path has no effect.
  void choose_scan(const QString& path);
  /// Chooses the selected session. Asks for its scan if the file does not contain it.
  void choose_session(StartChoice::Kind kind);

 protected:
  void keyPressEvent(QKeyEvent* event) override;

 private:
  QWidget* make_tile(const StartTile& tile);
  QWidget* make_sessions();
  QWidget* make_own_scan();
  /// Fills the page, in place of its previous contents.
  void fill();
  void scale_text(double factor);
  /// `title`: title of the chosen operation, for the heading.
  void choose(StartChoice choice, const QString& title);
  /// Returns the scan that the user selects for a session; empty if cancelled.
  QString ask_scan(const StartSession& session);

  const StartPageOptions options_;
  StartChoice choice_;
  QWidget* whole_ = nullptr;
  QLabel* heading_ = nullptr;
  QListWidget* sessions_ = nullptr;
  QComboBox* procedure_ = nullptr;
  QPushButton *resume_ = nullptr, *replay_ = nullptr;
};

}  // namespace trephine::view
