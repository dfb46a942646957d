#include "apps/window/qt_image_pane.h"

#include <QComboBox>
#include <QCoreApplication>
#include <QMouseEvent>
#include <QPainter>
#include <QToolButton>
#include <algorithm>
#include <cmath>

#include "apps/window/qt_localizer.h"
#include "apps/window/qt_pane_text.h"
#include "apps/window/qt_tool_panel.h"

namespace trephine::view {

using glm::dvec2;
using glm::dvec3;
using imaging::PaneKind;
using imaging::Panel;

namespace {

/// Colours of 3D Slicer: axial red, coronal green, sagittal yellow.
QColor colour_of(PaneKind kind) {
  switch (kind) {
    case PaneKind::axial:
      return {240, 92, 84};
    case PaneKind::coronal:
      return {108, 190, 96};
    case PaneKind::sagittal:
      return {236, 208, 74};
    case PaneKind::tool:
      return {90, 200, 240};
    case PaneKind::section:
      return {190, 150, 235};
    case PaneKind::xray:
    case PaneKind::rendering:
    case PaneKind::depths:
      break;
  }
  return {170, 180, 195};
}

QString words_of_kind(PaneKind kind) {
  constexpr const char* names[] = {QT_TRANSLATE_NOOP("ImagePane", "Axial"),
                                   QT_TRANSLATE_NOOP("ImagePane", "Coronal"),
                                   QT_TRANSLATE_NOOP("ImagePane", "Sagittal"),
                                   QT_TRANSLATE_NOOP("ImagePane", "Along the tool"),
                                   QT_TRANSLATE_NOOP("ImagePane", "Section"),
                                   QT_TRANSLATE_NOOP("ImagePane", "X-ray"),
                                   QT_TRANSLATE_NOOP("ImagePane", "Volume rendering"),
                                   QT_TRANSLATE_NOOP("ImagePane", "Depth images")};
  return QCoreApplication::translate("ImagePane", names[static_cast<std::size_t>(kind)]);
}

}  // namespace

ImagePane::ImagePane(imaging::Panes& panes, std::size_t index, QWidget* parent)
    : QWidget(parent), panes_(&panes), index_(index) {
  setObjectName(QString("pane_%1").arg(index));
  setMouseTracking(true);
  setFocusPolicy(Qt::ClickFocus);
  const auto button = [this](const char* name, const QString& text, const QString& tip) {
    auto* b = new QToolButton(this);
    b->setObjectName(QString("%1_%2").arg(name).arg(index_));
    b->setText(text);
    b->setToolTip(tip);
    b->setFocusPolicy(Qt::NoFocus);
    return b;
  };
  kind_ = new QComboBox(this);
  kind_->setObjectName(QString("pane_kind_%1").arg(index));
  kind_->setFocusPolicy(Qt::NoFocus);
  for (std::size_t k = 0; k < std::size(imaging::k_pane_kinds); ++k)
    kind_->addItem(words_of_kind(static_cast<PaneKind>(k)));
  kind_->setCurrentIndex(static_cast<int>(panes.kind(index)));
  connect(kind_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this](int kind) {
    panes_->set_kind(index_, static_cast<PaneKind>(kind));
    image_ = {};
    lay_out();
    update();
  });
  preset_ = new QComboBox(this);
  preset_->setObjectName(QString("xray_view_%1").arg(index));
  preset_->setFocusPolicy(Qt::NoFocus);
  preset_->setToolTip(tr("Select a pose of the C-arm"));
  preset_->setPlaceholderText(tr("Other pose"));
  for (const std::string_view name : fluoroscopy::k_presets)
    preset_->addItem(name == "ap" ? QString("AP") : words_of(name));
  connect(preset_, QOverload<int>::of(&QComboBox::activated), this, [this](int i) { on_preset(i); });
  live_ = button("xray_live", tr("Live"), {});
  live_->setCheckable(true);
  live_->setStyleSheet("QToolButton:checked { background: #c8862a; color: black; font-weight: bold }");
  connect(live_, &QToolButton::toggled, this, [this](bool is_down) { on_live(is_down); });
  shoot_ = button("xray_shoot", tr("Shoot"), {});
  connect(shoot_, &QToolButton::clicked, this, [this] { on_shoot(); });
  maximise_ = button("maximise", "\u25a1", tr("Maximise or restore this pane  (double click)"));
  connect(maximise_, &QToolButton::clicked, this, [this] { on_maximise(); });
  set_xray_refusal({});
  lay_out();
}

