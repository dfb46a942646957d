#include "apps/view/label_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <utility>
#include <vector>
#include <vtkActor2D.h>
#include <vtkCamera.h>
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

#include "apps/view/display_text.h"

namespace trephine::view {

using glm::dvec2;
using glm::dvec3;

namespace {
constexpr int k_text_size = 15;  // pixels

dvec3 display_of(vtkRenderer* renderer, const dvec3& world) {
  renderer->SetWorldPoint(world.x, world.y, world.z, 1);
  renderer->WorldToDisplay();
  double display[3];
  renderer->GetDisplayPoint(display);
  return {display[0], display[1], display[2]};
}

}  // namespace

struct LabelLayer::Parts {
  struct Label {
    dvec3 at;
    std::string name;
    vtkSmartPointer<vtkTextActor> text;
    bool is_name = true;
  };
  vtkRenderer* renderer;
  std::vector<Label> labels;
  std::vector<std::vector<std::array<dvec3, 2>>> marks;  ///< lines of each mark
  vtkNew<vtkPolyData> leads;
  vtkNew<vtkActor2D> lines;
  Names names = Names::in_front;
  double scale = 1;
  std::vector<LabelLayer::Box> boxes;  ///< of the newest frame
  std::vector<imaging::Segment> segments;
  std::vector<std::array<dvec3, 2>> tool;

