#include "apps/view/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vtkAxis.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkContextScene.h>
#include <vtkContextView.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPen.h>
#include <vtkPlot.h>
#include <vtkPlotPoints.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include "apps/view/render_window.h"

namespace trephine::view {

namespace {

struct Range {
  double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
  void add(double v) { low = std::min(low, v), high = std::max(high, v); }
};

void set_axis(vtkAxis* axis, const std::string& title, bool is_log, Range range) {
  axis->SetTitle(title);
  axis->SetLogScale(is_log);
  axis->GetTitleProperties()->SetFontSize(15);
  axis->GetTitleProperties()->SetBold(0);
  axis->GetLabelProperties()->SetFontSize(14);
  axis->GetPen()->SetColor(90, 90, 90);
  axis->GetGridPen()->SetColor(228, 228, 228);
  if (range.low > range.high) return;
  axis->SetBehavior(vtkAxis::FIXED);
  if (is_log) {
    // The range covers whole decades, with ticks at powers of ten, such as 0.1, 1, 10.
    const double low = std::pow(10, std::floor(std::log10(range.low) + 1e-9)),
                 high = std::pow(10, std::ceil(std::log10(range.high) - 1e-9));
    axis->SetUnscaledRange(low, std::max(high, 10 * low));
    vtkNew<vtkDoubleArray> positions;
    vtkNew<vtkStringArray> names;
    for (double v = low; v <= std::max(high, 10 * low) * 1.001; v *= 10) {
      positions->InsertNextValue(std::log10(v));
      char text[32];
      std::snprintf(text, sizeof text, "%g", v);
      names->InsertNextValue(text);
    }
    axis->SetCustomTickPositions(positions, names);
  } else {
    // About five ticks with short numbers, which leave room for the title.
    const double rough = std::max(range.high - range.low, 1e-12) / 5,
                 decade = std::pow(10, std::floor(std::log10(rough)));
    const double step = decade * (rough > 5 * decade ? 10 : rough > 2 * decade ? 5 : rough > decade ? 2 : 1);
    const double low = step * std::floor(range.low / step), high = step * std::ceil(range.high / step);
    axis->SetRange(low, high);
    vtkNew<vtkDoubleArray> positions;
    vtkNew<vtkStringArray> names;
    for (int i = 0; low + i * step <= high + 0.5 * step; ++i) {
      positions->InsertNextValue(low + i * step);
      char text[32];
      std::snprintf(text, sizeof text, "%.6g", std::abs(low + i * step) < 1e-9 * step ? 0 : low + i * step);
      names->InsertNextValue(text);
    }
    axis->SetCustomTickPositions(positions, names);
  }
}

}  // namespace

std::array<std::uint8_t, 3> chart_color(std::size_t i) {
  constexpr std::array<std::array<std::uint8_t, 3>, 16> k_colors{{{213, 94, 0},
                                                                  {0, 114, 178},
                                                                  {0, 158, 115},
                                                                  {204, 121, 167},
                                                                  {86, 180, 233},
                                                                  {230, 159, 0},
                                                                  {100, 100, 100},
                                                                  {0, 0, 0},
                                                                  {148, 90, 40},
                                                                  {120, 80, 190},
                                                                  {150, 170, 0},
                                                                  {190, 0, 90},
                                                                  {0, 90, 90},
                                                                  {180, 180, 180},
                                                                  {255, 110, 110},
                                                                  {90, 200, 160}}};
  return k_colors[i % k_colors.size()];
}

Status write_chart(const Chart& chart, const std::string& path, int width, int height) {
  auto surface = make_offscreen(width, height);
  if (!surface) return surface.error();
  vtkNew<vtkContextView> view;
  view->SetRenderWindow(surface.value()->window());
  view->GetRenderer()->SetBackground(1, 1, 1);
  vtkNew<vtkChartXY> plot;
  view->GetScene()->AddItem(plot);
  plot->SetTitle(chart.title);
  plot->SetRenderEmpty(true);
  plot->GetAxis(vtkAxis::TOP)->SetVisible(false);
  plot->GetAxis(vtkAxis::RIGHT)->SetVisible(false);
  plot->GetTitleProperties()->SetFontSize(20);
  plot->SetShowLegend(true);
  plot->GetLegend()->SetHorizontalAlignment(vtkChartLegend::RIGHT);
  plot->GetLegend()->SetVerticalAlignment(vtkChartLegend::TOP);
  plot->GetLegend()->SetLabelSize(14);
  plot->GetLegend()->SetInline(false);  // next to the axes, not over the data

  Range xs, ys;
  std::vector<vtkSmartPointer<vtkTable>> tables;
  for (const ChartSeries& s : chart.series) {
    vtkNew<vtkTable> table;
    vtkNew<vtkDoubleArray> x, y;
    x->SetName("x");
    y->SetName(s.name.c_str());
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      const bool is_shown = std::isfinite(s.x[i]) && std::isfinite(s.y[i]) &&
                            (!chart.is_x_log || s.x[i] > 0) && (!chart.is_y_log || s.y[i] > 0);
      if (!is_shown) continue;
      xs.add(s.x[i]), ys.add(s.y[i]);
      x->InsertNextValue(s.x[i]), y->InsertNextValue(s.y[i]);
    }
    if (x->GetNumberOfTuples() < (s.is_line ? 2 : 1)) continue;
    table->AddColumn(x);
    table->AddColumn(y);
    vtkPlot* series_plot = plot->AddPlot(s.is_line ? vtkChart::LINE : vtkChart::POINTS);
    series_plot->SetInputData(table, 0, 1);
    series_plot->SetColor(s.color[0], s.color[1], s.color[2], 255);
    series_plot->SetWidth(s.width);
    series_plot->SetLabel(s.name);
    if (s.name.empty()) series_plot->LegendVisibilityOff();
    if (s.is_dashed) series_plot->GetPen()->SetLineType(vtkPen::DASH_LINE);
    if (auto* points = vtkPlotPoints::SafeDownCast(series_plot)) {
      points->SetMarkerStyle(s.is_line ? vtkPlotPoints::NONE : vtkPlotPoints::CIRCLE);
      points->SetMarkerSize(s.width);
    }
    tables.emplace_back(table);
  }
  set_axis(plot->GetAxis(vtkAxis::BOTTOM), chart.x_label, chart.is_x_log, xs);
  set_axis(plot->GetAxis(vtkAxis::LEFT), chart.y_label, chart.is_y_log, ys);
  surface.value()->window()->SetMultiSamples(8);
  view->Render();
  return write_png(surface.value()->window(), path);
}

}  // namespace trephine::view