void ImagePane::set_xray_refusal(const QString& reason) {
  for (QToolButton* button : {live_, shoot_}) {
    button->setEnabled(reason.isEmpty());
    button->setToolTip(
        !reason.isEmpty() ? reason
        : button == live_
            ? tr("Take X-rays until switched off. Each X-ray adds dose. The last image is held.")
            : tr("Take one X-ray"));
  }
  if (!reason.isEmpty()) live_->setChecked(false);
}

void ImagePane::set_kind(PaneKind kind) { kind_->setCurrentIndex(static_cast<int>(kind)); }

void ImagePane::lay_out() {
  constexpr int k_gap = 5;
  const int button_height = std::max(24, fontMetrics().height() + 8);
  int x = k_gap;
  const bool is_xray = panes_->kind(index_) == PaneKind::xray;
  for (QWidget* w : std::initializer_list<QWidget*>{preset_, live_, shoot_}) w->setVisible(is_xray);
  // Fit the controls into the width: combo boxes shrink first, then the buttons move below them, and below
  // each other.
  const int room = width() - 2 * k_gap - button_height - 3;
  const int buttons = is_xray ? live_->sizeHint().width() + shoot_->sizeHint().width() + 9 : 0;
  const int least_box = 5 * fontMetrics().averageCharWidth() + button_height;
  const bool is_narrow = is_xray && (room - buttons) / 2 < least_box;
  const int box = std::max(40, (room - (is_narrow ? 3 : buttons)) / (is_xray ? 2 : 1));
  int row = 0;
  for (QWidget* w : std::initializer_list<QWidget*>{kind_, preset_, live_, shoot_}) {
    if (w->isHidden()) continue;
    const bool is_box = w == kind_ || w == preset_;
    const int control_width = is_box ? std::min(box, w->sizeHint().width()) : w->sizeHint().width();
    if (is_narrow && (w == live_ || (w == shoot_ && x + control_width > width() - k_gap))) x = k_gap, ++row;
    w->setGeometry(x, k_gap + row * (button_height + 3), control_width, button_height);
    x += control_width + 3;
  }
  maximise_->setGeometry(width() - button_height - k_gap, k_gap, button_height, button_height);
}

/// The pane is at least as wide as each of its buttons, and as two boxes with some letters.
QSize ImagePane::minimumSizeHint() const {
  constexpr int k_gap = 5, k_letters = 4;
  const int button_height = std::max(24, fontMetrics().height() + 8);
  const int box = k_letters * fontMetrics().averageCharWidth() + button_height;
  const int boxes = 2 * (box + 3) + button_height;
  return {2 * k_gap + std::max({boxes, live_->sizeHint().width(), shoot_->sizeHint().width()}),
          4 * button_height};
}

void ImagePane::changeEvent(QEvent* event) {
  QWidget::changeEvent(event);
  if (event->type() != QEvent::FontChange) return;
  updateGeometry();
  lay_out();
}

void ImagePane::resizeEvent(QResizeEvent*) {
  panes_->set_size(index_, width(), height(), isVisible());
  lay_out();
}

void ImagePane::set_names_visible(bool is_visible) {
  has_names_ = is_visible;
  update();
}

QRectF ImagePane::image_rect(const Panel& panel) const {
  // X-rays are scaled to fit into the pane. Slices have the size of the pane, except during a resize, when
  // they are also scaled to fit. A volume rendering is scaled to the height of the pane, which determines its
  // projection.
  const double by_height = height() / static_cast<double>(panel.rows);
  const double scale = panes_->kind(index_) == PaneKind::rendering
                           ? by_height
                           : std::min(width() / static_cast<double>(panel.columns), by_height);
  const double w = scale * panel.columns, h = scale * panel.rows;
  return {0.5 * (width() - w), 0.5 * (height() - h), w, h};
}

