#include "apps/view/step_picture.h"

#include <array>
#include <cmath>
#include <vtkBrush.h>
#include <vtkContext2D.h>
#include <vtkContextItem.h>
#include <vtkContextScene.h>
#include <vtkContextView.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPen.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTextProperty.h>

#include "apps/view/render_window.h"

namespace trephine::view {

namespace {

using glm::dvec2;
using imaging::PictureBox;
using imaging::StepDiagram;

/// Paints a diagram. y is down in the diagram and up in VTK.
class DiagramItem : public vtkContextItem {
 public:
  static DiagramItem* New();
  void set(const StepDiagram& diagram) { diagram_ = &diagram; }

  bool Paint(vtkContext2D* painter) override {
    for (const StepDiagram::Box& box : diagram_->boxes) {
      painter->GetPen()->SetColor(64, 64, 64);
      painter->GetPen()->SetWidth(1.5f);
      painter->GetBrush()->SetColor(238, 243, 248);
      draw(painter, box.area);
      if (box.is_end)
        draw(painter, {box.area.low + imaging::k_double_line, box.area.high - imaging::k_double_line});
    }
    painter->GetPen()->SetWidth(1.2f);
    painter->GetBrush()->SetColor(64, 64, 64);
    for (const StepDiagram::Arrow& arrow : diagram_->arrows) draw(painter, arrow);
    painter->DrawEllipse(at(diagram_->start).x, at(diagram_->start).y, imaging::k_dot, imaging::k_dot);
    for (const StepDiagram::Text& text : diagram_->texts) draw(painter, text);
    return true;
  }

 private:
  struct Point {
    float x, y;
  };
  Point at(const dvec2& p) const {
    return {static_cast<float>(p.x), static_cast<float>(diagram_->height - p.y)};
  }
  void draw(vtkContext2D* painter, const PictureBox& area) const {
    const Point low = at({area.low.x, area.high.y});
    painter->DrawRect(low.x, low.y, static_cast<float>(area.high.x - area.low.x),
                      static_cast<float>(area.high.y - area.low.y));
  }
  void draw(vtkContext2D* painter, const StepDiagram::Arrow& arrow) const {
    for (std::size_t i = 1; i < arrow.points.size(); ++i) {
      const Point a = at(arrow.points[i - 1]), b = at(arrow.points[i]);
      painter->DrawLine(a.x, a.y, b.x, b.y);
    }
    std::array<float, 6> corners{};
    for (std::size_t i = 0; const dvec2& corner : imaging::head_of(arrow)) {
      corners[i++] = at(corner).x;
      corners[i++] = at(corner).y;
    }
    painter->DrawPolygon(corners.data(), 3);
  }
  static void set_text(vtkTextProperty& property, const StepDiagram::Text& text) {
    property.SetFontSize(static_cast<int>(text.size));
    property.SetBold(text.is_bold);
    const double grey = text.is_grey ? 0.376 : 0;
    property.SetColor(grey, grey, grey);
    property.SetVerticalJustificationToCentered();
    if (text.is_at_right)
      property.SetJustificationToRight();
    else
      property.SetJustificationToLeft();
  }
  void draw(vtkContext2D* painter, const StepDiagram::Text& text) const {
    set_text(*painter->GetTextProp(), text);
    const Point middle =
        at({text.is_at_right ? text.area.high.x : text.area.low.x, (text.area.low.y + text.area.high.y) / 2});
    painter->DrawString(middle.x, middle.y, text.words.c_str());
  }

  const StepDiagram* diagram_ = nullptr;
};
vtkStandardNewMacro(DiagramItem);

}  // namespace

Status write_steps(const StepDiagram& diagram, const std::string& path) {
  auto surface =
      make_offscreen(static_cast<int>(std::ceil(diagram.width)), static_cast<int>(std::ceil(diagram.height)));
  if (!surface) return surface.error();
  vtkNew<vtkContextView> view;
  view->SetRenderWindow(surface.value()->window());
  view->GetRenderer()->SetBackground(1, 1, 1);
  vtkNew<DiagramItem> item;
  item->set(diagram);
  view->GetScene()->AddItem(item);
  surface.value()->window()->SetMultiSamples(8);
  view->Render();
  return write_png(surface.value()->window(), path);
}

}  // namespace trephine::view
