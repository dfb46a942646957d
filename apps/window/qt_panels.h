// Small widgets of the window: force bar, slider with marks, fold button, help overlay.
#pragma once

#include <QSlider>
#include <QToolButton>
#include <QWidget>
#include <functional>
#include <vector>

class QScrollArea;

namespace trephine::view {

/// Force as a bar with its limit: blue, yellow from half of the limit, with a text at the limit, so that the
/// user does not depend on colour or length alone.
class ForceBar : public QWidget {
  Q_OBJECT

 public:
  explicit ForceBar(QWidget* parent = nullptr);
  /// `newtons`: force, N. `limit`: largest force that is sent to a device, N.
  void show_force(double newtons, double limit);
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override { return sizeHint(); }

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  double force_ = 0, limit_ = 8, peak_ = 0;
};

/// A horizontal slider with marks of events: amber, or red for dangers. Tool tips show the texts of marks. A
/// click moves the handle to the position of the click, or to a mark near it.
class MarkedSlider : public QSlider {
  Q_OBJECT

 public:
  explicit MarkedSlider(QWidget* parent = nullptr) : QSlider(Qt::Horizontal, parent) {}
  static constexpr QRgb k_danger = 0xffff5c50, k_event = 0xfff6c944, k_note = 0xff6fa8dc;
  void add_mark(int value, QRgb colour, const QString& text) { marks_.push_back({value, colour, text}); }
  void clear_marks() {
    marks_.clear();
    update();
  }

 protected:
  void paintEvent(QPaintEvent* event) override;
  bool event(QEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;

 private:
  static constexpr double k_near = 5;  // pixels around a mark
  struct Mark {
    int value;
    QRgb colour;
    QString text;
  };
  double x_of(int value) const;
  int value_at(double x) const;
  std::vector<Mark> marks_;
};

/// A button with an arrow that shows or hides widgets, by on_fold.
class FoldButton : public QToolButton {
  Q_OBJECT

 public:
  FoldButton(const char* name, const QString& text, QWidget* parent = nullptr);
  std::function<void(bool is_open)> on_fold = [](bool) {};
};

/// Makes the wheel scroll an area also over its boxes and sliders, whose values it then does not change.
class WheelScrolls : public QObject {
  Q_OBJECT

 public:
  explicit WheelScrolls(QScrollArea* area);
  bool eventFilter(QObject* object, QEvent* event) override;

 private:
  QScrollArea* area_;
};

/// Help on keys and mouse in two columns, over the window; a click or a key closes it.
class HelpOverlay : public QWidget {
  Q_OBJECT

 public:
  explicit HelpOverlay(QWidget* parent);

 protected:
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent*) override { hide(); }
};

}  // namespace trephine::view
