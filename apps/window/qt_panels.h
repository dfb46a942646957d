// Small widgets of the window: force bar, slider with marks, fold button, scrolling by the wheel, help
// overlay.
#pragma once

#include <QSlider>
#include <QToolButton>
#include <QWidget>
#include <functional>
#include <vector>

class QPushButton;
class QScrollArea;

namespace trephine::view {

/// Shows the force as a bar. The bar is blue, and yellow above half of the limit of the force. At the limit a
/// text is added, so that the user does not depend on colour or length alone.
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

/// A horizontal slider with marks: red for dangers, amber for other events, blue for notes. Tool tips show
/// the texts of marks. A click moves the handle to the position of the click, or to a mark near this
/// position.
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

/// Creates a button that does not take the focus of the keyboard.
QPushButton* make_button(const char* name, const QString& text, const QString& tip);

/// A button with an arrow. A click calls on_fold, which shows or hides widgets.
class FoldButton : public QToolButton {
  Q_OBJECT

 public:
  FoldButton(const char* name, const QString& text, QWidget* parent = nullptr);
  std::function<void(bool is_open)> on_fold = [](bool) {};
};

/// Makes the wheel scroll an area even if the cursor is over a combo box, spin box or slider in this area.
/// The wheel then does not change the value of that widget.
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
  void wheelEvent(QWheelEvent* event) override;
  void showEvent(QShowEvent*) override { scrolled_ = 0; }

 private:
  int scrolled_ = 0,
      hidden_height_ = 0;  ///< pixels by which the table is moved up; its part below the window
};

}  // namespace trephine::view
