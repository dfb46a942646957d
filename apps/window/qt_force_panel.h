// ForcePanel: the parts of the force of a paused replay.
#pragma once

#include <QDockWidget>
#include <functional>
#include <optional>

#include "haptics/servo/force_parts.h"

class QLabel;
class QTableWidget;

namespace trephine::view {

/// States what the tool touches and why the force is rendered, and shows a row per part of the force. Two
/// buttons step from tick to tick.
class ForcePanel : public QDockWidget {
  Q_OBJECT

 public:
  explicit ForcePanel(QWidget* parent);
  /// Shows the parts of the force in one tick. Empty `parts`: the replay plays, or is before its first tick.
  void show_parts(const std::optional<haptics::ForceParts>& parts, const haptics::TouchScene& scene,
                  bool is_playing);
  /// The user requested to go this number of ticks forward; negative: back.
  std::function<void(int)> on_step = [](int) {};
  std::function<void(bool)> on_visible = [](bool) {};

 protected:
  void resizeEvent(QResizeEvent* event) override;

 private:
  void fit_heights();

  QLabel* text_;
  QTableWidget* table_;
  std::optional<std::uint64_t> shown_;  ///< tick
};

}  // namespace trephine::view
