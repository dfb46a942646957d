#include "apps/view/label_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <vector>
#include <vtkActor2D.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

namespace trephine::view {

using glm::dvec2;
using glm::dvec3;

namespace {
constexpr int k_text_size = 15;  // pixels
}

struct LabelLayer::Parts {
  struct Label {
    dvec3 at;
    std::string name;
    vtkSmartPointer<vtkTextActor> text;
    bool is_name = true;
  };
  vtkRenderer* renderer;
  std::vector<Label> labels;
  vtkNew<vtkPolyData> leads;
  vtkNew<vtkActor2D> lines;
  bool are_visible = true;
  double scale = 1;
  std::vector<LabelLayer::Box> boxes;  ///< of the newest frame
  bool is_stale = true;
};

LabelLayer::LabelLayer(vtkRenderer* renderer) : parts_(std::make_unique<Parts>()) {
  parts_->renderer = renderer;
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(parts_->leads);
  parts_->lines->SetMapper(mapper);
  parts_->lines->GetProperty()->SetColor(0.92, 0.94, 0.97);
  parts_->lines->GetProperty()->SetLineWidth(1.5);
  parts_->lines->VisibilityOff();
  renderer->AddActor2D(parts_->lines);
}
LabelLayer::~LabelLayer() = default;

void LabelLayer::clear() {
  for (const Parts::Label& label : parts_->labels) parts_->renderer->RemoveActor2D(label.text);
  parts_->labels.clear();
  parts_->is_stale = true;
}

bool LabelLayer::is_stale() const noexcept { return parts_->is_stale; }

void LabelLayer::add(const dvec3& at_world, const std::string& text, const dvec3& colour, bool is_name) {
  const auto actor = vtkSmartPointer<vtkTextActor>::New();
  actor->SetInput(text.c_str());
  vtkTextProperty* style = actor->GetTextProperty();
  style->SetFontFamilyToArial();
  style->SetFontSize(static_cast<int>(std::lround(k_text_size * parts_->scale)));
  // Lighter than the colour of the labelled object, to be readable on the dark plate.
  style->SetColor(0.5 + 0.5 * colour.r, 0.5 + 0.5 * colour.g, 0.5 + 0.5 * colour.b);
  style->SetBackgroundColor(0.05, 0.07, 0.10);
  style->SetBackgroundOpacity(0.78);
  style->SetVerticalJustificationToBottom();
  actor->SetVisibility(false);
  parts_->renderer->AddActor2D(actor);
  parts_->labels.push_back({at_world, text, actor, is_name});
  parts_->is_stale = true;
}

void LabelLayer::set_visible(bool are_visible) {
  parts_->are_visible = are_visible;
  parts_->is_stale = true;
}
bool LabelLayer::is_visible() const noexcept { return parts_->are_visible; }
void LabelLayer::set_text_scale(double factor) {
  parts_->scale = factor;
  parts_->is_stale = true;
  for (const Parts::Label& label : parts_->labels)
    label.text->GetTextProperty()->SetFontSize(static_cast<int>(std::lround(k_text_size * factor)));
}
std::size_t LabelLayer::size() const noexcept { return parts_->labels.size(); }

std::vector<LabelLayer::Box> LabelLayer::boxes() const { return parts_->boxes; }

void LabelLayer::lay_out() {
  Parts& p = *parts_;
  p.is_stale = false;
  constexpr double k_away = 26, k_gap = 4, k_border = 6;  // pixels
  struct Placed {
    std::size_t label;
    dvec2 anchor, low, size;
  };
  const int* window = p.renderer->GetSize();
  std::vector<Placed> placed;
  for (std::size_t i = 0; i < p.labels.size(); ++i) {
    p.labels[i].text->SetVisibility(false);
    if (!p.are_visible && p.labels[i].is_name) continue;
    const dvec3& at = p.labels[i].at;
    p.renderer->SetWorldPoint(at.x, at.y, at.z, 1);
    p.renderer->WorldToDisplay();
    double display[3];
    p.renderer->GetDisplayPoint(display);
    if (display[0] < 0 || display[1] < 0 || display[0] > window[0] || display[1] > window[1] ||
        display[2] > 1 || display[2] < 0)
      continue;
    const bool is_behind = is_hidden(at);
    p.labels[i].text->SetInput((p.labels[i].name + (is_behind ? " (behind)" : "")).c_str());
    p.labels[i].text->GetTextProperty()->SetOpacity(is_behind ? 0.55 : 1);
    double size[2];
    p.labels[i].text->GetSize(p.renderer, size);
    const dvec2 anchor(display[0], display[1]);
    // Place the label toward the side with more room.
    const bool is_right = display[0] < 0.5 * window[0] + 1;
    const dvec2 low(is_right ? anchor.x - k_away - size[0] : anchor.x + k_away, anchor.y + 0.5 * k_away);
    placed.push_back({i, anchor, low, {size[0], size[1]}});
  }
  // Avoid the letters at the picture's edges.
  std::vector<Placed> letters;
  const dvec2 letter(44 * p.scale, 34 * p.scale), picture(window[0], window[1]);
  for (const dvec2& at : {dvec2(0.5, 1), dvec2(0.5, 0), dvec2(0, 0.5), dvec2(1, 0.5)})
    letters.push_back({0, {}, glm::clamp(at * picture - 0.5 * letter, dvec2(0), picture - letter), letter});
  // From the top down, move each label below those that it would cover.
  std::sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) { return a.low.y > b.low.y; });
  for (std::size_t i = 0; i < placed.size(); ++i) {
    Placed& plate = placed[i];
    plate.low.x = std::clamp(plate.low.x, k_border, std::max(k_border, window[0] - plate.size.x - k_border));
    plate.low.y = std::clamp(plate.low.y, k_border, std::max(k_border, window[1] - plate.size.y - k_border));
    for (bool is_moved = true; is_moved;) {
      is_moved = false;
      for (std::size_t j = 0; j < i + letters.size(); ++j) {
        const Placed& other = j < i ? placed[j] : letters[j - i];
        const bool is_apart = plate.low.x > other.low.x + other.size.x + k_gap ||
                              other.low.x > plate.low.x + plate.size.x + k_gap ||
                              plate.low.y > other.low.y + other.size.y + k_gap ||
                              other.low.y > plate.low.y + plate.size.y + k_gap;
        if (is_apart) continue;
        plate.low.y = other.low.y - plate.size.y - k_gap - 1;
        is_moved = true;
      }
    }
  }
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  p.boxes.clear();
  for (const Placed& plate : placed) {
    p.boxes.push_back({plate.low, plate.low + plate.size});
    vtkTextActor* text = p.labels[plate.label].text;
    text->SetDisplayPosition(static_cast<int>(plate.low.x), static_cast<int>(plate.low.y));
    text->SetVisibility(true);
    const double near = plate.low.x > plate.anchor.x ? plate.low.x - 2 : plate.low.x + plate.size.x + 2;
    const std::array<vtkIdType, 2> ends{points->InsertNextPoint(plate.anchor.x, plate.anchor.y, 0),
                                        points->InsertNextPoint(near, plate.low.y + 0.5 * plate.size.y, 0)};
    lines->InsertNextCell(2, ends.data());
  }
  p.leads->SetPoints(points);
  p.leads->SetLines(lines);
  p.lines->SetVisibility(!placed.empty());
}

}  // namespace trephine::view
