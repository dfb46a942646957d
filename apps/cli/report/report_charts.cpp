#include "apps/cli/report/report_charts.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "apps/cli/report/report_html.h"
#include "apps/workbench/text.h"

namespace trephine::cli {

using workbench::format_text;

namespace {

/// Returns the largest step of 1, 2 or 5 times a power of ten that divides a length into at least `parts`.
double round_step(double length, double parts) {
  const double raw = length / parts, power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= raw) return factor * power;
  return power;
}

/// Plotting area, in the units of the SVG, and its scales.
struct Plot {
  double left, top, width, height;
  double x_end, y_end;  ///< values at the right and at the upper edge
  double x_begin = 0, y_begin = 0;

  double x(double value) const { return left + width * (value - x_begin) / (x_end - x_begin); }
  double y(double value) const {
    return top + height * (1 - (std::clamp(value, y_begin, y_end) - y_begin) / (y_end - y_begin));
  }

  /// Draws the axes with their numbers.
  std::string axes(double x_parts, double y_parts, const char* x_title) const {
    std::string svg;
    const double y_step = round_step(y_end - y_begin, y_parts), x_step = round_step(x_end, x_parts);
    for (int i = 0; y_begin + i * y_step <= y_end + 0.001 * y_step; ++i) {
      const double value = y_begin + i * y_step;
      svg += format_text(
          "<path class=\"grid\" d=\"M%.1f %.1fh%.1f\"/><text class=\"end\" x=\"%.1f\" y=\"%.1f\">%g"
          "</text>",
          left, y(value), width, left - 6, y(value) + 4, std::abs(value) < 1e-9 * y_step ? 0 : value);
    }
    for (double value = x_begin == 0 ? 0 : x_step; value <= x_end * 1.0001; value += x_step)
      svg += format_text(
          "<path class=\"grid\" d=\"M%.1f %.1fv4\"/><text class=\"mid\" x=\"%.1f\" y=\"%.1f\">%g"
          "</text>",
          x(value), top + height, x(value), top + height + 17, value);
    return svg + format_text("<text class=\"end\" x=\"%.1f\" y=\"%.1f\">%s</text>", left + width,
                             top + height + 31, x_title);
  }
};

std::string svg_begin(double width, double height, const std::string& label) {
  return format_text("<svg viewBox=\"0 0 %g %g\" role=\"img\" aria-label=\"", width, height) +
         escaped(label) + "\">\n";
}

/// Returns the outlines of the band: a polygon for each run of columns that have values.
std::string band(const workbench::Envelope& values, const Plot& plot, double seconds) {
  const auto columns = values.columns();
  const auto x_of = [&](std::size_t i) {
    return plot.x(seconds * (static_cast<double>(i) + 0.5) / static_cast<double>(columns.size()));
  };
  constexpr double k_half_line = 0.6;  // a band of equal values remains visible
  std::string path;
  for (std::size_t i = 0; i < columns.size();) {
    if (!columns[i].has_value) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < columns.size() && columns[end].has_value) ++end;
    for (std::size_t k = i; k < end; ++k)
      path += format_text("%c%.1f %.1f", k == i ? 'M' : 'L', x_of(k), plot.y(columns[k].high) - k_half_line);
    for (std::size_t k = end; k-- > i;)
      path += format_text("L%.1f %.1f", x_of(k), plot.y(columns[k].low) + k_half_line);
    path += 'Z';
    i = end;
  }
  return "<path class=\"band\" d=\"" + path + "\"/>";
}

std::string mark_of(const ChartMark& mark, const Plot& plot) {
  const double x = plot.x(mark.seconds), y = plot.top - 7;
  const std::string title =
      "<title>" + format_text("%.1f s: ", mark.seconds) + escaped(mark.text) + "</title>";
  if (mark.is_step)
    return format_text("<g class=\"step\"><path d=\"M%.1f %.1fV%.1f\"/><text x=\"%.1f\" y=\"%.1f\">", x,
                       plot.top - 30, plot.top + plot.height, x + 3, plot.top - 20) +
           escaped(mark.text) + "</text>" + title + "</g>\n";
  if (mark.is_danger)
    return format_text(
               "<g class=\"danger\"><path class=\"stem\" d=\"M%.1f %.1fV%.1f\"/><path d=\"M%.1f %.1fl5 "
               "-9h-10z\"/>",
               x, y + 2, plot.top + plot.height, x, y + 3) +
           title + "</g>\n";
  return format_text("<g class=\"event\"><circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.2\"/>", x, y - 2) + title +
         "</g>\n";
}

}  // namespace

