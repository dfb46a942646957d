// Small widgets of the window: the force bar, and the controls of the picture.
#pragma once

#include <QSlider>
#include <QWidget>
#include <vector>

namespace trephine::view {

/// Force in newtons as a bar with its limit; blue, yellow from half of the limit on, and marked at the limit,
/// so that neither colour nor length alone says it.
class ForceBar : public QWidget {
  Q_OBJECT

 public:
  explicit ForceBar(QWidget* parent = nullptr);
  /// N; `limit` is the most that a device would be asked for.
  void show_force(double newtons, double limit);
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override { return sizeHint(); }

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  double force_ = 0, limit_ = 8, peak_ = 0;
};

/// A horizontal slider with marks of what happened when: amber, red where it is a danger. The mark under the
/// mouse shows its text.
class MarkedSlider : public QSlider {
  Q_OBJECT

 public:
  explicit MarkedSlider(QWidget* parent = nullptr) : QSlider(Qt::Horizontal, parent) {}
  void add_mark(int value, bool is_danger, const QString& text) {
    marks_.push_back({value, is_danger, text});
  }

 protected:
  void paintEvent(QPaintEvent* event) override;
  bool event(QEvent* event) override;

 private:
  struct Mark {
    int value;
    bool is_danger;
    QString text;
  };
  double x_of(int value) const;
  std::vector<Mark> marks_;
};

/// Keys and mouse in two columns, over the picture; a click or a key closes it.
class HelpOverlay : public QWidget {
  Q_OBJECT

 public:
  explicit HelpOverlay(QWidget* parent);

 protected:
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent*) override { hide(); }
};

}  // namespace trephine::view