QPointF ImagePane::place(const Panel& panel, const dvec2& mm) const {
  const QRectF rect = image_rect(panel);
  const double scale = rect.width() / (panel.columns * panel.mm_per_pixel);
  return {rect.center().x() + scale * mm.x, rect.center().y() - scale * mm.y};
}

void ImagePane::refresh(const std::array<dvec3, 2>* tool) {
  panes_->set_size(index_, width(), height(), isVisible());
  if (!isVisible()) return;
  const bool has_moved = panes_->focus() != shown_at_ || (tool != nullptr) != has_tool_ ||
                         (tool != nullptr && (*tool)[0] != shown_tip_);
  if (const QSignalBlocker quiet(live_); live_->isChecked() != panes_->is_live())
    live_->setChecked(panes_->is_live());
  if (const int preset = fluoroscopy::preset_of(panes_->arm()); preset_->currentIndex() != preset)
    preset_->setCurrentIndex(preset);  // a resumed session, or a command, has set the pose
  const bool is_new_image = panes_->changes(index_) != shown_changes_;
  if (!is_new_image && !has_moved) return;
  shown_changes_ = panes_->changes(index_);
  shown_at_ = panes_->focus();
  has_tool_ = tool != nullptr;
  if (tool != nullptr) tool_ = *tool, shown_tip_ = (*tool)[0];
  if (const Panel* panel = panes_->panel(index_); panel != nullptr && is_new_image) {
    image_ = QImage(panel->columns, panel->rows, QImage::Format_RGB888);
    for (int row = 0; row < panel->rows; ++row) {
      const auto* from = panel->pixels.data() + static_cast<std::size_t>(panel->columns) *
                                                    static_cast<std::size_t>(panel->rows - 1 - row);
      std::copy_n(from->data(), 3 * static_cast<std::size_t>(panel->columns), image_.scanLine(row));
    }
  }
  update();
}

namespace {

/// Returns a caption in lines of at most `room` pixels. Breaks it between its items, which three spaces or a
/// comma separate, so that a number keeps its unit; only an item that is too wide by itself is cut.
QStringList wrapped(const QString& caption, const QFontMetricsF& metrics, double room) {
  QStringList lines;
  for (const QString& line : caption.split('\n')) {
    QString current;
    for (const QString& part : line.split("   ", Qt::SkipEmptyParts)) {
      const QStringList items = part.split(", ");
      for (int i = 0; i < items.size(); ++i) {
        const QString item = items[i].trimmed();
        const QString longer = current.isEmpty() ? item : current + (i > 0 ? ", " : "   ") + item;
        if (current.isEmpty() || metrics.horizontalAdvance(longer) <= room) {
          current = longer;
        } else {
          lines.push_back(current);
          current = item;
        }
      }
    }
    lines.push_back(current);
  }
  for (QString& line : lines) line = metrics.elidedText(line, Qt::ElideRight, room);
  return lines;
}

}  // namespace

/// Adds the letters of directions, the captions and the value at the focus to `text`. Sets `bottom`, the
/// lower edge of the legend.
void ImagePane::add_captions(PaneText& text, const Panel& panel, const QRectF& inner, double& bottom) const {
  const PaneKind kind = panes_->kind(index_);
  text.add(inner, Qt::AlignLeft | Qt::AlignVCenter, QString::fromStdString(panel.left));
  text.add(inner, Qt::AlignRight | Qt::AlignVCenter, QString::fromStdString(panel.right));
  text.add(inner, Qt::AlignHCenter | Qt::AlignTop, QString::fromStdString(panel.above));
  QString foot = localized(panel.foot);
  if (kind == PaneKind::xray)
    foot = (panes_->is_exposing() && !panes_->is_live() ? tr("Computing the X-ray ...")
                                                        : localized(panel.title)) +
           "   " + localized(QString::fromStdString(panes_->xray_note()).trimmed());
  if (kind == PaneKind::depths) foot = localized(panel.title) + "\n" + localized(panel.foot);
  if (kind == PaneKind::section) foot = localized(panel.title) + "\n" + localized(panel.foot);
  // Limit the foot to the space next to the scale bar.
  const QFontMetricsF metrics(font());
  const double bar = std::max(0.3 * width(), metrics.horizontalAdvance("100 mm") + 16);
  const double room = panes_->plane(index_) ? width() - bar - 16 : width();
  const QStringList lines = wrapped(foot.trimmed(), metrics, room - 12);
  text.add(inner, Qt::AlignLeft | Qt::AlignBottom, lines.join('\n'));
  // The letter at the lower edge is above the foot and the scale bar.
  bottom = inner.bottom() - metrics.height() * std::max<double>(1, lines.size()) - 8;
  text.add(QRectF(inner.topLeft(), QPointF(inner.right(), bottom)), Qt::AlignHCenter | Qt::AlignBottom,
           QString::fromStdString(panel.below));
  if (kind != PaneKind::section && imaging::is_planar(kind))
    if (const auto value = panes_->probe())
      text.add(inner, Qt::AlignRight | Qt::AlignTop,
               QString("%1%2").arg(*value).arg(panes_->is_hounsfield() ? " HU" : ""));
}

