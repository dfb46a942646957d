// ElidedLabel: one line of text. A text that does not fit ends with "..." and is complete in the tool tip.
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
