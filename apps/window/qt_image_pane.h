// ImagePane: one pane next to the 3-D picture: an image with lines and texts, and its mouse controls.
#pragma once

#include <QImage>
#include <QWidget>
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "apps/imaging/panes.h"
#include "sim/api/overlay.h"

class QComboBox;
class QPainter;
class QToolButton;

namespace trephine::view {

class PaneText;

/// Draws a pane of `panes`, and translates mouse events to calls of `panes`. In a slice, the wheel shows the
/// next or previous slice, or zooms with Ctrl. Motion with Shift sets the focus of all slices. Dragging with
/// the middle button pans, with the right button zooms, and with the left button changes the grey window. In
/// a volume rendering, dragging turns the camera. A double click maximises or restores the pane.
class ImagePane : public QWidget {
  Q_OBJECT

 public:
  ImagePane(imaging::Panes& panes, std::size_t index, QWidget* parent = nullptr);

  /// Updates image, tool and crosshair; call in every frame. `tool`: tip of the tool and a point of its shaft
  /// (world, mm); null: no tool is drawn.
  void refresh(const std::array<glm::dvec3, 2>* tool);
  void set_kind(imaging::PaneKind kind);
  /// Lays out the controls; their height follows the font.
  void lay_out();
  /// Shows lines and labels of the measurements and the plan among these overlays, if they are near the
  /// plane. Null: no overlays.
  void set_overlays(std::shared_ptr<const sim::Overlays> overlays);
  /// Shows positions (world) that the user marks, and the line between them.
  void set_marks(std::vector<glm::dvec3> marks);
  /// Shows or hides the names of the plan.
  void set_names_visible(bool is_visible);
  QSize sizeHint() const override { return {360, 300}; }
  QSize minimumSizeHint() const override;

  std::function<void()> on_maximise = [] {};
  /// Disables the buttons of the C-arm, with the reason as their tool tip; an empty reason enables them.
  void set_xray_refusal(const QString& reason);
  std::function<void()> on_shoot = [] {};
  std::function<void(bool)> on_live = [](bool) {};
  std::function<void(int)> on_preset = [](int) {};
  /// The user clicked at a point of the plane (world, mm). Return true if the click must have no other
  /// effect.
  std::function<bool(const glm::dvec3& at)> on_point = [](const glm::dvec3&) { return false; };
  /// The user turned a volume rendering by these angles, degrees. It shares the camera of the 3-D picture.
  std::function<void(double left, double up)> on_turn = [](double, double) {};

 protected:
  void paintEvent(QPaintEvent* event) override;
  void changeEvent(QEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  void enterEvent(QEvent* event) override;

 private:
  /// Returns the widget position of a point of the image. `mm`: from the image's centre.
  QPointF place(const imaging::Panel& panel, const glm::dvec2& mm) const;
  QRectF image_rect(const imaging::Panel& panel) const;
  void draw_marks(QPainter& painter) const;
  void draw_overlays(QPainter& painter, const volume::ImagePlane& plane) const;
  void add_captions(PaneText& text, const imaging::Panel& panel, const QRectF& inner, double& bottom) const;

  imaging::Panes* panes_;
  std::size_t index_;
  QImage image_;
  QComboBox *kind_, *preset_;
  QToolButton *live_, *shoot_, *maximise_;
  std::array<glm::dvec3, 2> tool_{};
  std::vector<glm::dvec3> marks_;
  std::shared_ptr<const sim::Overlays> overlays_;
  bool has_tool_ = false, has_names_ = true;
  glm::dvec3 shown_at_{1e300}, shown_tip_{1e300};
  std::uint64_t shown_changes_ = 0;
  QPointF last_;
};

}  // namespace trephine::view