void ImagePane::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor(14, 14, 16));
  const Panel* panel = panes_->panel(index_);
  const PaneKind kind = panes_->kind(index_);
  int controls = 0;  // their lower edge
  for (const QWidget* w : std::initializer_list<QWidget*>{kind_, preset_, live_, shoot_, maximise_})
    if (!w->isHidden()) controls = std::max(controls, w->geometry().bottom());
  const QRectF inner = QRectF(rect()).adjusted(8, controls + 6, -8, -6);
  PaneText text(painter, size(), inner);
  const auto plane = panes_->plane(index_);
  const int bar_mm = plane ? imaging::bar_length(0.3 * width() * plane->pixel) : 0;
  const double bar_left = plane ? width() - 10.0 - bar_mm / plane->pixel : 0, bar_y = height() - 9.0;
  if (panel != nullptr) {
    text.keep_free({0, 0, width() + 0.0, inner.top() - 2});  // the controls
    if (plane) {
      const double line = fontMetrics().height() + 2;
      text.add(QRectF(bar_left - 200, bar_y - line - 4, width() - 10.0 - bar_left + 200, line),
               Qt::AlignRight | Qt::AlignBottom, QString("%1 mm").arg(bar_mm));
      text.keep_free({bar_left, bar_y - 4, width() - bar_left, 8});
    }
    if (panes_->problem(index_).empty()) {
      double bottom = inner.bottom();
      add_captions(text, *panel, inner, bottom);
      // In a small X-ray, many names would cover the film.
      constexpr std::size_t k_few = 6;
      constexpr int k_large = 500;  // pixels
      const bool has_room = kind != PaneKind::xray || panel->labels.size() <= k_few || width() >= k_large;
      text.lay_out(*panel, has_names_ && has_room && !image_.isNull(), bottom);
    }
  }
  painter.setRenderHint(QPainter::SmoothPixmapTransform);
  if (panel != nullptr && !image_.isNull()) {
    const QRectF at = image_rect(*panel);
    painter.drawImage(at, image_);
    if (kind == PaneKind::rendering && at.left() > 0) {
      // During a resize the background continues to the edges of the pane.
      const QRectF first(0, 0, 1, image_.height()), last(image_.width() - 1, 0, 1, image_.height());
      painter.drawImage(QRectF(0, at.top(), at.left() + 1, at.height()), image_, first);
      painter.drawImage(QRectF(at.right() - 1, at.top(), width() - at.right() + 1, at.height()), image_,
                        last);
    }
    painter.setRenderHint(QPainter::Antialiasing);
    for (const Panel::Line& line : panel->lines) {
      if (line.points.empty()) continue;
      QPolygonF points;
      for (const dvec2& p : line.points) points << place(*panel, p);
      if (line.is_closed) points << points.front();
      painter.setPen(QPen(QColor(line.colour[0], line.colour[1], line.colour[2]), 1.5));
      painter.drawPolyline(points);
    }
    text.draw_names(*panel);
  }
  // Draw the crosshair, which shows the other planes. It has a gap at the focus.
  if (imaging::is_planar(kind) && panel != nullptr)
    if (const auto at = panes_->pixel(index_, panes_->focus())) {
      constexpr double k_gap = 9;
      const QPointF p(at->x + 0.5, at->y + 0.5);
      QColor c = colour_of(kind);
      c.setAlpha(150);
      painter.setPen(QPen(c, 1));
      for (const QPointF& direction : {QPointF(1, 0), QPointF(-1, 0), QPointF(0, 1), QPointF(0, -1)})
        painter.drawLine(p + k_gap * direction, p + 4000 * direction);
    }
  // Draw the tool, except on a held X-ray: the tool and the C-arm may have moved since its exposure.
  if (has_tool_ && panel != nullptr && (kind != PaneKind::xray || panes_->is_live())) {
    const auto tip = panes_->pixel(index_, tool_[0]), end = panes_->pixel(index_, tool_[1]);
    if (tip && end) {
      // The tool is drawn faintly if its tip is not in the plane.
      constexpr double k_in_plane = 2;  // mm
      const bool is_in_plane = !plane || std::abs(plane->height(tool_[0])) < k_in_plane;
      painter.setPen(QPen(QColor(255, 170, 60, is_in_plane ? 255 : 90), 2));
      painter.drawLine(QPointF(tip->x + 0.5, tip->y + 0.5), QPointF(end->x + 0.5, end->y + 0.5));
      painter.setBrush(QColor(255, 170, 60, is_in_plane ? 255 : 0));
      painter.drawEllipse(QPointF(tip->x + 0.5, tip->y + 0.5), 3, 3);
    }
  }
  if (plane && panel != nullptr && overlays_) draw_overlays(painter, *plane);
  if (panel != nullptr) draw_marks(painter);
  painter.setRenderHint(QPainter::Antialiasing, false);
  if (plane && panel != nullptr) {
    const double right = width() - 10.0;
    painter.setPen(QPen(QColor(232, 236, 242), 1.5));
    painter.drawLine(QPointF(bar_left, bar_y), QPointF(right, bar_y));
    for (const double x : {bar_left, right}) painter.drawLine(QPointF(x, bar_y - 4), QPointF(x, bar_y));
  }
  text.draw();
  if (!panes_->problem(index_).empty()) {
    write_text(painter, inner, Qt::AlignCenter | Qt::TextWordWrap, localized(panes_->problem(index_)));
  } else if (panel == nullptr && kind == PaneKind::xray) {
    write_text(painter, inner, Qt::AlignCenter | Qt::TextWordWrap,
               panes_->is_exposing() ? tr("Computing the X-ray ...")
               : shoot_->isEnabled() ? tr("Press Shoot, or switch Live on.")
                                     : shoot_->toolTip());
  }
  painter.setPen(QPen(colour_of(kind), 2));
  painter.drawLine(0, 0, width(), 0);
}

