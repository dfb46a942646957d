// ElidedLabel: one line of text. A text that does not fit is cut and ends with "..."; the tool tip shows all
// of it.
#pragma once

#include <QLabel>
#include <QPainter>
#include <QStyle>

namespace trephine::view {

class ElidedLabel : public QLabel {
 public:
  QSize minimumSizeHint() const override { return {0, QLabel::minimumSizeHint().height()}; }

 protected:
  void paintEvent(QPaintEvent*) override {
    const QString line = fontMetrics().elidedText(text(), Qt::ElideRight, width());
    setToolTip(line == text() ? QString() : text());
    QPainter painter(this);
    style()->drawItemText(&painter, rect(), Qt::AlignVCenter | Qt::AlignLeft, palette(), isEnabled(), line,
                          foregroundRole());
  }
};

}  // namespace trephine::view