  /// Returns the axis of each tool in the picture, and two lines next to the axis that bound the tool's
  /// width.
  std::vector<imaging::Segment> tool_segments() const {
    constexpr double k_half_width = 8;  // pixels
    std::vector<imaging::Segment> lines;
    for (const auto& [from_world, to_world] : tool) {
      const dvec3 from = display_of(renderer, from_world), to = display_of(renderer, to_world);
      const dvec2 along(to - from);
      const double length = glm::length(along);
      const dvec2 aside =
          length > 0 ? k_half_width / length * dvec2(-along.y, along.x) : dvec2(k_half_width, 0);
      for (const double side : {-1.0, 0.0, 1.0})
        lines.push_back({dvec2(from) + side * aside, dvec2(to) + side * aside});
    }
    return lines;
  }
  /// Returns the largest distance, in pixels, that an end of a tool moved since the labels were positioned.
  double tool_motion() const {
    const std::vector<imaging::Segment> now = tool_segments();
    if (now.size() != tool_at_layout.size()) return 1e9;
    double most = 0;
    for (std::size_t i = 0; i < now.size(); ++i)
      for (const std::size_t end : {0, 1})
        most = std::max(most, glm::distance(now[i][end], tool_at_layout[i][end]));
    return most;
  }
  std::vector<imaging::Segment> tool_at_layout;
  bool has_omitted = false;  ///< a label had no room in the newest frame
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
  parts_->marks.clear();
  parts_->is_stale = true;
}

void LabelLayer::add_marks(std::span<const std::array<dvec3, 2>> lines_world) {
  const std::array<dvec3, 2>* previous = nullptr;
  for (const std::array<dvec3, 2>& line : lines_world) {
    if (previous == nullptr || (*previous)[1] != line[0]) parts_->marks.emplace_back();
    parts_->marks.back().push_back(line);
    previous = &line;
  }
  parts_->is_stale = true;
}

imaging::LabelLayout::Obstacles LabelLayer::marks() const {
  constexpr double k_small = 60, k_margin = 2, k_shortest = 10;  // pixels
  imaging::LabelLayout::Obstacles marks;
  for (const auto& lines : parts_->marks) {
    std::vector<imaging::Segment> segments;
    dvec2 low(1e300), high(-1e300);
    bool is_before_camera = true;
    for (const auto& [from_world, to_world] : lines) {
      const dvec3 from = display_of(parts_->renderer, from_world),
                  to = display_of(parts_->renderer, to_world);
      is_before_camera &= std::max(from.z, to.z) <= 1 && std::min(from.z, to.z) >= 0;
      low = glm::min(low, glm::min(dvec2(from), dvec2(to)));
      high = glm::max(high, glm::max(dvec2(from), dvec2(to)));
      if (!segments.empty() && glm::distance(segments.back()[0], segments.back()[1]) < k_shortest)
        segments.back()[1] = dvec2(to);
      else
        segments.push_back({dvec2(from), dvec2(to)});
    }
    if (!is_before_camera || segments.empty()) continue;
    if (std::max(high.x - low.x, high.y - low.y) < k_small * parts_->scale)
      marks.boxes.push_back({low - k_margin, high + k_margin});
    else
      marks.segments.insert(marks.segments.end(), segments.begin(), segments.end());
  }
  return marks;
}

bool LabelLayer::is_stale() const noexcept { return parts_->is_stale; }

void LabelLayer::add(const dvec3& at_world, const std::string& text, const dvec3& colour, bool is_name) {
  const auto actor = vtkSmartPointer<vtkTextActor>::New();
  const std::string shown = display_text(text);
  actor->SetInput(shown.c_str());
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
  parts_->labels.push_back({at_world, shown, actor, is_name});
  parts_->is_stale = true;
}

void LabelLayer::set_names(Names names) {
  parts_->names = names;
  parts_->is_stale = true;
}
LabelLayer::Names LabelLayer::names() const noexcept { return parts_->names; }
void LabelLayer::set_text_scale(double factor) {
  parts_->scale = factor;
  parts_->is_stale = true;
  for (const Parts::Label& label : parts_->labels)
    label.text->GetTextProperty()->SetFontSize(static_cast<int>(std::lround(k_text_size * factor)));
}
std::size_t LabelLayer::size() const noexcept { return parts_->labels.size(); }

std::vector<LabelLayer::Box> LabelLayer::boxes() const { return parts_->boxes; }

std::vector<imaging::Segment> LabelLayer::leads() const { return parts_->segments; }

void LabelLayer::set_tool(std::vector<std::array<dvec3, 2>> axes_world) {
  Parts& p = *parts_;
  if (axes_world == p.tool) return;
  p.tool = std::move(axes_world);
  // The labels are positioned again if a label covers the tool, or if the tool moved away from a label that
  // had no room.
  constexpr double k_far = 40;  // pixels
  if (p.has_omitted && p.tool_motion() > k_far) p.is_stale = true;
  for (const imaging::Segment& line : p.tool_segments())
    for (const Box& box : p.boxes) p.is_stale |= imaging::passes(line, box);
}

void LabelLayer::lay_out(const imaging::LabelLayout::Obstacles& occupied) {
  Parts& p = *parts_;
  p.is_stale = false;
  constexpr double k_away = 26, k_gap = 4, k_border = 6, k_point = 3;  // pixels
  // A name far from its point would be read as the name of another point.
  constexpr double k_longest = 55, k_share = 0.14;  // pixels; share of the picture's width
  struct Request {
    std::size_t label;
    imaging::LabelLayout::Request place;
  };
  const int* window = p.renderer->GetSize();
  const dvec2 picture(window[0], window[1]);
  std::vector<Request> requests;
  imaging::LabelLayout::Obstacles obstacles = marks();
  obstacles.add(occupied);
  obstacles.add({{}, p.tool_segments()});
  for (std::size_t i = 0; i < p.labels.size(); ++i) {
    p.labels[i].text->SetVisibility(false);
    if (p.names == Names::none && p.labels[i].is_name) continue;
    const dvec3& at = p.labels[i].at;
    const dvec3 display = display_of(p.renderer, at);
    if (display[0] < 0 || display[1] < 0 || display[0] > window[0] || display[1] > window[1] ||
        display[2] > 1 || display[2] < 0)
      continue;
    const bool is_behind = is_hidden(at, p.labels[i].is_name);
    if (is_behind && p.names == Names::in_front && p.labels[i].is_name) continue;
    p.labels[i].text->SetInput(
        (p.labels[i].name + (is_behind ? " (" + display_text("behind") + ")" : "")).c_str());
    p.labels[i].text->GetTextProperty()->SetOpacity(is_behind ? 0.55 : 1);
    double size[2];
    p.labels[i].text->GetSize(p.renderer, size);
    const dvec2 anchor(display[0], display[1]);
    // Prefer a place toward the nearer side of the picture, where there is usually more room.
    const bool is_left = display.x < 0.5 * picture.x + 1;
    const dvec2 low(is_left ? anchor.x - k_away - size[0] : anchor.x + k_away, anchor.y + 0.5 * k_away);
    Request request{i, {anchor, 0, {size[0], size[1]}, low}};
    if (p.labels[i].is_name) request.place.longest = std::max(k_longest * p.scale, k_share * picture.x);
    requests.push_back(request);
    obstacles.boxes.push_back({anchor - k_point, anchor + k_point});
  }
  // Avoid the letters at the picture's edges.
  const dvec2 letter(44 * p.scale, 34 * p.scale);
  for (const dvec2& at : {dvec2(0.5, 1), dvec2(0.5, 0), dvec2(0, 0.5), dvec2(1, 0.5)}) {
    const dvec2 low = glm::clamp(at * picture - 0.5 * letter, dvec2(0), glm::max(picture - letter, dvec2(0)));
    obstacles.boxes.push_back({low, low + letter});
  }
  // Place the labels from the top down. A label without room is not shown.
  std::stable_sort(requests.begin(), requests.end(),
                   [](const Request& a, const Request& b) { return a.place.anchor.y > b.place.anchor.y; });
  imaging::LabelLayout layout({dvec2(k_border), picture - k_border}, std::move(obstacles), k_gap);
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  p.boxes.clear(), p.segments.clear();
  p.has_omitted = false;
  p.tool_at_layout = p.tool_segments();
  for (const Request& request : requests) {
    const auto place = layout.place(request.place);
    if (!place) {
      p.has_omitted = true;
      continue;
    }
    p.boxes.push_back(place->box);
    vtkTextActor* text = p.labels[request.label].text;
    text->SetDisplayPosition(static_cast<int>(place->box.low.x), static_cast<int>(place->box.low.y));
    text->SetVisibility(true);
    if (!place->lead) continue;
    p.segments.push_back(*place->lead);
    const auto& [from, to] = *place->lead;
    const std::array<vtkIdType, 2> ends{points->InsertNextPoint(from.x, from.y, 0),
                                        points->InsertNextPoint(to.x, to.y, 0)};
    lines->InsertNextCell(2, ends.data());
  }
  p.leads->SetPoints(points);
  p.leads->SetLines(lines);
  p.lines->SetVisibility(!p.segments.empty());
}

}  // namespace trephine::view
