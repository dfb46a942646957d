// PaneText: texts over an image pane: letters and captions at its edges, the legend, and names of the plan,
// laid out so that they do not cover each other.
#pragma once

#include <QColor>
#include <QPainter>
#include <QString>
#include <vector>

#include "apps/imaging/label_layout.h"

namespace trephine::view {

/// Draws text on a dark background, readable on bright pictures.
void write_text(QPainter& painter, const QRectF& area, int flags, const QString& text,
                const QColor& colour = QColor(232, 236, 242));

/// Positions are in pixels of the pane, y down.
class PaneText {
 public:
  /// `painter`: of the pane, with its font. `size`: of the pane. `inner`: the area for texts.
  PaneText(QPainter& painter, const QSizeF& size, const QRectF& inner);
  /// Adds a text at an edge of `area`.
  void add(const QRectF& area, int flags, const QString& text);
  /// Keeps an area free, such as that of a button.
  void keep_free(const QRectF& area);
  /// Places the legend and the names of a panel where they do not cover added texts and free areas. `bottom`:
  /// lower edge of the legend.
  void lay_out(const imaging::Panel& panel, bool has_names, double bottom);
  void draw_names(const imaging::Panel& panel);
  /// Draws the added texts and the legend.
  void draw();
  const std::vector<imaging::PlacedLabel>& names() const noexcept { return names_; }
  const QRectF& legend() const noexcept { return legend_; }

 private:
  struct Text {
    QRectF area;
    int flags;
    QString text;
  };
  struct Entry {
    QString text;
    QColor colour;
    bool has_swatch = true;
  };
  imaging::PictureBox box_of(const QRectF& area) const;
  void place_legend(const imaging::Panel& panel, double bottom, std::vector<Entry> entries);

  QPainter* painter_;
  QSizeF size_;
  QRectF inner_, legend_;
  std::vector<Text> texts_;
  std::vector<QRectF> occupied_;
  std::vector<Entry> entries_;
  std::vector<imaging::PlacedLabel> names_;
};

}  // namespace trephine::view
