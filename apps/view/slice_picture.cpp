#include "apps/view/slice_picture.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <set>
#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkImageActor.h>
#include <vtkImageData.h>
#include <vtkImageMapper3D.h>
#include <vtkImageProperty.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty.h>
#include <vtkProperty2D.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include "apps/imaging/label_layout.h"
#include "apps/view/render_window.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::view {

using imaging::Panel;

namespace {

constexpr int k_head = 44, k_foot = 34;  // pixels above and below panels

/// Legend of a picture: names of lines, and numbered names of labels without room. Each name occurs once, in
/// rows that fit into the picture's width.
struct Legend {
  struct Entry {
    std::string name;
    Panel::Colour colour;
    double x = 0;
    int row = 0;
  };
  std::vector<Entry> entries;
  int rows = 0;

  /// `names`: placed labels of each panel. `width`: width of the picture, pixels.
  Legend(const std::vector<Panel>& panels, const std::vector<std::vector<imaging::PlacedLabel>>& names,
         int width) {
    std::set<std::string> known;
    double x = 12;
    const auto add = [&](const std::string& name, const Panel::Colour& colour) {
      if (name.empty() || !known.insert(name).second) return;
      const double length = 9.5 * static_cast<double>(name.size()) + 24;
      if (entries.empty() || (x > 12 && x + length > width)) x = 12, ++rows;
      entries.push_back({name, colour, x, rows - 1});
      x += length;
    };
    for (const Panel& panel : panels)
      for (const Panel::Line& line : panel.lines) add(line.name, line.colour);
    for (std::size_t i = 0; i < panels.size(); ++i)
      for (std::size_t l = 0; l < names[i].size(); ++l)
        if (const Panel::Label& label = panels[i].labels[l]; names[i][l].number > 0)
          add(std::to_string(names[i][l].number) + ": " + label.text, label.colour);
  }
};

constexpr int k_label_size = 14;

/// Places the labels of each panel, in pixels from the lower left of the panel's square. A label without room
/// gets a number, which occurs only once in the picture.
std::vector<std::vector<imaging::PlacedLabel>> place_names(const std::vector<Panel>& panels, int edge) {
  std::vector<std::vector<imaging::PlacedLabel>> names;
  int number = 1;
  for (const Panel& panel : panels) {
    imaging::LabelSpace space{1.0 * edge, 1.0 * edge, 1.25 * k_label_size, [](const std::string& text) {
                                return 0.55 * k_label_size * static_cast<double>(text.size());
                              }};
    space.first_number = number;
    // Labels avoid the letters at the edges, the foot and the scale bar.
    constexpr double k_letter = 22;
    for (const glm::dvec2& at :
         {glm::dvec2(12 + k_letter / 2, 0.5 * edge), glm::dvec2(edge - 12 - k_letter / 2, 0.5 * edge),
          glm::dvec2(0.5 * edge, edge - 16), glm::dvec2(0.5 * edge, 40)})
      space.occupied.push_back({at - 0.5 * k_letter, at + 0.5 * k_letter});
    if (!panel.foot.empty()) space.occupied.push_back({{0, 0}, {1.0 * edge, 28}});
    if (panel.is_to_scale) space.occupied.push_back({{0.7 * edge, 0}, {1.0 * edge, 38}});
    names.push_back(imaging::place_labels(panel, space));
    for (const imaging::PlacedLabel& name : names.back()) number += name.number > 0;
  }
  return names;
}

/// Returns the font size, at most `size` pixels, at which a line of text fits into `room` pixels.
int size_within(const std::string& text, double room, int size) {
  constexpr double k_letter = 0.53;  // mean width of a letter, relative to the font size
  return std::clamp(
      static_cast<int>(room / (k_letter * std::max<double>(1, static_cast<double>(text.size())))), 9, size);
}

enum class Align { left, centre, right };

void add_text(vtkRenderer* to, const std::string& text, double x, double y, int size, Align align,
              const Panel::Colour& colour = {230, 230, 230}) {
  if (text.empty()) return;
  vtkNew<vtkTextActor> actor;
  actor->SetInput(text.c_str());
  actor->GetPositionCoordinate()->SetCoordinateSystemToDisplay();
  actor->SetPosition(x, y);
  vtkTextProperty* style = actor->GetTextProperty();
  style->SetFontSize(size);
  style->SetColor(colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0);
  style->SetVerticalJustificationToCentered();
  style->SetBackgroundColor(0.07, 0.07, 0.08);
  style->SetBackgroundOpacity(0.4);  // so that text is readable on bright pictures
  if (align == Align::right) style->SetJustificationToRight();
  if (align == Align::centre) style->SetJustificationToCentered();
  to->AddActor2D(actor);
}

void add_pixels(vtkRenderer* to, const Panel& panel) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(panel.columns, panel.rows, 1);
  image->SetSpacing(panel.mm_per_pixel, panel.mm_per_pixel, 1);
  image->SetOrigin(-0.5 * panel.mm_per_pixel * (panel.columns - 1),
                   -0.5 * panel.mm_per_pixel * (panel.rows - 1), 0);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  auto* out = static_cast<std::uint8_t*>(image->GetScalarPointer());
  for (const Panel::Colour& c : panel.pixels) out = std::copy(c.begin(), c.end(), out);
  vtkNew<vtkImageActor> actor;
  actor->GetMapper()->SetInputData(image);
  actor->GetProperty()->SetInterpolationTypeToLinear();
  to->AddActor(actor);
}

