#include "apps/window/qt_notices.h"

#include <QListWidget>
#include <QMainWindow>
#include <QScrollBar>
#include <QTimer>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "apps/window/qt_localizer.h"

namespace trephine::view {

using workbench::EventLevel;

namespace {

/// Returns the colour of a message in the log; nullopt: that of the text.
std::optional<QColor> colour_of(EventLevel level) {
  if (level == EventLevel::danger) return QColor(255, 120, 100);
  if (level == EventLevel::refusal) return QColor(246, 201, 68);
  return std::nullopt;
}

}  // namespace

NoticeLabel::NoticeLabel(QWidget* canvas) : QLabel(canvas) {
  setObjectName("notice_at_tool");
  setAttribute(Qt::WA_TransparentForMouseEvents);
  setWordWrap(true);
  setMargin(8);
  hide();
}

/// Returns the position of the label on a side of the tip (see `side_`), or on the opposite side if the
/// picture has no room there. `extra`: additional distance above or below the tip, pixels.
QPoint NoticeLabel::position_at(int side, int extra, const QPoint& tip) const {
  constexpr int k_gap = 28, k_border = 8;
  const auto along = [&](bool is_before, int at, int gap, int length, int room) {
    const int before = at - gap - length, after = at + gap;
    const bool has_room = is_before ? before >= k_border : after + length <= room - k_border;
    return std::clamp(is_before == has_room ? before : after, k_border,
                      std::max(k_border, room - length - k_border));
  };
  return {along(side % 2 == 1, tip.x(), k_gap, width(), parentWidget()->width()),
          along(side >= 2, tip.y(), k_gap + extra, height(), parentWidget()->height())};
}

void NoticeLabel::show_at(const QString& text, EventLevel level, const QPoint& tip,
                          std::span<const QRect> labels) {
  if (text.isEmpty()) return hide();
  const bool is_placed_again = needs_layout(text);
  if (is_placed_again || level != level_) {
    level_ = level, widest_ = widest(), font_ = font();
    const char* border = level == EventLevel::danger    ? "#e5533d"
                         : level == EventLevel::refusal ? "#f6c944"
                                                        : "#6fa8dc";
    setStyleSheet(
        QString("background: #12161e; color: #ecedf4; border: 2px solid %1; border-radius: 6px").arg(border));
    setText(text);
    // The label is as wide as its longest line if that is short. A long line wraps at half of its length
    // plus 24 characters, and always at the width of the picture.
    int line_width = 0;
    for (const QString& line : text.split('\n'))
      line_width = std::max(line_width, fontMetrics().horizontalAdvance(line));
    const int width = std::min({line_width + 2 * margin() + 8,
                                24 * fontMetrics().averageCharWidth() + line_width / 2 + 40, widest_});
    resize(width, heightForWidth(width));
    show();
    raise();
  }
  if (is_placed_again) {
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (const int extra : {0, 40, 80, 120, 160})
      for (int side = 0; side < 4; ++side) {
        std::int64_t covered = 0;
        const QRect box(position_at(side, extra, tip), size());
        for (const QRect& label : labels) {
          const QRect both = box & label;
          if (!both.isEmpty()) covered += std::int64_t{both.width()} * both.height();
        }
        if (covered < least) least = covered, side_ = side, extra_ = extra;
      }
  }
  move(position_at(side_, extra_, tip));
}

EventLog::EventLog(QWidget* parent) : QDockWidget(tr("Event log"), parent), list_(new QListWidget) {
  setObjectName("event_log");
  list_->setObjectName("event_list");
  list_->setWordWrap(true);
  list_->setFocusPolicy(Qt::NoFocus);
  list_->setAccessibleName(tr("Event log"));
  // The log shows at least three lines of text; the user can enlarge it by dragging its border.
  list_->setMinimumHeight(3 * list_->fontMetrics().height());
  list_->setSizePolicy(QSizePolicy::Preferred, QSizePolicy::Ignored);
  setWidget(list_);
  hide();
}

void EventLog::update_from(const Notices& notices) {
  if (notices.count() == count_ || isHidden()) return;
  const QScrollBar* bar = list_->verticalScrollBar();
  const bool follows = bar->value() >= bar->maximum();
  const std::size_t fresh = std::min(notices.count() - count_, notices.log().size());
  for (std::size_t i = notices.log().size() - fresh; i < notices.log().size(); ++i) {
    const Notices::Entry& entry = notices.log()[i];
    auto* item = new QListWidgetItem(
        QString("%L1 s   %2").arg(entry.session_time, 0, 'f', 1).arg(localized(entry.text)));
    if (const auto colour = colour_of(entry.level)) item->setForeground(*colour);
    list_->addItem(item);
  }
  while (list_->count() > static_cast<int>(Notices::k_max_logged)) delete list_->takeItem(0);
  count_ = notices.count();
  if (follows) list_->scrollToBottom();
}

void EventLog::show_time(const Notices& notices, double seconds) {
  if (isHidden() || list_->count() != static_cast<int>(notices.log().size())) return;
  const auto& log = notices.log();
  const auto later = std::find_if(log.begin(), log.end(),
                                  [&](const Notices::Entry& entry) { return entry.session_time > seconds; });
  const int past = static_cast<int>(later - log.begin());
  if (past == past_) return;
  past_ = past;
  for (int i = 0; i < list_->count(); ++i) {
    const auto colour = colour_of(log[static_cast<std::size_t>(i)].level);
    list_->item(i)->setForeground(i >= past ? QBrush(QColor(118, 122, 132))
                                  : colour  ? QBrush(*colour)
                                            : QBrush());
  }
  list_->setCurrentRow(past - 1);
  if (past > 0)
    list_->scrollToItem(list_->item(past - 1), QAbstractItemView::PositionAtCenter);
  else
    list_->scrollToTop();
}

void EventLog::showEvent(QShowEvent* event) {
  QDockWidget::showEvent(event);
  constexpr int k_lines = 8;  // initial height of the log, in lines; the user can change the height
  QTimer::singleShot(0, list_, &QListWidget::scrollToBottom);
  if (shown_height_ == 0) shown_height_ = k_lines * (list_->fontMetrics().height() + 2) + 24;
  // Deferred until the layout has its sizes.
  QTimer::singleShot(0, this, [this] {
    if (auto* window = qobject_cast<QMainWindow*>(parentWidget()))
      window->resizeDocks({this}, {shown_height_}, Qt::Vertical);
    QTimer::singleShot(0, list_, &QListWidget::scrollToBottom);
  });
}

void EventLog::hideEvent(QHideEvent* event) {
  QDockWidget::hideEvent(event);
  shown_height_ = height();
}

void EventLog::clear() {
  list_->clear();
  count_ = 0;
  past_ = -1;
}

}  // namespace trephine::view