void ImagePane::set_marks(std::vector<glm::dvec3> marks) {
  if (marks == marks_) return;
  marks_ = std::move(marks);
  update();
}

void ImagePane::set_overlays(std::shared_ptr<const sim::Overlays> overlays) {
  if (overlays == overlays_) return;
  overlays_ = std::move(overlays);
  update();
}

void ImagePane::draw_overlays(QPainter& painter, const volume::ImagePlane& plane) const {
  constexpr double k_near = 2;  // mm from the plane
  const auto pixel_of = [&](const glm::dvec3& at) -> std::optional<QPointF> {
    if (std::abs(plane.height(at)) > k_near) return std::nullopt;
    const auto pixel = panes_->pixel(index_, at);
    return pixel ? std::optional(QPointF(pixel->x + 0.5, pixel->y + 0.5)) : std::nullopt;
  };
  const QColor colour(90, 204, 242);
  for (const sim::Overlay& overlay : *overlays_) {
    const bool is_marked =
        overlay.kind == sim::Overlay::Kind::plan || overlay.kind == sim::Overlay::Kind::measure;
    if (!is_marked || overlay.holder >= 0) continue;
    painter.setPen(QPen(colour, 2));
    for (const auto& [from, to] : overlay.lines) {
      const auto a = pixel_of(overlay.placement.world_from_local(from)),
                 b = pixel_of(overlay.placement.world_from_local(to));
      if (a && b) painter.drawLine(*a, *b);
    }
    for (const sim::Overlay::Label& label : overlay.labels)
      if (const auto at = pixel_of(overlay.placement.world_from_local(label.at))) {
        const QString text = QString::fromStdString(label.text);
        const QFontMetrics metrics = fontMetrics();
        const double room = metrics.horizontalAdvance(text) + 8;
        write_text(painter,
                   QRectF(std::min(at->x() + 8, width() - room - 4), at->y() - metrics.height() - 4, room,
                          metrics.height() + 2),
                   Qt::AlignLeft | Qt::AlignVCenter, text, colour);
      }
  }
}

