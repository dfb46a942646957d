#include "apps/window/qt_panels.h"

#include <QAbstractSpinBox>
#include <QComboBox>
#include <QCoreApplication>
#include <QFontMetrics>
#include <QHelpEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QPushButton>
#include <QScrollArea>
#include <QStyle>
#include <QStyleOptionSlider>
#include <QToolTip>
#include <QWheelEvent>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace trephine::view {

namespace {

constexpr double k_handle = 6;  // half the width of a slider's handle, pixels

}  // namespace

QPushButton* make_button(const char* name, const QString& text, const QString& tip) {
  auto* button = new QPushButton(text);
  button->setObjectName(name);
  button->setToolTip(tip);
  button->setFocusPolicy(Qt::NoFocus);
  return button;
}

ForceBar::ForceBar(QWidget* parent) : QWidget(parent) {
  setObjectName("force_bar");
  setAccessibleName(tr("Force"));
}

QSize ForceBar::sizeHint() const {
  const int line = fontMetrics().height();
  return {12 * line, 3 * line};
}

void ForceBar::show_force(double newtons, double limit) {
  // To repaint a widget, Qt composes the whole window with its picture again. Repaint only after visible
  // changes.
  const auto hundredths = [](double n) { return std::lround(100 * n); };
  const std::array<long, 3> before{hundredths(force_), hundredths(limit_), hundredths(peak_)};
  force_ = newtons;
  limit_ = limit;
  peak_ = std::max(newtons, 0.985 * peak_);
  if (before == std::array<long, 3>{hundredths(force_), hundredths(limit_), hundredths(peak_)}) return;
  setToolTip(QString("%L1 N").arg(newtons, 0, 'f', 2));
  update();
}

void ForceBar::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  const int line = fontMetrics().height();
  const QRectF bar(0.5, line + 3.5, width() - 1, line);
  painter.setPen(palette().color(QPalette::Mid));
  painter.setBrush(palette().color(QPalette::Base));
  painter.drawRoundedRect(bar, 4, 4);
  const auto x_of = [&](double n) { return bar.left() + bar.width() * std::clamp(n / limit_, 0.0, 1.0); };
  const bool is_strong = force_ > 0.5 * limit_;
  painter.setPen(Qt::NoPen);
  painter.setBrush(is_strong ? QColor(240, 180, 40) : QColor(60, 130, 200));
  painter.drawRoundedRect(QRectF(bar.left(), bar.top(), x_of(force_) - bar.left(), bar.height()), 4, 4);
  painter.setPen(QPen(palette().color(QPalette::WindowText), 2));
  painter.drawLine(QPointF(x_of(peak_), bar.top() - 2), QPointF(x_of(peak_), bar.bottom() + 2));
  painter.setPen(palette().color(QPalette::WindowText));
  painter.drawText(QRectF(0, 0, width(), line + 2), Qt::AlignLeft | Qt::AlignVCenter, tr("Force"));
  painter.drawText(
      QRectF(0, 0, width(), line + 2), Qt::AlignRight | Qt::AlignVCenter,
      (force_ >= 0.98 * limit_ ? tr("%L1 N, at its limit") : QString("%L1 N")).arg(force_, 0, 'f', 2));
}

double MarkedSlider::x_of(int value) const {
  const double share =
      maximum() > minimum() ? static_cast<double>(value - minimum()) / (maximum() - minimum()) : 0.0;
  return k_handle + share * (width() - 2 * k_handle);
}

int MarkedSlider::value_at(double x) const {
  for (const Mark& mark : marks_)
    if (std::abs(x_of(mark.value) - x) < k_near) return mark.value;
  const double share = std::clamp((x - k_handle) / std::max(1.0, width() - 2 * k_handle), 0.0, 1.0);
  return minimum() + static_cast<int>(std::lround(share * (maximum() - minimum())));
}

void MarkedSlider::mousePressEvent(QMouseEvent* event) {
  QStyleOptionSlider option;
  initStyleOption(&option);
  const QRect handle = style()->subControlRect(QStyle::CC_Slider, &option, QStyle::SC_SliderHandle, this);
  if (event->button() == Qt::LeftButton && !handle.contains(event->pos())) {
    setSliderPosition(value_at(event->pos().x()));
    triggerAction(SliderMove);
  }
  QSlider::mousePressEvent(event);  // the handle under the cursor can be dragged
}

void MarkedSlider::paintEvent(QPaintEvent* event) {
  QSlider::paintEvent(event);
  QPainter painter(this);
  // Marks of danger are drawn last and larger, so that no mark nearby hides them.
  for (const bool is_danger : {false, true})
    for (const Mark& mark : marks_) {
      if ((mark.colour == k_danger) != is_danger) continue;
      painter.setPen(QPen(QColor(mark.colour), is_danger ? 3 : 2));
      const double x = x_of(mark.value);
      painter.drawLine(QPointF(x, 1), QPointF(x, is_danger ? 8 : 6));
    }
}

