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
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include "apps/view/render_window.h"
#include "apps/workbench/text.h"
#include "data-tools/files/atomic_file.h"
#include "volume/base/text.h"

namespace trephine::view {

using workbench::escape_svg;
using workbench::format_text;

namespace {

struct Tick {
  double value = 0;
  std::string name;
};

/// Range and ticks of an axis.
struct Axis {
  std::string title;
  bool is_log = false;
  double low = 0, high = 1;
  std::vector<Tick> ticks;

  /// Returns the position of a value along the axis: 0 at its start, 1 at its end.
  double share(double v) const {
    return is_log ? std::log(v / low) / std::log(high / low) : (v - low) / (high - low);
  }
};

struct Range {
  double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
  void add(double v) { low = std::min(low, v), high = std::max(high, v); }
};

std::string tick_name(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

Axis axis_of(const std::string& title, bool is_log, Range range) {
  Axis axis{title, is_log, is_log ? 0.1 : 0.0, 1.0, {}};
  if (range.low > range.high) return axis;
  if (is_log) {
    // The range covers whole decades, with ticks at powers of ten, such as 0.1, 1, 10.
    axis.low = std::pow(10, std::floor(std::log10(range.low) + 1e-9));
    axis.high = std::max(std::pow(10, std::ceil(std::log10(range.high) - 1e-9)), 10 * axis.low);
    for (double v = axis.low; v <= axis.high * 1.001; v *= 10) axis.ticks.push_back({v, tick_name("%g", v)});
  } else {
    // About five ticks with short numbers, which leave room for the title.
    const double rough = std::max(range.high - range.low, 1e-12) / 5,
                 decade = std::pow(10, std::floor(std::log10(rough)));
    const double step = decade * (rough > 5 * decade ? 10 : rough > 2 * decade ? 5 : rough > decade ? 2 : 1);
    axis.low = step * std::floor(range.low / step);
    axis.high = std::max(step * std::ceil(range.high / step), axis.low + step);
    for (int i = 0; axis.low + i * step <= axis.high + 0.5 * step; ++i) {
      const double v = axis.low + i * step;
      axis.ticks.push_back({v, tick_name("%.6g", std::abs(v) < 1e-9 * step ? 0 : v)});
    }
  }
  return axis;
}

/// A chart without the points that its axes cannot show.
struct DrawnChart {
  std::vector<ChartSeries> series;
  Axis x, y;
};

DrawnChart drawn(const Chart& chart) {
  DrawnChart result;
  Range xs, ys;
  for (const ChartSeries& s : chart.series) {
    ChartSeries shown = s;
    shown.x.clear(), shown.y.clear();
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      const bool is_shown = std::isfinite(s.x[i]) && std::isfinite(s.y[i]) &&
                            (!chart.is_x_log || s.x[i] > 0) && (!chart.is_y_log || s.y[i] > 0);
      if (!is_shown) continue;
      xs.add(s.x[i]), ys.add(s.y[i]);
      shown.x.push_back(s.x[i]), shown.y.push_back(s.y[i]);
    }
    if (shown.x.size() >= (s.is_line ? 2u : 1u)) result.series.push_back(std::move(shown));
  }
  result.x = axis_of(chart.x_label, chart.is_x_log, xs);
  result.y = axis_of(chart.y_label, chart.is_y_log, ys);
  return result;
}

void set_axis(vtkAxis* axis, const Axis& from) {
  axis->SetTitle(from.title);
  axis->SetLogScale(from.is_log);
  axis->GetTitleProperties()->SetFontSize(15);
  axis->GetTitleProperties()->SetBold(0);
  axis->GetLabelProperties()->SetFontSize(14);
  axis->GetPen()->SetColor(90, 90, 90);
  axis->GetGridPen()->SetColor(228, 228, 228);
  if (from.ticks.empty()) return;
  axis->SetBehavior(vtkAxis::FIXED);
  if (from.is_log)
    axis->SetUnscaledRange(from.low, from.high);
  else
    axis->SetRange(from.low, from.high);
  vtkNew<vtkDoubleArray> positions;
  vtkNew<vtkStringArray> names;
  for (const Tick& tick : from.ticks) {
    positions->InsertNextValue(from.is_log ? std::log10(tick.value) : tick.value);
    names->InsertNextValue(tick.name);
  }
  axis->SetCustomTickPositions(positions, names);
}

Status write_picture(const Chart& chart, const std::string& path, int width, int height) {
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

  const DrawnChart all = drawn(chart);
  for (const ChartSeries& s : all.series) {
    vtkNew<vtkTable> table;
    vtkNew<vtkDoubleArray> x, y;
    x->SetName("x");
    y->SetName(s.name.c_str());
    for (std::size_t i = 0; i < s.x.size(); ++i) x->InsertNextValue(s.x[i]), y->InsertNextValue(s.y[i]);
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
  }
  set_axis(plot->GetAxis(vtkAxis::BOTTOM), all.x);
  set_axis(plot->GetAxis(vtkAxis::LEFT), all.y);
  surface.value()->window()->SetMultiSamples(8);
  view->Render();
  return write_png(surface.value()->window(), path);
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

std::string svg_of(const Chart& chart, int width, int height) {
  const DrawnChart all = drawn(chart);
  std::size_t longest = 0;
  for (const ChartSeries& s : all.series) longest = std::max(longest, s.name.size());
  // An approximation: a letter is 7.5 pixels wide on average.
  const double legend = longest == 0 ? 0 : 44 + 7.5 * static_cast<double>(longest);
  const double left = 74, top = 44, right = width - 20 - legend, bottom = height - 58;
  const auto x_at = [&](double v) { return left + (right - left) * all.x.share(v); };
  const auto y_at = [&](double v) { return bottom - (bottom - top) * all.y.share(v); };
  const auto text = [](double x, double y, const char* anchor, const std::string& words,
                       const char* more = "") {
    return format_text("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\"%s>", x, y, anchor, more) +
           escape_svg(words) + "</text>\n";
  };
  const auto line = [](double x, double y, double to_x, double to_y, const char* color) {
    return format_text("<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"%s\"/>\n", x, y, to_x, to_y, color);
  };
  std::string svg = format_text(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" font-family=\"system-ui,sans-serif\" "
      "font-size=\"14\" role=\"img\">\n<rect width=\"%d\" height=\"%d\" fill=\"#fff\"/>\n",
      width, height, width, height);
  svg += text(0.5 * (left + right), 26, "middle", chart.title, " font-size=\"19\"");
  for (const Tick& tick : all.x.ticks) {
    const double x = x_at(tick.value);
    svg += line(x, top, x, bottom, "#e4e4e4") + text(x, bottom + 20, "middle", tick.name);
  }
  for (const Tick& tick : all.y.ticks) {
    const double y = y_at(tick.value);
    svg += line(left, y, right, y, "#e4e4e4") + text(left - 8, y + 5, "end", tick.name);
  }
  svg += line(left, top, left, bottom, "#5a5a5a") + line(left, bottom, right, bottom, "#5a5a5a");
  svg += text(0.5 * (left + right), bottom + 44, "middle", all.x.title);
  svg += format_text("<g transform=\"translate(22 %.1f) rotate(-90)\">", 0.5 * (top + bottom)) +
         text(0, 0, "middle", all.y.title) + "</g>\n";
  double legend_y = top + 8;
  for (const ChartSeries& s : all.series) {
    const std::string color = format_text("#%02x%02x%02x", s.color[0], s.color[1], s.color[2]);
    const std::string pen = format_text("fill=\"none\" stroke=\"%s\" stroke-width=\"%g\"%s", color.c_str(),
                                        s.width, s.is_dashed ? " stroke-dasharray=\"6 4\"" : "");
    std::string sample;  // of the legend
    if (s.is_line) {
      svg += "<polyline points=\"";
      for (std::size_t i = 0; i < s.x.size(); ++i)
        svg += format_text("%s%.2f,%.2f", i == 0 ? "" : " ", x_at(s.x[i]), y_at(s.y[i]));
      svg += "\" " + pen + " stroke-linejoin=\"round\"/>\n";
      sample = format_text("<path d=\"M%.1f %.1fh22\" ", right + 14, legend_y) + pen + "/>\n";
    } else {
      svg += "<g fill=\"" + color + "\">\n";
      for (std::size_t i = 0; i < s.x.size(); ++i)
        svg += format_text("<circle cx=\"%.2f\" cy=\"%.2f\" r=\"%g\"/>\n", x_at(s.x[i]), y_at(s.y[i]),
                           0.5 * s.width);
      svg += "</g>\n";
      sample = format_text("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"%s\"/>\n", right + 25, legend_y,
                           color.c_str());
    }
    if (s.name.empty()) continue;
    svg += sample + text(right + 42, legend_y + 5, "start", s.name);
    legend_y += 20;
  }
  return svg + "</svg>\n";
}

std::string csv_of(const Chart& chart) {
  const auto cell = [](const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
    return quoted + "\"";
  };
  std::string csv = "series," + cell(chart.x_label) + "," + cell(chart.y_label) + "\n";
  for (const ChartSeries& s : chart.series)
    for (std::size_t i = 0; i < s.x.size(); ++i)
      csv += cell(s.name) + "," + text_of(s.x[i]) + "," + text_of(s.y[i]) + "\n";
  return csv;
}

Status write_chart(const Chart& chart, const std::string& path, int width, int height) {
  if (data_tools::has_extension(path, ".svg"))
    return data_tools::write_file_atomically(path, svg_of(chart, width, height));
  if (data_tools::has_extension(path, ".csv")) return data_tools::write_file_atomically(path, csv_of(chart));
  return write_picture(chart, path, width, height);
}

Status write_chart_files(const Chart& chart, const std::string& stem) {
  for (const char* extension : {".png", ".svg", ".csv"})
    if (Status error = write_chart(chart, stem + extension)) return error;
  return std::nullopt;
}

}  // namespace trephine::view
