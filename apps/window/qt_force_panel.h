// ForcePanel: the parts of the force of a paused replay.
#pragma once

#include <QDockWidget>
#include <functional>
#include <optional>

#include "haptics/servo/force_parts.h"

class QLabel;
class QTableWidget;

namespace trephine::view {

/// States what the tool touches and why it feels its force, with a row per part, and steps from tick to tick.
class ForcePanel : public QDockWidget {
  Q_OBJECT

 public:
  explicit ForcePanel(QWidget* parent);
  /// Shows a tick. Empty parts: the replay plays, or is before its first tick.
  void show_parts(const std::optional<haptics::ForceParts>& parts, const haptics::TouchScene& scene,
                  bool is_playing);
  /// Goes some ticks forward or back.
  std::function<void(int)> on_step = [](int) {};
  std::function<void(bool)> on_visible = [](bool) {};

 private:
  QLabel* text_;
  QTableWidget* table_;
  std::optional<std::uint64_t> shown_;  ///< tick
};

}  // namespace trephine::view