bool MarkedSlider::event(QEvent* event) {
  if (event->type() != QEvent::ToolTip) return QSlider::event(event);
  auto* help = static_cast<QHelpEvent*>(event);
  QStringList texts;
  for (const Mark& mark : marks_)
    if (std::abs(x_of(mark.value) - help->pos().x()) < k_near && texts.size() < 6)
      texts << QString("%L1 s   %2").arg(1e-3 * mark.value, 0, 'f', 1).arg(mark.text);
  texts.isEmpty() ? QToolTip::hideText() : QToolTip::showText(help->globalPos(), texts.join("\n"), this);
  return true;
}

FoldButton::FoldButton(const char* name, const QString& text, QWidget* parent) : QToolButton(parent) {
  setObjectName(name);
  setText(text);
  setCheckable(true);
  setArrowType(Qt::RightArrow);
  setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
  setAutoRaise(true);
  setFocusPolicy(Qt::NoFocus);
  connect(this, &QToolButton::toggled, this, [this](bool is_open) {
    setArrowType(is_open ? Qt::DownArrow : Qt::RightArrow);
    on_fold(is_open);
  });
}

WheelScrolls::WheelScrolls(QScrollArea* area) : QObject(area), area_(area) {
  QCoreApplication::instance()->installEventFilter(this);
}

bool WheelScrolls::eventFilter(QObject* object, QEvent* event) {
  if (event->type() != QEvent::Wheel) return false;
  const auto* widget = qobject_cast<QWidget*>(object);
  const bool has_value = qobject_cast<QComboBox*>(object) != nullptr ||
                         qobject_cast<QAbstractSpinBox*>(object) != nullptr ||
                         qobject_cast<QSlider*>(object) != nullptr;
  if (widget == nullptr || !has_value || !area_->isAncestorOf(widget)) return false;
  event->ignore();  // the parents receive it next
  return true;
}

HelpOverlay::HelpOverlay(QWidget* parent) : QWidget(parent) {
  setObjectName("help_overlay");
  hide();
}

