#include "apps/view/picture_text.h"

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <utility>
#include <vtkActor2D.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkMath.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include "apps/imaging/panel.h"

namespace trephine::view {

using glm::dvec3;

namespace {
constexpr int k_letter_size = 20, k_bar_size = 15;  // pixels
}

PictureText::PictureText(vtkRenderer* renderer) : renderer_(renderer) {
  for (vtkTextActor* text : {corner_.GetPointer(), foot_.GetPointer()}) {
    text->GetTextProperty()->SetFontFamilyToArial();
    text->GetTextProperty()->SetFontSize(18);
    text->GetTextProperty()->SetColor(0.94, 0.95, 0.97);
    text->GetTextProperty()->SetLineSpacing(1.25);
    text->GetTextProperty()->SetBackgroundColor(0.05, 0.07, 0.10);
    text->GetTextProperty()->SetBackgroundOpacity(0.6);
    text->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
    renderer->AddActor2D(text);
  }
  const double positions[4][2] = {{0.985, 0.5}, {0.015, 0.5}, {0.5, 0.975}, {0.5, 0.025}};
  for (std::size_t i = 0; i < 4; ++i) {
    auto& edge = edges_[i] = vtkSmartPointer<vtkTextActor>::New();
    vtkTextProperty* style = edge->GetTextProperty();
    style->SetFontFamilyToArial();
    style->SetFontSize(k_letter_size);
    style->BoldOn();
    style->SetColor(0.96, 0.97, 0.99);
    style->SetBackgroundColor(0.05, 0.07, 0.10);
    style->SetBackgroundOpacity(0.7);
    i == 0   ? style->SetJustificationToRight()
    : i == 1 ? style->SetJustificationToLeft()
             : style->SetJustificationToCentered();
    i == 2   ? style->SetVerticalJustificationToTop()
    : i == 3 ? style->SetVerticalJustificationToBottom()
             : style->SetVerticalJustificationToCentered();
    edge->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
    edge->SetPosition(positions[i][0], positions[i][1]);
    renderer->AddActor2D(edge);
  }
  vtkNew<vtkPolyDataMapper2D> bar;
  bar->SetInputData(bar_line_);
  bar_->SetMapper(bar);
  bar_->GetProperty()->SetColor(0.96, 0.97, 0.99);
  bar_->GetProperty()->SetLineWidth(2);
  renderer->AddActor2D(bar_);
  bar_text_->GetTextProperty()->SetFontFamilyToArial();
  bar_text_->GetTextProperty()->SetFontSize(k_bar_size);
  bar_text_->GetTextProperty()->SetColor(0.96, 0.97, 0.99);
  bar_text_->GetTextProperty()->SetBackgroundColor(0.05, 0.07, 0.10);
  bar_text_->GetTextProperty()->SetBackgroundOpacity(0.7);
  bar_text_->GetTextProperty()->SetJustificationToRight();
  renderer->AddActor2D(bar_text_);
  corner_->SetPosition(0.018, 0.975);
  corner_->GetTextProperty()->SetVerticalJustificationToTop();
  foot_->SetPosition(0.5, 0.055);
  foot_->GetTextProperty()->SetJustificationToCentered();
  foot_->GetTextProperty()->SetFontSize(15);
}
PictureText::~PictureText() = default;

std::array<glm::dvec2, 2> PictureText::corner_box() const {
  const int* window = renderer_->GetSize();
  const glm::dvec2 upper_left(0.018 * window[0], 0.975 * window[1]);
  const char* text = corner_->GetInput();
  if (text == nullptr || *text == 0) return {upper_left, upper_left};
  double size[2];
  corner_->GetSize(renderer_, size);
  return {upper_left - glm::dvec2(0, size[1]), upper_left + glm::dvec2(size[0], 0)};
}

void PictureText::show(const std::string& corner, const std::string& foot) {
  corner_->SetInput(corner.c_str());
  foot_->SetInput(foot.c_str());
}

void PictureText::set_scale(double factor) {
  const auto scaled = [&](int size) { return static_cast<int>(std::lround(factor * size)); };
  for (const auto& edge : edges_) edge->GetTextProperty()->SetFontSize(scaled(k_letter_size));
  bar_text_->GetTextProperty()->SetFontSize(scaled(k_bar_size));
}

void PictureText::update() {
  show_directions();
  show_scale();
}

/// Sets the letters at the picture's edges to the patient's directions, as on slices.
void PictureText::show_directions() {
  double right[3], up[3], out[3];
  vtkCamera* camera = renderer_->GetActiveCamera();
  camera->OrthogonalizeViewUp();
  camera->GetViewUp(up);
  camera->GetDirectionOfProjection(out);
  vtkMath::Cross(out, up, right);
  const dvec3 directions[] = {{right[0], right[1], right[2]}, {up[0], up[1], up[2]}};
  for (std::size_t i = 0; i < 4; ++i)
    edges_[i]->SetInput(
        imaging::direction_letters(i % 2 == 0 ? directions[i / 2] : -directions[i / 2]).c_str());
}

/// Draws the scale bar in the lower right. Its length is valid at the depth of the camera's focal point.
void PictureText::show_scale() {
  const int* size = renderer_->GetSize();
  vtkCamera* camera = renderer_->GetActiveCamera();
  constexpr double k_half_degree = 3.14159265358979 / 360, k_share = 0.16;  // of the picture's width
  const double pixel =
      2 * camera->GetDistance() * std::tan(camera->GetViewAngle() * k_half_degree) / std::max(1, size[1]);
  const int mm = imaging::bar_length(k_share * size[0] * pixel);
  const double right = size[0] - 20.0, left = right - mm / pixel, y = 18;
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> line;
  for (const auto& [x, h] :
       {std::pair(left, 7.0), std::pair(left, 0.0), std::pair(right, 0.0), std::pair(right, 7.0)})
    points->InsertNextPoint(x, y + h, 0);
  line->InsertNextCell({0, 1, 2, 3});
  bar_line_->SetPoints(points);
  bar_line_->SetLines(line);
  bar_text_->SetInput((std::to_string(mm) + " mm").c_str());
  bar_text_->SetDisplayPosition(static_cast<int>(right), static_cast<int>(y) + 11);
}

}  // namespace trephine::view