/// Adds a line. Skips points nearer than `least` mm to the last one, because very short segments leave gaps.
void add_line(vtkRenderer* to, const Panel::Line& line, double least) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  const glm::dvec2* last = nullptr;
  for (const glm::dvec2& p : line.points) {
    if (last != nullptr && &p != &line.points.back() && glm::length(p - *last) < least) continue;
    points->InsertNextPoint(p.x, p.y, 0.5);
    last = &p;
  }
  const vtkIdType count = points->GetNumberOfPoints();
  if (count < 2) return;
  cells->InsertNextCell(static_cast<int>(count + (line.is_closed ? 1 : 0)));
  for (vtkIdType i = 0; i < count; ++i) cells->InsertCellPoint(i);
  if (line.is_closed) cells->InsertCellPoint(0);
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetLines(cells);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(line.colour[0] / 255.0, line.colour[1] / 255.0, line.colour[2] / 255.0);
  actor->GetProperty()->SetLineWidth(2.5F);
  actor->GetProperty()->LightingOff();
  to->AddActor(actor);
}

/// Adds straight lines over the whole picture; positions and width in its pixels.
void add_segments(vtkRenderer* to, const std::vector<imaging::Segment>& segments, double width,
                  const Panel::Colour& colour) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  for (const imaging::Segment& segment : segments) {
    cells->InsertNextCell(2);
    for (const glm::dvec2& p : segment) cells->InsertCellPoint(points->InsertNextPoint(p.x, p.y, 0));
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetLines(cells);
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(data);
  vtkNew<vtkActor2D> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0);
  actor->GetProperty()->SetLineWidth(static_cast<float>(width));
  to->AddActor2D(actor);
}

/// Adds a scale bar with end marks; positions in pixels of the whole picture.
void add_bar(vtkRenderer* to, double left, double right, double y) {
  add_segments(
      to, {{{{left, y}, {right, y}}}, {{{left, y - 4}, {left, y + 4}}}, {{{right, y - 4}, {right, y + 4}}}},
      2, {230, 230, 230});
}

}  // namespace