void HelpOverlay::paintEvent(QPaintEvent*) {
  static const std::pair<const char*, const char*> k_rows[] = {
      {QT_TR_NOOP("Move the mouse"), QT_TR_NOOP("move the tool over the bone under the cursor")},
      {QT_TR_NOOP("Hold left, or Space"), QT_TR_NOOP("press the tool into the bone: touch and drill")},
      {QT_TR_NOOP("Arrows (Shift: 0.2 mm)"), QT_TR_NOOP("move the tip by 1 mm")},
      {QT_TR_NOOP("Wheel, PgUp, PgDn"),
       QT_TR_NOOP("change the depth of a press or of an inserted tool; slide a Kerrison's foot")},
      {QT_TR_NOOP("Drag middle,  W A S D"),
       QT_TR_NOOP("tilt the tool; turn it about its shaft: middle button + wheel, or  ,  and  .")},
      {QT_TR_NOOP("K"), QT_TR_NOOP("hold the shaft upright on the bone, toward you, or fixed")},
      {QT_TR_NOOP("Drag right, Ctrl + arrows"), QT_TR_NOOP("turn the picture; Shift + right: move it")},
      {QT_TR_NOOP("Ctrl + wheel"), QT_TR_NOOP("zoom")},
      {QT_TR_NOOP("+  and  -"), QT_TR_NOOP("select a larger or a smaller burr")},
      {QT_TR_NOOP("Ctrl+Z, Ctrl+Y  (U, Y)"), QT_TR_NOOP("undo or redo a change")},
      {QT_TR_NOOP("Ctrl+B, Ctrl+G"), QT_TR_NOOP("start a branch here; go to another branch")},
      {QT_TR_NOOP("Ctrl+D"), QT_TR_NOOP("compare with another state")},
      {QT_TR_NOOP("M, Ctrl+Shift+A, Ctrl+Shift+T"),
       QT_TR_NOOP("ruler, angle, tape: click positions, in the picture or in slices")},
      {QT_TR_NOOP("Backspace, Enter, Esc"),
       QT_TR_NOOP("while positions are marked: remove the last one; finish; cancel")},
      {QT_TR_NOOP("Ctrl+R"), QT_TR_NOOP("structures: show, hide, make translucent")},
      {QT_TR_NOOP("Ctrl+1"), QT_TR_NOOP("add an anchor of a bone flap at the touched position")},
      {QT_TR_NOOP("Ctrl+2, Ctrl+3 ..."),
       QT_TR_NOOP("further commands at the touched position: see the menu Commands")},
      {QT_TR_NOOP("Shift + left,  G"), QT_TR_NOOP("drag a touched anchor or pin; grasp or release it")},
      {QT_TR_NOOP("Ctrl+F,  T"),
       QT_TR_NOOP("detach cut pieces; grasp or release the touched piece (Shift+T: put it back)")},
      {QT_TR_NOOP("Ctrl + Enter"), QT_TR_NOOP("go to the next step of the procedure")},
      {QT_TR_NOOP("Shift + A P L R S I,  0"),
       QT_TR_NOOP("view from the front, back, left, right, above, below; whole scan")},
      {QT_TR_NOOP("C"), QT_TR_NOOP("clip the picture")},
      {QT_TR_NOOP("F5 to F9"),
       QT_TR_NOOP("show the picture alone; with slices; X-ray and section; volume rendering; depth images")},
      {QT_TR_NOOP("Wheel, Left, Right, B, F"), QT_TR_NOOP("in a slice: show the previous or next slice")},
      {QT_TR_NOOP("Shift + mouse, left, middle, right"),
       QT_TR_NOOP("in a slice: show all slices through it; change the windowing; move; zoom")},
      {QT_TR_NOOP("T, G, R, double click"),
       QT_TR_NOOP("in a slice: show before and after; labels; the whole scan; maximise")},
      {QT_TR_NOOP("E,  N"), QT_TR_NOOP("show or hide the event log; names of the plan: in front, all, none")},
      {QT_TR_NOOP("X,  Ctrl+N"),
       QT_TR_NOOP("in a paused replay: why this force? (its parts, friction, limits); note at this time")},
      {QT_TR_NOOP("F"), QT_TR_NOOP("turn the force of a haptic device on again after a fault")},
      {QT_TR_NOOP("Ctrl+O, or drop a folder"), QT_TR_NOOP("open a scan (a file: Ctrl+Shift+O)")},
      {QT_TR_NOOP("Ctrl+S, Ctrl+P"), QT_TR_NOOP("save the operated volume; the picture")},
      {QT_TR_NOOP("Ctrl + +, Ctrl + -"), QT_TR_NOOP("use larger or smaller text")},
      {QT_TR_NOOP("F12"), QT_TR_NOOP("score of the operation so far, and its report")},
      {QT_TR_NOOP("F1"), QT_TR_NOOP("show this help")}};
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  QFont font = this->font();
  // The font size is that of the window, or up to a quarter smaller if the table does not fit. A table that
  // is still too high can be scrolled; one that is too wide gets a smaller font.
  const int rows = static_cast<int>(std::size(k_rows));
  const double smallest = 0.75 * font.pointSizeF();
  int line = 0, left = 0, right = 0, gap = 0;
  QRect box;
  for (;;) {
    const QFontMetrics metrics(font);
    line = static_cast<int>(1.55 * metrics.height());
    gap = metrics.height();
    left = right = 0;
    for (const auto& [key, meaning] : k_rows)
      left = std::max(left, metrics.horizontalAdvance(tr(key))),
      right = std::max(right, metrics.horizontalAdvance(tr(meaning)));
    box = QRect(0, 0, left + right + 5 * gap, (rows + 1) * line + 2 * gap);
    const bool is_too_wide = box.width() > width(), is_too_high = box.height() > height();
    if (font.pointSizeF() < 6 || (!is_too_wide && (!is_too_high || font.pointSizeF() <= smallest))) break;
    font.setPointSizeF(0.95 * font.pointSizeF());
  }
  painter.setFont(font);
  hidden_height_ = std::max(0, box.height() - height());
  scrolled_ = std::clamp(scrolled_, 0, hidden_height_);
  QRect placed = QRect(rect().center() - box.center(), box.size());
  if (hidden_height_ > 0) placed.moveTop(-scrolled_);
  painter.setPen(QColor(255, 255, 255, 60));
  painter.setBrush(QColor(18, 22, 30, 248));
  painter.drawRoundedRect(placed, 12, 12);
  int y = placed.top() + gap;
  for (const auto& [key, meaning] : k_rows) {
    painter.setPen(QColor(246, 201, 68));
    painter.drawText(QRect(placed.left() + 2 * gap, y, left, line), Qt::AlignRight | Qt::AlignVCenter,
                     tr(key));
    painter.setPen(QColor(236, 239, 244));
    painter.drawText(QRect(placed.left() + 3 * gap + left, y, right, line), Qt::AlignLeft | Qt::AlignVCenter,
                     tr(meaning));
    y += line;
  }
  QRect footer(placed.left(), y, placed.width(), line);
  if (hidden_height_ > 0) {
    footer.moveBottom(rect().bottom());
    painter.fillRect(footer, QColor(40, 46, 58));
  }
  painter.setPen(QColor(190, 198, 210));
  painter.drawText(footer, Qt::AlignCenter,
                   hidden_height_ > 0 ? tr("wheel: scroll; click: close") : tr("click to close"));
}

void HelpOverlay::wheelEvent(QWheelEvent* event) {
  scrolled_ = std::clamp(scrolled_ - event->angleDelta().y() / 2, 0, hidden_height_);
  update();
}

}  // namespace trephine::view
