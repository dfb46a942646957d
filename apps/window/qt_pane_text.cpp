#include "apps/window/qt_pane_text.h"

#include <QCoreApplication>
#include <algorithm>
#include <utility>

#include "apps/view/display_text.h"
#include "apps/window/qt_localizer.h"

namespace trephine::view {

using imaging::Panel;
using imaging::PictureBox;

namespace {

constexpr double k_margin = 4;  // pixels between a text and the sides of its dark background

QRectF background_of(QPainter& painter, const QRectF& area, int flags, const QString& text) {
  return painter.boundingRect(area, flags, text).adjusted(-k_margin, -1, k_margin, 1);
}

QColor colour_of(const Panel::Colour& colour) { return {colour[0], colour[1], colour[2]}; }

double row_height(const QPainter& painter) { return painter.fontMetrics().height() + 2.0; }

}  // namespace

void write_text(QPainter& painter, const QRectF& area, int flags, const QString& text, const QColor& colour) {
  if (text.isEmpty()) return;
  painter.fillRect(background_of(painter, area, flags, text), QColor(14, 16, 20, 205));
  painter.setPen(colour);
  painter.drawText(area, flags, text);
}

PaneText::PaneText(QPainter& painter, const QSizeF& size, const QRectF& inner)
    : painter_(&painter), size_(size), inner_(inner) {}

void PaneText::add(const QRectF& area, int flags, const QString& text) {
  if (text.isEmpty()) return;
  texts_.push_back({area, flags, text});
  keep_free(background_of(*painter_, area, flags, text));
}

void PaneText::keep_free(const QRectF& area) { occupied_.push_back(area); }

PictureBox PaneText::box_of(const QRectF& area) const {
  return {{area.left(), size_.height() - area.bottom()}, {area.right(), size_.height() - area.top()}};
}

/// Places the legend into the corner where it covers the least of the image. Entries that do not fit are
/// replaced by one entry with their count.
void PaneText::place_legend(const Panel& panel, double bottom, std::vector<Entry> entries) {
  entries_ = std::move(entries);
  legend_ = {};
  if (entries_.empty()) return;
  constexpr double k_share = 0.3;  // largest height of the legend, as a share of the area for texts
  const double row = row_height(*painter_), swatch = 0.6 * row + 10 - k_margin;
  const auto most = static_cast<std::size_t>(std::max(0.0, k_share * (bottom - inner_.top()) / row));
  if (entries_.size() > most) {
    const auto hidden = entries_.size() - most;
    entries_.resize(most);
    entries_.push_back({QCoreApplication::translate("PaneText", "and %1 more").arg(hidden), {}, false});
  }
  double text_width = 0;
  for (const Entry& entry : entries_)
    text_width = std::max(text_width, QFontMetricsF(painter_->font()).horizontalAdvance(entry.text));
  const double width = std::min(inner_.width(), swatch + text_width + 2 * k_margin),
               height = row * static_cast<double>(entries_.size());
  std::vector<QRectF> corners;
  std::vector<PictureBox> boxes, occupied;
  for (const double y : {bottom - height, inner_.top()})
    for (const double x : {inner_.left(), inner_.right() - width}) {
      corners.emplace_back(x, y, width, height);
      boxes.push_back(box_of(corners.back()));
    }
  for (const QRectF& area : occupied_) occupied.push_back(box_of(area));
  legend_ = corners[imaging::least_covering(panel, size_.width(), size_.height(), boxes, occupied)];
}

void PaneText::lay_out(const Panel& panel, bool has_names, double bottom) {
  const QFontMetricsF metrics(painter_->font());
  // Lines of one colour have one entry with all their names.
  std::vector<Entry> lines;
  QStringList known;
  for (const Panel::Line& line : panel.lines) {
    const QString name = localized(line.name);
    if (name.isEmpty() || known.contains(name)) continue;
    known.push_back(name);
    const QColor colour = colour_of(line.colour);
    const auto same =
        std::find_if(lines.begin(), lines.end(), [&](const Entry& other) { return other.colour == colour; });
    if (same != lines.end())
      same->text += ", " + name;
    else
      lines.push_back({name, colour});
  }
  names_.clear();
  place_legend(panel, bottom, lines);
  if (!has_names) return;
  // A name without room is replaced by a number, and the legend explains the number. The legend becomes
  // larger, and the names must be placed again to avoid it: repeat until the legend does not change, at most
  // three times.
  constexpr int k_rounds = 3;
  for (int round = 0; round < k_rounds; ++round) {
    imaging::LabelSpace space{size_.width(), size_.height(), metrics.height() + 2,
                              [&](const std::string& text) {
                                return metrics.horizontalAdvance(QString::fromStdString(text)) + 2 * k_margin;
                              }};
    space.shown_text = display_text;
    for (const QRectF& area : occupied_) space.occupied.push_back(box_of(area));
    if (!legend_.isEmpty()) space.occupied.push_back(box_of(legend_));
    names_ = imaging::place_labels(panel, space);
    std::vector<Entry> entries;
    for (std::size_t i = 0; i < names_.size(); ++i)
      if (names_[i].number > 0)
        entries.push_back({QString("%1  %2").arg(names_[i].number).arg(localized(panel.labels[i].text)),
                           colour_of(panel.labels[i].colour), false});
    entries.insert(entries.end(), lines.begin(), lines.end());
    const QRectF before = legend_;
    place_legend(panel, bottom, std::move(entries));
    if (legend_ == before) break;
  }
}

void PaneText::draw_names(const Panel& panel) {
  const auto point = [&](const glm::dvec2& at) { return QPointF(at.x, size_.height() - at.y); };
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const imaging::PlacedLabel& name = names_[i];
    if (name.text.empty()) continue;
    const QColor colour = colour_of(panel.labels[i].colour);
    if (name.lead) {
      painter_->setPen(QPen(colour, 1));
      painter_->drawLine(point((*name.lead)[0]), point((*name.lead)[1]));
    }
    const QRectF box(point({name.box.low.x, name.box.high.y}), point({name.box.high.x, name.box.low.y}));
    write_text(*painter_, box.adjusted(k_margin, 0, 0, 0), Qt::AlignLeft | Qt::AlignVCenter,
               QString::fromStdString(name.text), colour);
  }
}

void PaneText::draw() {
  for (const Text& text : texts_) write_text(*painter_, text.area, text.flags, text.text);
  const double row = row_height(*painter_), swatch = 0.6 * row;
  double y = legend_.top();
  for (const Entry& entry : entries_) {
    const double text_left = legend_.left() + (entry.has_swatch ? swatch + 10 : k_margin);
    const double text_width = legend_.right() - text_left;
    write_text(*painter_, QRectF(text_left, y, text_width, row), Qt::AlignLeft | Qt::AlignVCenter,
               QFontMetricsF(painter_->font()).elidedText(entry.text, Qt::ElideRight, text_width));
    if (entry.has_swatch)
      painter_->fillRect(QRectF(legend_.left() + 2, y + 0.2 * row, swatch, swatch), entry.colour);
    y += row;
  }
}

}  // namespace trephine::view
