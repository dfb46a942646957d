// NoticeLabel and EventLog: messages at the tool for some seconds, and a log of all messages.
#pragma once

#include <QDockWidget>
#include <QLabel>
#include <span>

#include "apps/view/notices.h"

class QListWidget;

namespace trephine::view {

/// A label over the picture at the tool's tip. Mouse events pass through it.
class NoticeLabel : public QLabel {
  Q_OBJECT

 public:
  explicit NoticeLabel(QWidget* canvas);
  /// True if this text is not empty, and not shown yet.
  bool is_new(const QString& text) const { return !text.isEmpty() && (text != this->text() || isHidden()); }
  /// Shows `text` at a position of the picture; an empty text hides the label. A new text is placed at the
  /// side of the tip where it covers least of `labels`, and stays there. Positions and boxes: pixels of the
  /// canvas.
  void show_at(const QString& text, workbench::EventLevel level, const QPoint& tip,
               std::span<const QRect> labels);

 private:
  QPoint position_at(int side, const QPoint& tip) const;
  int side_ = 0;  ///< of the tip: 0 lower right, 1 lower left, 2 upper right, 3 upper left
  workbench::EventLevel level_ = workbench::EventLevel::record;
  int widest_room_ = 0;  ///< pixels, and the font, of the last layout
  QFont font_;
};

/// All messages with their times, newest last. Follows the newest unless it is scrolled.
class EventLog : public QDockWidget {
  Q_OBJECT

 public:
  explicit EventLog(QWidget* parent);
  void update_from(const Notices& notices);
  /// For a replay, whose messages are all known: scrolls to the last message at or before `seconds`, and
  /// greys the later ones.
  void show_time(const Notices& notices, double seconds);
  void clear();

 protected:
  void showEvent(QShowEvent* event) override;

 private:
  QListWidget* list_;
  std::size_t count_ = 0;
  bool was_shown_ = false;
  int past_ = -1;  ///< messages up to the time of show_time(); -1: not called
};

}  // namespace trephine::view
