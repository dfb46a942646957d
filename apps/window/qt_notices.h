// NoticeLabel and EventLog: messages at the tool for some seconds, and a log of all messages.
#pragma once

#include <QDockWidget>
#include <QLabel>
#include <algorithm>
#include <span>

#include "apps/view/notices.h"

class QListWidget;

namespace trephine::view {

/// A label over the picture at the tool's tip. Mouse events pass through it.
class NoticeLabel : public QLabel {
  Q_OBJECT

 public:
  explicit NoticeLabel(QWidget* canvas);
  /// Returns true if show_at() will choose a new position for this text, because the text is not shown yet,
  /// or the font or the width of the picture changed.
  bool needs_layout(const QString& text) const {
    return !text.isEmpty() && (text != this->text() || isHidden() || widest() != widest_ || font() != font_);
  }
  /// Shows `text` next to the tip of the tool; an empty text hides the label. A new text is placed on the
  /// side of the tip, and at the distance from it, at which the text covers the least of `labels`. Then the
  /// label follows the tip and keeps this side and distance. Positions and boxes: pixels of the canvas.
  void show_at(const QString& text, workbench::EventLevel level, const QPoint& tip,
               std::span<const QRect> labels);

 private:
  QPoint position_at(int side, int extra, const QPoint& tip) const;
  int side_ = 0;   ///< side of the tip: 0 lower right, 1 lower left, 2 upper right, 3 upper left
  int extra_ = 0;  ///< additional distance above or below the tip to avoid labels, pixels
  workbench::EventLevel level_ = workbench::EventLevel::record;
  /// Returns the largest width of the label in the picture, pixels.
  int widest() const { return std::max(parentWidget()->width() - 16, 80); }
  int widest_ = 0;  ///< largest width of the label at the last layout, pixels
  QFont font_;      ///< font at the last layout
};

/// All messages with their times, newest last. Scrolls to new messages unless the user has scrolled up.
class EventLog : public QDockWidget {
  Q_OBJECT

 public:
  explicit EventLog(QWidget* parent);
  void update_from(const Notices& notices);
  /// Shows the time of a replay, whose messages are all in the log from the start: scrolls to the last
  /// message at or before `seconds`, and shows the later messages in grey.
  void show_time(const Notices& notices, double seconds);
  void clear();

 protected:
  void showEvent(QShowEvent* event) override;
  void hideEvent(QHideEvent* event) override;

 private:
  QListWidget* list_;
  std::size_t count_ = 0;
  int shown_height_ = 0;  ///< pixels, when the log was last visible; 0: it was never shown
  int past_ = -1;  ///< number of messages up to the time that show_time() showed last; -1: not called yet
};

}  // namespace trephine::view