std::string svg_of(const TimeChart& chart) {
  const double top = chart.axis_top > 0 ? chart.axis_top : chart.values->greatest();
  const double highest = top > 0 ? top : 1, step = round_step(highest, 3);
  const Plot plot{44, 42, 864, 130, std::max(chart.axis_seconds, 1e-3), std::ceil(highest / step) * step};
  std::string svg = svg_begin(920, 212, chart.label);
  svg += "<text class=\"title\" x=\"0\" y=\"12\">" + escaped(chart.title) + "</text>\n";
  svg += plot.axes(8, 3, "time, s") + "\n" + band(*chart.values, plot, chart.seconds) + "\n";
  for (const ChartMark& mark : chart.marks) svg += mark_of(mark, plot);
  return svg + "</svg>\n";
}

namespace {

std::string session_mark(const CourseChart::Value& value, double x, double y, std::size_t number) {
  static constexpr const char* k_shapes[] = {"<circle class=\"open\" r=\"3.5\"/>", "<circle r=\"4\"/>",
                                             "<path d=\"M0 -5l5 9h-10z\"/>", "<path d=\"M-4 -4h8v8h-8z\"/>"};
  static constexpr const char* k_classes[] = {"", "good", "fair", "bad"};
  const auto verdict = static_cast<std::size_t>(value.verdict);
  return format_text(
      "<g class=\"session %s\" transform=\"translate(%.1f %.1f)\">%s<title>session %zu: %.4g"
      "</title></g>\n",
      k_classes[verdict], x, y, k_shapes[verdict], number, *value.value);
}

/// Returns the range of an axis that contains the values, the limits and 0.
std::pair<double, double> range_of(const CourseChart& chart) {
  double low = 0, high = 0;
  const auto include = [&](double value) { low = std::min(low, value), high = std::max(high, value); };
  for (const CourseChart::Value& value : chart.values)
    if (value.value) include(*value.value);
  if (chart.limits) include(chart.limits->first), include(chart.limits->second);
  if (high - low <= 0) high = 1;
  const double step = round_step(high - low, 3);
  return {std::floor(low / step) * step, std::ceil(high / step) * step};
}

}  // namespace

std::string svg_of(const CourseChart& chart) {
  const auto [low, high] = range_of(chart);
  const double size = static_cast<double>(chart.values.size());
  Plot plot{52, 30, chart.is_wide ? 850.0 : 320.0, chart.is_wide ? 150.0 : 110.0, size + 0.5, high, 0.5, low};
  std::string svg = svg_begin(chart.is_wide ? 920 : 390, chart.is_wide ? 220 : 180, chart.label);
  svg += "<text class=\"title\" x=\"0\" y=\"12\">" + escaped(chart.title) + "</text>\n";
  svg += plot.axes(std::min(size + 0.5, 10.0), 3, "session") + "\n";
  if (chart.limits)
    for (const auto& [limit, words] :
         {std::pair(chart.limits->first, "all points"), std::pair(chart.limits->second, "no points")})
      svg += format_text(
          "<path class=\"limit\" d=\"M%.1f %.1fh%.1f\"/><text class=\"end\" x=\"%.1f\" y=\"%.1f\">%s</text>\n",
          plot.left, plot.y(limit), plot.width, plot.left + plot.width, plot.y(limit) - 3, words);
  std::string line, marks;
  bool is_joined = false;
  for (std::size_t i = 0; i < chart.values.size(); ++i) {
    const CourseChart::Value& value = chart.values[i];
    if (!value.value) {
      is_joined = false;
      continue;
    }
    const double x = plot.x(static_cast<double>(i + 1)), y = plot.y(*value.value);
    line += format_text("%c%.1f %.1f", is_joined ? 'L' : 'M', x, y);
    marks += session_mark(value, x, y, i + 1);
    is_joined = true;
  }
  return svg + "<path class=\"curve\" d=\"" + line + "\"/>\n" + marks + "</svg>\n";
}

namespace {

/// A side from which paths are drawn: axes of the picture in LPS, and letters at its edges.
struct PathView {
  const char* name;
  glm::dvec3 right, up;
  const char *left_letter, *right_letter, *upper_letter, *lower_letter;
};
constexpr PathView k_path_views[] = {{"from the front", {1, 0, 0}, {0, 0, 1}, "R", "L", "S", "I"},
                                     {"from the left", {0, 1, 0}, {0, 0, 1}, "A", "P", "S", "I"},
                                     {"from above", {-1, 0, 0}, {0, -1, 0}, "L", "R", "A", "P"}};

/// Box of all points of paths.
std::pair<glm::dvec3, glm::dvec3> bounds_of(std::span<const workbench::ToolPath> paths) {
  glm::dvec3 low(1e300), high(-1e300);
  for (const workbench::ToolPath& path : paths)
    for (const workbench::ToolPath::Stroke& stroke : path.strokes())
      for (const glm::dvec3& p : stroke.points_world) low = glm::min(low, p), high = glm::max(high, p);
  return {low, high};
}

}  // namespace