void ImagePane::draw_marks(QPainter& painter) const {
  QPolygonF line;
  for (const glm::dvec3& mark : marks_)
    if (const auto at = panes_->pixel(index_, mark)) line << QPointF(at->x + 0.5, at->y + 0.5);
  const QColor colour(246, 201, 68);
  painter.setPen(QPen(colour, 1.5));
  painter.setBrush(Qt::NoBrush);
  painter.drawPolyline(line);
  painter.setBrush(colour);
  constexpr double k_radius = 3;  // pixels
  for (const QPointF& at : line) painter.drawEllipse(at, k_radius, k_radius);
}

void ImagePane::wheelEvent(QWheelEvent* event) {
  const int direction = event->angleDelta().y() > 0 ? 1 : -1;
  if (event->modifiers() & Qt::ControlModifier) {
    panes_->zoom(index_, direction > 0 ? 1.15 : 1 / 1.15, {event->position().x(), event->position().y()});
  } else {
    panes_->scroll(index_, direction);
  }
  event->accept();
}

void ImagePane::mousePressEvent(QMouseEvent* event) {
  last_ = event->localPos();
  if (event->button() == Qt::LeftButton && event->modifiers() == Qt::NoModifier &&
      imaging::is_planar(panes_->kind(index_)))
    if (const auto at = panes_->world(index_, {last_.x(), last_.y()}); at && on_point(*at)) return;
  mouseMoveEvent(event);
}

void ImagePane::mouseMoveEvent(QMouseEvent* event) {
  const QPointF step = event->localPos() - last_;
  last_ = event->localPos();
  if (panes_->kind(index_) == PaneKind::rendering && event->buttons() != Qt::NoButton)
    return on_turn(0.4 * step.x(), 0.4 * step.y());
  if (!imaging::is_planar(panes_->kind(index_))) return;
  if (event->modifiers() & Qt::ShiftModifier) {
    if (const auto at = panes_->world(index_, {last_.x(), last_.y()})) panes_->set_focus(*at);
  } else if (event->buttons() & Qt::MiddleButton) {
    panes_->pan(index_, {step.x(), step.y()});
  } else if (event->buttons() & Qt::RightButton) {
    panes_->zoom(index_, std::exp(-0.01 * step.y()), {0.5 * width(), 0.5 * height()});
  } else if (event->buttons() & Qt::LeftButton && !step.isNull()) {
    // Motion to the right widens the grey window, motion up brightens the image, in proportion to the width.
    ct_viewer::GreyWindow window = panes_->window();
    const double scale = std::max(1.0, window.width) / 300;
    window.width = std::max(1.0, window.width + scale * step.x()), window.level += scale * step.y();
    panes_->set_window(window);
  }
}

void ImagePane::mouseDoubleClickEvent(QMouseEvent*) { on_maximise(); }

/// Handles keys; they are those of 3D Slicer.
void ImagePane::keyPressEvent(QKeyEvent* event) {
  switch (event->key()) {
    case Qt::Key_Right:
    case Qt::Key_F:
    case Qt::Key_Left:
    case Qt::Key_B:
      panes_->scroll(index_, event->key() == Qt::Key_Right || event->key() == Qt::Key_F ? 1 : -1);
      return;
    case Qt::Key_R:
      panes_->reset(index_);
      return;
    case Qt::Key_G:
      panes_->set_labels(!panes_->has_labels());
      return;
    case Qt::Key_T: {
      const auto next = (static_cast<std::size_t>(panes_->blend()) + 1) % std::size(ct_viewer::k_blends);
      panes_->set_blend(static_cast<ct_viewer::Blend>(next));
      return;
    }
    default:
      event->ignore();
  }
}

/// Gives the keyboard focus to the pane under the cursor.
void ImagePane::enterEvent(QEvent*) { setFocus(); }

}  // namespace trephine::view
