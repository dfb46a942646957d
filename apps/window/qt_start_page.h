// StartPage: tiles of cases, the user's sessions, and buttons for own scans.
#pragma once

#include <QWidget>

#include "apps/view/start_page.h"

class QComboBox;
class QListWidget;
class QPushButton;

namespace trephine::view {

class StartPage : public QWidget {
  Q_OBJECT

 public:
  explicit StartPage(const StartPageOptions& options, QWidget* parent = nullptr);
  /// The choice, once the page is closed.
  const StartChoice& choice() const noexcept { return choice_; }
  /// Chooses a scan with the selected procedure, and closes the page.
  void choose_scan(const QString& path);

 private:
  QWidget* make_tile(const StartTile& tile);
  QWidget* make_sessions();
  QWidget* make_own_scan();
  void choose(StartChoice choice);
  void choose_session(StartChoice::Kind kind);

  const StartPageOptions& options_;
  StartChoice choice_;
  QListWidget* sessions_ = nullptr;
  QComboBox* procedure_ = nullptr;
  QPushButton *resume_ = nullptr, *replay_ = nullptr;
};

}  // namespace trephine::view