std::vector<std::string> svgs_of(std::span<const workbench::ToolPath> paths) {
  const auto [low, high] = bounds_of(paths);
  if (!(low.x <= high.x)) return {};
  constexpr double k_edge = 280, k_top = 40, k_least_mm = 10;
  const glm::dvec3 size = high - low, middle = 0.5 * (low + high);
  const double extent = 1.05 * std::max({size.x, size.y, size.z, k_least_mm}), scale = k_edge / extent;
  constexpr double k_centre_x = 0.5 * k_edge + 1, k_centre_y = k_top + 0.5 * k_edge;
  std::vector<std::string> svgs;
  for (const PathView& view : k_path_views) {
    std::string svg =
        svg_begin(k_edge + 2, k_top + k_edge + 56, std::string("paths of the tools ") + view.name);
    svg += format_text("<text class=\"title\" x=\"0\" y=\"12\">%s</text>\n", view.name);
    svg += format_text("<rect class=\"frame\" x=\"1\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>\n", k_top,
                       k_edge, k_edge);
    svg += format_text(
        "<text class=\"mid\" x=\"%.1f\" y=\"%.1f\">%s</text><text class=\"mid\" x=\"%.1f\" y=\"%.1f\">%s</text>"
        "<text x=\"6\" y=\"%.1f\">%s</text><text class=\"end\" x=\"%.1f\" y=\"%.1f\">%s</text>\n",
        k_centre_x, k_top - 6, view.upper_letter, k_centre_x, k_top + k_edge + 16, view.lower_letter,
        k_centre_y, view.left_letter, k_edge - 4, k_centre_y, view.right_letter);
    for (std::size_t hand = 0; hand < paths.size(); ++hand)
      for (const bool is_working : {false, true}) {
        std::string lines;
        for (const workbench::ToolPath::Stroke& stroke : paths[hand].strokes()) {
          if (stroke.is_working != is_working) continue;
          for (std::size_t i = 0; i < stroke.points_world.size(); ++i) {
            const glm::dvec3 p = stroke.points_world[i] - middle;
            lines +=
                format_text("%c%.1f %.1f", i == 0 ? 'M' : 'L', k_centre_x + scale * glm::dot(p, view.right),
                            k_centre_y - scale * glm::dot(p, view.up));
          }
          if (stroke.points_world.size() == 1) lines += "h0";  // a dot, by its round ends
        }
        if (!lines.empty())
          svg += format_text("<path class=\"tool hand%zu%s\" d=\"", std::min<std::size_t>(hand, 1) + 1,
                             is_working ? " working" : "") +
                 lines + "\"/>\n";
      }
    const double bar = round_step(extent, 3), y = k_top + k_edge + 40;
    svg += format_text(
        "<path class=\"scale\" d=\"M1 %.1fv6h%.1fv-6\"/><text x=\"%.1f\" y=\"%.1f\">%g mm</text>\n", y,
        scale * bar, scale * bar + 7, y + 6, bar);
    svgs.push_back(svg + "</svg>\n");
  }
  return svgs;
}

std::string svg_of(const workbench::RemovalDistances& distances) {
  const double most =
      std::max(distances.inside_mm3, *std::max_element(distances.mm3.begin(), distances.mm3.end()));
  const double highest = most > 0 ? most : 1, step = round_step(highest, 3);
  const std::string name = workbench::words_of(distances.structure);
  const Plot plot{
      52, 30, 320, 110, static_cast<double>(distances.mm3.size()), std::ceil(highest / step) * step};
  std::string svg = svg_begin(390, 180, "Removed matter by distance to " + name + ", mm3 by mm");
  svg += "<text class=\"title\" x=\"0\" y=\"12\">" + escaped(name) + ", mm\u00b3</text>\n";
  svg += plot.axes(4, 3, "distance, mm") + "\n";
  for (std::size_t i = 0; i < distances.mm3.size(); ++i) {
    if (!(distances.mm3[i] > 0)) continue;
    const double x = plot.x(static_cast<double>(i)), y = plot.y(distances.mm3[i]);
    svg += format_text(
        "<rect class=\"bar\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"><title>%zu to %zu mm: "
        "%.1f mm\u00b3</title></rect>",
        x + 1, y, plot.width / plot.x_end - 2, plot.top + plot.height - y, i, i + 1, distances.mm3[i]);
  }
  return svg + "</svg>\n";
}

}  // namespace trephine::cli