Result<std::string> slices_png(const std::vector<Panel>& panels, int edge) {
  // Up to three panels form a row; more form two rows or, from seven on, rows of three.
  const int count = static_cast<int>(panels.size()),
            columns = count <= 3 ? count : std::min(3, (count + 1) / 2),
            rows = (count + columns - 1) / columns;
  const int width = columns * edge, cell = k_head + edge;
  const auto names = place_names(panels, edge);
  const Legend legend(panels, names, width);
  const int height = rows * cell + legend.rows * k_foot + (legend.rows > 0 ? 6 : 0);
  // Titles share one font size.
  int title_size = 19;
  for (const Panel& panel : panels)
    title_size = std::min(title_size, size_within(panel.title, edge - 24, 19));
  auto surface = make_offscreen(width, height);
  if (!surface) return surface.error();
  vtkRenderWindow* window = surface.value()->window();
  // The text layer covers the whole picture.
  vtkNew<vtkRenderer> text_layer;
  text_layer->SetBackground(0.07, 0.07, 0.08);
  window->SetNumberOfLayers(2);
  text_layer->SetLayer(1);
  text_layer->InteractiveOff();
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const Panel& panel = panels[i];
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    const double left = column * edge, low = height - (row + 1) * cell;
    vtkNew<vtkRenderer> view;
    view->SetBackground(0.07, 0.07, 0.08);
    view->SetViewport(left / width, low / height, (left + edge) / width, (low + edge) / height);
    view->GetActiveCamera()->ParallelProjectionOn();
    view->GetActiveCamera()->SetPosition(0, 0, 100);
    view->GetActiveCamera()->SetFocalPoint(0, 0, 0);
    view->GetActiveCamera()->SetParallelScale(0.5 * panel.mm_per_pixel * std::max(panel.columns, panel.rows));
    add_pixels(view, panel);
    for (const Panel::Line& line : panel.lines)
      add_line(view, line, 1.6 * panel.mm_per_pixel * std::max(panel.columns, panel.rows) / edge);
    view->ResetCameraClippingRange();
    window->AddRenderer(view);
    if (panel.is_to_scale) {
      const double pixels_per_mm = edge / (panel.mm_per_pixel * std::max(panel.columns, panel.rows));
      const int mm = imaging::bar_length(0.25 * edge / pixels_per_mm);
      add_bar(text_layer, left + edge - 14 - mm * pixels_per_mm, left + edge - 14, low + 12);
      add_text(text_layer, std::to_string(mm) + " mm", left + edge - 14, low + 27, 15, Align::right);
    }
    add_text(text_layer, panel.title, left + 12, low + edge + 0.5 * k_head, title_size, Align::left);
    for (std::size_t l = 0; l < names[i].size(); ++l) {
      const imaging::PlacedLabel& name = names[i][l];
      const glm::dvec2 corner(left, low);
      if (name.lead)
        add_segments(text_layer, {{{corner + (*name.lead)[0], corner + (*name.lead)[1]}}}, 1,
                     panel.labels[l].colour);
      add_text(text_layer, name.text, left + name.box.low.x, low + 0.5 * (name.box.low.y + name.box.high.y),
               k_label_size, Align::left, panel.labels[l].colour);
    }
    const double room = edge - 24 - (panel.is_to_scale ? 0.3 * edge : 0);
    add_text(text_layer, panel.foot, left + 12, low + 16, size_within(panel.foot, room, 15), Align::left);
    add_text(text_layer, panel.left, left + 12, low + 0.5 * edge, 18, Align::left);
    add_text(text_layer, panel.right, left + edge - 12, low + 0.5 * edge, 18, Align::right);
    add_text(text_layer, panel.above, left + 0.5 * edge, low + edge - 16, 18, Align::centre);
    add_text(text_layer, panel.below, left + 0.5 * edge, low + 40, 18, Align::centre);
  }
  for (const Legend::Entry& entry : legend.entries)
    add_text(text_layer, entry.name, entry.x, 3 + (legend.rows - entry.row - 0.5) * k_foot, 17, Align::left,
             entry.colour);
  window->AddRenderer(text_layer);
  window->Render();
  return png_of(window);
}

Status write_slices(const std::vector<Panel>& panels, const std::string& path, int edge) {
  const auto png = slices_png(panels, edge);
  return png ? data_tools::write_file_atomically(path, png.value()) : Status(png.error());
}

}  // namespace trephine::view
