// The window of a virtual device, see apps/view/virtual_device_page.h.
#include <QApplication>
#include <QKeyEvent>
#include <QLabel>
#include <QMouseEvent>
#include <QPainter>
#include <QPainterPath>
#include <QPushButton>
#include <QTimer>
#include <QVBoxLayout>
#include <QWheelEvent>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "apps/view/render_window.h"
#include "apps/view/view_window.h"
#include "apps/view/virtual_device_page.h"
#include "apps/window/qt_application.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::view {

namespace {

using glm::dvec3;
using Host = workbench::VirtualDeviceHost;

constexpr double k_radius = haptics::SharedDevice::k_workspace_radius;

const QColor k_force_colour(214, 60, 52), k_torque_colour(44, 150, 72), k_tool_colour(70, 110, 160);

glm::dquat turn_about(const dvec3& axis, double angle) {
  return glm::dquat(std::cos(angle / 2), std::sin(angle / 2) * axis);
}

/// Returns the convex hull of points (Andrew's monotone chain).
QPolygonF hull_of(QPolygonF points) {
  std::sort(points.begin(), points.end(), [](const QPointF& a, const QPointF& b) {
    return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
  });
  QPolygonF hull;
  for (int pass = 0; pass < 2; ++pass) {
    const int first = hull.size();
    for (const QPointF& p : points) {
      while (hull.size() >= first + 2) {
        const QPointF a = hull[hull.size() - 1] - hull[hull.size() - 2], b = p - hull.back();
        if (a.x() * b.y() - a.y() * b.x() > 0) break;
        hull.removeLast();
      }
      hull << p;
    }
    hull.removeLast();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// The workspace and the tool, viewed from above right. Device frame: x to the right, y up, z toward the
/// user.
class Workspace final : public QWidget {
 public:
  Workspace(Host& host, bool is_moved) : host_(host), is_moved_(is_moved) {
    setMinimumSize(480, 400);
    setFocusPolicy(Qt::StrongFocus);
    setObjectName("workspace");
    request_ = host.state().request;
  }

  void show_state(const Host::State& state) {
    state_ = state;
    update();
  }
  void centre() {
    request_.position_world = dvec3(0);
    request_.orientation = glm::dquat(1, 0, 0, 0);
    send();
  }

 protected:
  void paintEvent(QPaintEvent*) override {
    QPainter painter(this);
    painter.setRenderHint(QPainter::Antialiasing);
    painter.fillRect(rect(), QColor(247, 248, 250));
    draw_workspace(painter);
    const dvec3 tip = state_.pose.position_world;
    painter.setPen(QPen(QColor(170, 176, 186), 1, Qt::DashLine));
    painter.drawLine(at(dvec3(0)), at(tip));
    draw_shadow(painter, tip);
    // The requested pose as a wireframe, and the pose of the hand, which yields to forces.
    const bool is_apart = glm::length(state_.request.position_world - tip) > 0.5 || angle_apart() > 0.02;
    if (is_apart) draw_tool(painter, state_.request, true);
    draw_tool(painter, state_.pose, false);
    draw_arrow(painter, tip, state_.wrench.force_world, 8, k_force_colour);
    // A logarithmic length keeps both small and large torques visible.
    const double torque = glm::length(state_.wrench.torque_world);
    if (torque > 0)
      draw_arrow(painter, tip, state_.wrench.torque_world * (std::log1p(torque) / torque), 8,
                 k_torque_colour);
  }

  void mousePressEvent(QMouseEvent* event) override { last_ = event->pos(); }
  void mouseMoveEvent(QMouseEvent* event) override {
    const QPoint moved = event->pos() - last_;
    last_ = event->pos();
    const double mm = 1 / scale();
    const bool is_shifted = event->modifiers() & Qt::ShiftModifier;
    if (event->buttons() & Qt::MiddleButton ||
        (event->buttons() & Qt::LeftButton && event->modifiers() & Qt::ControlModifier)) {
      constexpr double k_turn = 0.01;  // rad per pixel
      turn({0, 1, 0}, k_turn * moved.x());
      turn({1, 0, 0}, k_turn * moved.y());
    } else if (event->buttons() & Qt::RightButton || (event->buttons() & Qt::LeftButton && is_shifted)) {
      move({mm * moved.x(), 0, mm * moved.y()});
    } else if (event->buttons() & Qt::LeftButton) {
      move({mm * moved.x(), -mm * moved.y(), 0});
    }
  }
  void wheelEvent(QWheelEvent* event) override { turn({0, 0, 1}, event->angleDelta().y() * 0.0015); }
  void keyPressEvent(QKeyEvent* event) override {
    constexpr double k_step = 1, k_turn = 0.05;  // mm, rad
    const bool is_turn = event->modifiers() & Qt::ShiftModifier;
    const auto act = [&](const dvec3& motion, const dvec3& axis, double sign) {
      is_turn ? turn(axis, sign * k_turn) : move(k_step * motion);
    };
    switch (event->key()) {
      case Qt::Key_Left:
        return act({-1, 0, 0}, {0, 1, 0}, -1);
      case Qt::Key_Right:
        return act({1, 0, 0}, {0, 1, 0}, 1);
      case Qt::Key_Up:
        return act({0, 1, 0}, {1, 0, 0}, -1);
      case Qt::Key_Down:
        return act({0, -1, 0}, {1, 0, 0}, 1);
      case Qt::Key_PageUp:
        return act({0, 0, -1}, {0, 0, 1}, 1);
      case Qt::Key_PageDown:
        return act({0, 0, 1}, {0, 0, 1}, -1);
      case Qt::Key_Space:
        if (!event->isAutoRepeat()) press(true);
        return;
      case Qt::Key_Home:
        return centre();
      default:
        QWidget::keyPressEvent(event);
    }
  }
  void keyReleaseEvent(QKeyEvent* event) override {
    if (event->key() == Qt::Key_Space && !event->isAutoRepeat()) press(false);
  }
  void focusOutEvent(QFocusEvent*) override { press(false); }

 private:
  double scale() const { return 0.35 * std::min(width(), height()) / k_radius; }
  /// Returns a position in the picture: an orthographic view, turned by 25 degrees and tilted by 20.
  QPointF at(const dvec3& p) const {
    constexpr double k_turn = 25 * std::numbers::pi / 180, k_tilt = 20 * std::numbers::pi / 180;
    const double x = std::cos(k_turn) * p.x - std::sin(k_turn) * p.z;
    const double depth = std::sin(k_turn) * p.x + std::cos(k_turn) * p.z;
    const double y = std::cos(k_tilt) * p.y - std::sin(k_tilt) * depth;
    return {0.5 * width() + scale() * x, 0.5 * height() - scale() * y};
  }
  double angle_apart() const {
    return glm::length(haptics::turn_between(haptics::unit_of(state_.request.orientation),
                                             haptics::unit_of(state_.pose.orientation)));
  }

  void draw_workspace(QPainter& painter) const {
    // A floor with lines 20 mm apart, and a box around the workspace.
    constexpr double k_line = 20;
    painter.setPen(QPen(QColor(222, 226, 232), 1));
    for (double p = -k_radius; p <= k_radius; p += k_line) {
      painter.drawLine(at({p, -k_radius, -k_radius}), at({p, -k_radius, k_radius}));
      painter.drawLine(at({-k_radius, -k_radius, p}), at({k_radius, -k_radius, p}));
    }
    painter.setPen(QPen(QColor(176, 184, 196), 1));
    for (int corner = 0; corner < 8; ++corner)
      for (int axis = 0; axis < 3; ++axis) {
        if (corner >> axis & 1) continue;
        const auto point = [](int c) {
          return k_radius * dvec3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
        };
        painter.drawLine(at(point(corner)), at(point(corner | 1 << axis)));
      }
    const std::array<std::pair<dvec3, QString>, 3> axes{{{{1, 0, 0}, QObject::tr("right")},
                                                         {{0, 1, 0}, QObject::tr("up")},
                                                         {{0, 0, 1}, QObject::tr("toward you")}}};
    painter.setPen(QPen(QColor(60, 68, 80), 2));
    for (const auto& [axis, name] : axes) {
      // In a corner of the floor, where the tool does not hide them.
      const dvec3 corner = k_radius * dvec3(-1, -1, 1);
      painter.drawLine(at(corner), at(corner + 25.0 * axis));
      painter.drawText(at(corner + 28.0 * axis) + QPointF(axis.y > 0 ? 6 : 2, axis.z > 0 ? 12 : 4), name);
    }
  }
  void draw_shadow(QPainter& painter, const dvec3& tip) const {
    const dvec3 below(tip.x, -k_radius, tip.z);
    painter.setPen(QPen(QColor(200, 206, 214), 1, Qt::DotLine));
    painter.drawLine(at(tip), at(below));
    painter.setPen(Qt::NoPen);
    painter.setBrush(QColor(150, 158, 170));
    painter.drawEllipse(at(below), 4, 2);
    painter.setBrush(Qt::NoBrush);
  }

  /// A drill: a cone at the tip and a handle, with a mark that shows its roll.
  void draw_tool(QPainter& painter, const haptics::Pose& pose, bool is_wireframe) const {
    const glm::dquat turn = haptics::unit_of(pose.orientation);
    // Position along the axis and radius of the circles of the body, mm.
    static constexpr std::array<std::array<double, 2>, 5> k_rings{
        {{0, 0.4}, {8, 2.5}, {9, 5}, {55, 6}, {60, 4}}};
    constexpr int k_around = 20;
    const auto ring = [&](const std::array<double, 2>& one) {
      QPolygonF points;
      for (int i = 0; i < k_around; ++i) {
        const double a = 2 * std::numbers::pi * i / k_around;
        points << at(pose.position_world + turn * dvec3(one[1] * std::cos(a), one[1] * std::sin(a), one[0]));
      }
      return points;
    };
    if (is_wireframe) {
      painter.setPen(QPen(QColor(140, 150, 165), 1));
      for (const auto& one : k_rings) painter.drawPolygon(ring(one));
      for (int i = 0; i < 4; ++i) {
        const double a = std::numbers::pi / 2 * i;
        for (std::size_t r = 0; r + 1 < k_rings.size(); ++r)
          painter.drawLine(
              at(pose.position_world +
                 turn * dvec3(k_rings[r][1] * std::cos(a), k_rings[r][1] * std::sin(a), k_rings[r][0])),
              at(pose.position_world + turn * dvec3(k_rings[r + 1][1] * std::cos(a),
                                                    k_rings[r + 1][1] * std::sin(a), k_rings[r + 1][0])));
      }
      return;
    }
    // The outline of each part is the hull of its two circles; the far part is drawn first.
    const bool is_toward_viewer = (turn * dvec3(0, 0, 1)).z > 0;
    for (std::size_t n = 0; n + 1 < k_rings.size(); ++n) {
      const std::size_t r = is_toward_viewer ? n : k_rings.size() - 2 - n;
      painter.setPen(QPen(k_tool_colour.darker(140), 1));
      painter.setBrush(r == 0 ? QColor(190, 196, 206) : r == 2 ? k_tool_colour : k_tool_colour.lighter(125));
      painter.drawPolygon(hull_of(ring(k_rings[r]) + ring(k_rings[r + 1])));
    }
    painter.setBrush(Qt::NoBrush);
    painter.setPen(QPen(QColor(245, 200, 60), 3));
    painter.drawLine(at(pose.position_world + turn * dvec3(0, 5.2, 14)),
                     at(pose.position_world + turn * dvec3(0, 5.9, 48)));
    if (pose.is_pressed()) {
      painter.setPen(Qt::NoPen);
      painter.setBrush(QColor(245, 160, 40));
      painter.drawEllipse(at(pose.position_world), 6, 6);
      painter.setBrush(Qt::NoBrush);
    }
  }
  void draw_arrow(QPainter& painter, const dvec3& from, const dvec3& vector, double mm_per_unit,
                  const QColor& colour) const {
    const QPointF start = at(from), end = at(from + mm_per_unit * vector);
    const QPointF along = end - start;
    const double length = std::hypot(along.x(), along.y());
    if (length < 2) return;
    painter.setPen(QPen(colour, 3, Qt::SolidLine, Qt::RoundCap));
    painter.drawLine(start, end);
    const QPointF back = along * (-9 / length), side(-back.y() * 0.5, back.x() * 0.5);
    painter.drawLine(end, end + back + side);
    painter.drawLine(end, end + back - side);
  }

  void move(const dvec3& by) {
    request_.position_world = glm::clamp(request_.position_world + by, dvec3(-k_radius), dvec3(k_radius));
    send();
  }
  void turn(const dvec3& axis, double angle) {
    request_.orientation = haptics::unit_of(turn_about(axis, angle) * request_.orientation);
    send();
  }
  void press(bool is_pressed) {
    request_.press(is_pressed);
    send();
  }
  void send() {
    if (is_moved_) host_.request(request_);
  }

  Host& host_;
  const bool is_moved_;
  Host::State state_;
  haptics::Pose request_;
  QPoint last_;
};

/// Magnitudes of force and torque over the last seconds: the mean of each interval, and the mean plus the
/// standard deviation, which is higher if the device vibrates.
class Graph final : public QWidget {
 public:
  explicit Graph(Host& host) : host_(host) {
    setMinimumHeight(150);
    setObjectName("graph");
  }

 protected:
  void paintEvent(QPaintEvent*) override {
    QPainter painter(this);
    painter.setRenderHint(QPainter::Antialiasing);
    painter.fillRect(rect(), Qt::white);
    const std::vector<workbench::WrenchInterval> intervals = host_.intervals();
    const int half = width() / 2;
    draw(
        painter, QRect(0, 0, half, height()), QObject::tr("Force (N)"), intervals,
        [](const workbench::WrenchInterval& one) { return std::pair(one.mean_force, one.noisy_force); }, 2,
        k_force_colour);
    draw(
        painter, QRect(half, 0, width() - half, height()), QObject::tr("Torque (N mm)"), intervals,
        [](const workbench::WrenchInterval& one) { return std::pair(one.mean_torque, one.noisy_torque); }, 20,
        k_torque_colour);
  }

 private:
  template <class Values>
  void draw(QPainter& painter, const QRect& area, const QString& title,
            const std::vector<workbench::WrenchInterval>& intervals, Values values, double least_range,
            const QColor& colour) const {
    const QFontMetrics letters(font());
    const QRect plot = area.adjusted(letters.horizontalAdvance("0000") + 12, letters.height() + 10, -14,
                                     -letters.height() - 8);
    double highest = least_range;
    for (const auto& one : intervals) highest = std::max(highest, values(one).second);
    // The range is 1, 2 or 5 times a power of ten.
    double range = std::pow(10, std::floor(std::log10(highest)));
    for (const double factor : {1.0, 2.0, 5.0, 10.0})
      if (range * factor >= highest) {
        range *= factor;
        break;
      }
    painter.setPen(QColor(70, 78, 90));
    painter.drawText(QPoint(plot.left(), area.top() + letters.ascent() + 4), title);
    painter.setPen(QPen(QColor(228, 231, 236), 1));
    for (int line = 0; line <= 2; ++line) {
      const double y = plot.bottom() - 0.5 * line * plot.height();
      painter.setPen(QPen(QColor(228, 231, 236), 1));
      painter.drawLine(QPointF(plot.left(), y), QPointF(plot.right(), y));
      painter.setPen(QColor(110, 118, 130));
      painter.drawText(
          QRectF(area.left(), y - letters.height() / 2.0, plot.left() - area.left() - 6, letters.height()),
          Qt::AlignRight | Qt::AlignVCenter, QString::number(0.5 * line * range));
    }
    painter.drawText(QRect(plot.left(), plot.bottom() + 4, plot.width(), letters.height()), Qt::AlignRight,
                     QObject::tr("last %1 s").arg(Host::k_intervals * Host::k_interval));
    QPainterPath mean, noisy;
    for (std::size_t i = 0; i < intervals.size(); ++i) {
      const double x = plot.right() - plot.width() * static_cast<double>(intervals.size() - 1 - i) /
                                          static_cast<double>(Host::k_intervals - 1);
      const auto [low, high] = values(intervals[i]);
      const auto point = [&](double value) {
        return QPointF(x, plot.bottom() - plot.height() * value / range);
      };
      i == 0 ? mean.moveTo(point(low)) : mean.lineTo(point(low));
      i == 0 ? noisy.moveTo(point(high)) : noisy.lineTo(point(high));
    }
    QColor light = colour;
    light.setAlpha(110);
    painter.setPen(QPen(light, 1));
    painter.drawPath(noisy);
    painter.setPen(QPen(colour, 1.6));
    painter.drawPath(mean);
    // A legend below the plot, at its left.
    const QString mean_name = QObject::tr("mean"), noisy_name = QObject::tr("mean + deviation");
    int x = plot.left();
    const int y = plot.bottom() + 4 + letters.ascent();
    for (const auto& [name, line] : {std::pair(mean_name, colour), std::pair(noisy_name, light)}) {
      painter.setPen(QPen(line, 2));
      painter.drawLine(x, y - letters.ascent() / 3, x + 18, y - letters.ascent() / 3);
      painter.setPen(QColor(70, 78, 90));
      painter.drawText(x + 23, y, name);
      x += 23 + letters.horizontalAdvance(name) + 14;
    }
  }

  Host& host_;
};

class VirtualDeviceWindow final : public QWidget {
 public:
  VirtualDeviceWindow(Host& host, const VirtualDevicePageOptions& options) : host_(host) {
    setObjectName("virtual_device");
    setWindowTitle(QObject::tr("Virtual device %1").arg(QString::fromStdString(options.device)));
    auto* column = new QVBoxLayout(this);
    column->setContentsMargins(0, 0, 0, 0);
    column->setSpacing(0);
    auto* bar = new QHBoxLayout;
    bar->setContentsMargins(14, 8, 14, 8);
    state_ = new QLabel;
    state_->setObjectName("device_state");
    values_ = new QLabel;
    values_->setObjectName("device_values");
    auto* centre = new QPushButton(QObject::tr("Centre"));
    centre->setObjectName("device_centre");
    centre->setFocusPolicy(Qt::NoFocus);
    centre->setEnabled(options.is_moved);
    state_->setWordWrap(true);
    bar->addWidget(state_, 1);
    bar->addWidget(values_);
    bar->addSpacing(16);
    bar->addWidget(centre);
    workspace_ = new Workspace(host, options.is_moved);
    graph_ = new Graph(host);
    auto* help = new QLabel(
        options.is_moved
            ? QObject::tr(
                  "Drag: right and up. Drag with the right button: right and toward you. Drag with the "
                  "middle button, or Ctrl: turn. Wheel: roll. Arrows, Page Up, Page Down: move; with "
                  "Shift: turn. Space: button of the tool. Home: centre.")
            : QObject::tr("The tool follows a recorded motion or an attached device."));
    help->setWordWrap(true);
    help->setContentsMargins(14, 8, 14, 10);
    column->addLayout(bar);
    column->addWidget(workspace_, 1);
    column->addWidget(graph_);
    column->addWidget(help);
    QObject::connect(centre, &QPushButton::clicked, this, [this] { workspace_->centre(); });
    device_ = QString::fromStdString(options.device);
    resize(760, 820);
    refresh();
    workspace_->setFocus();
  }

  void refresh() {
    const Host::State state = host_.state();
    state_->setText(
        state.is_connected
            ? QObject::tr("A program uses this device.")
            : QObject::tr("No program uses this device. Start one with --device %1.").arg(device_));
    values_->setText(QObject::tr("%1 N   %2 N mm")
                         .arg(glm::length(state.wrench.force_world), 0, 'f', 2)
                         .arg(glm::length(state.wrench.torque_world), 0, 'f', 0));
    workspace_->show_state(state);
    graph_->update();
  }

 private:
  Host& host_;
  QLabel *state_, *values_;
  Workspace* workspace_;
  Graph* graph_;
  QString device_;
};

}  // namespace

}  // namespace trephine::view

extern "C" trephine::Status trephine_show_virtual_device(
    trephine::workbench::VirtualDeviceHost& host, const trephine::view::VirtualDevicePageOptions& options);

/// Entry point of this library, which show_virtual_device() finds by name.
trephine::Status trephine_show_virtual_device(trephine::workbench::VirtualDeviceHost& host,
                                              const trephine::view::VirtualDevicePageOptions& options) {
  using namespace trephine::view;
  const auto application = begin_application(!has_display(), options.language);
  VirtualDeviceWindow window(host, options);
  window.show();
  QTimer timer;
  const auto begin = std::chrono::steady_clock::now();
  QObject::connect(&timer, &QTimer::timeout, &window, [&] {
    window.refresh();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (options.should_close() || (options.seconds && seconds > *options.seconds))
      QApplication::closeAllWindows();
  });
  constexpr int k_frame_ms = 16;
  timer.start(k_frame_ms);
  QApplication::exec();
  if (options.screenshot.empty() || window.grab().save(QString::fromStdString(options.screenshot), "PNG"))
    return std::nullopt;
  return trephine::Error{.what = "the picture cannot be saved",
                         .where = trephine::data_tools::file_name(options.screenshot),
                         .remedy = "choose a folder that exists, with free space",
                         .kind = trephine::ErrorKind::missing_here};
}
