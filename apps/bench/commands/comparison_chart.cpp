#include "apps/bench/commands/comparison_chart.h"

#include <algorithm>
#include <cmath>

#include "apps/cli/report/report_html.h"
#include "apps/cli/score_rows.h"
#include "apps/workbench/text.h"

namespace trephine::bench {

using cli::escaped;
using workbench::format_text;

namespace {

constexpr double k_width = 960, k_height = 620;
constexpr const char* k_colors[] = {"#c8500a", "#5b6b7c", "#0a7d5c"};

/// A logarithmic axis over whole decades.
struct LogAxis {
  double first, last;  ///< exponents of ten
  double begin, end;   ///< positions in the units of the SVG

  LogAxis(double least, double greatest, double from, double to)
      : first(std::floor(std::log10(least) + 1e-9)),
        last(std::ceil(std::log10(greatest) - 1e-9)),
        begin(from),
        end(to) {
    if (last <= first) last = first + 1;
  }
  double at(double value) const {
    const double share = (std::log10(std::max(value, 1e-300)) - first) / (last - first);
    return begin + (end - begin) * std::clamp(share, 0.0, 1.0);
  }
};

struct Box {
  double left, top, right, bottom;
  bool meets(const Box& b) const {
    return left < b.right && b.left < right && top < b.bottom && b.top < bottom;
  }
};

/// Returns the marker around the origin: a disk for trephine, a square for a published method, a triangle for
/// another program.
std::string marker(ComparedMethod::Kind kind, bool is_hollow) {
  static constexpr const char* k_shapes[] = {"<circle r=\"6.5\"", "<path d=\"M-5.5 -5.5h11v11h-11z\"",
                                             "<path d=\"M0 -7l7 12h-14z\""};
  const auto index = static_cast<std::size_t>(kind);
  return std::string(k_shapes[index]) + " fill=\"" + (is_hollow ? "#fff" : k_colors[index]) + "\" stroke=\"" +
         k_colors[index] + "\" stroke-width=\"2\"/>";
}

/// Approximate width of a text in the font of the chart.
double text_width(const std::string& text) { return 8.0 * static_cast<double>(text.size()) + 3; }

/// Returns the box for the name of the method at (x, y): the nearest free one, or else one with few overlaps.
Box label_box(double x, double y, double width, const std::vector<Box>& occupied, const Box& plot) {
  Box best{};
  double least = 1e300;
  for (int row = 0; row <= 10; ++row)
    for (const int sign : {-1, 1})
      for (const int side : {1, -1, 0}) {
        if (side == 0 && row < 2) continue;  // it would cover the point
        const double rise = sign * (row < 1 ? 0.65 : 0.65 + 0.5 * row);
        const double left = side > 0 ? x + 11 : side < 0 ? x - 11 - width : x - 0.5 * width;
        const Box box{left, y + 16 * rise - 8, left + width, y + 16 * rise + 7};
        double cost = std::abs(rise) + 0.2 * (side < 0);
        for (const Box& other : occupied) cost += box.meets(other) ? 20 : 0;
        if (box.left < plot.left || box.right > plot.right || box.top < plot.top || box.bottom > plot.bottom)
          cost += 50;
        if (cost < least) least = cost, best = box;
      }
  return best;
}

std::string axes(const LogAxis& x, const LogAxis& y, const ComparisonChart& chart) {
  std::string svg;
  for (double e = x.first; e <= x.last; ++e) {
    const double at = x.at(std::pow(10, e));
    svg += format_text(
        "<path d=\"M%.1f %.1fV%.1f\" stroke=\"#e3e3e3\"/><text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%g</text>\n",
        at, y.end, y.begin, at, y.begin + 20, std::pow(10, e));
  }
  for (double e = y.first; e <= y.last; ++e) {
    const double at = y.at(std::pow(10, e));
    svg += format_text(
        "<path d=\"M%.1f %.1fH%.1f\" stroke=\"#e3e3e3\"/><text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%g</text>\n",
        x.begin, at, x.end, x.begin - 8, at + 5, std::pow(10, e));
  }
  svg += format_text(
      "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">time of a step in contact, \xc2\xb5s</text>\n",
      0.5 * (x.begin + x.end), y.begin + 42);
  svg += format_text("<text transform=\"translate(20 %.1f) rotate(-90)\" text-anchor=\"middle\">",
                     0.5 * (y.begin + y.end));
  return svg + escaped(chart.error_label) + "</text>\n";
}

std::string legend(double left, double top) {
  std::string svg;
  static constexpr const char* k_kinds[] = {"trephine", "published method, in trephine's code",
                                            "other program"};
  static constexpr double k_offsets[] = {0, 110, 410};
  for (std::size_t i = 0; i < 3; ++i)
    svg += format_text("<g transform=\"translate(%.1f %.1f)\">", left + k_offsets[i], top - 5) +
           marker(static_cast<ComparedMethod::Kind>(i), false) + "<text x=\"13\" y=\"5\">" + k_kinds[i] +
           "</text></g>\n";
  svg += format_text("<g transform=\"translate(%.1f %.1f)\">", left + 560, top - 5) +
         marker(ComparedMethod::Kind::published, true) +
         "<text x=\"13\" y=\"5\">hollow: fell through a surface</text></g>\n";
  return svg + format_text(
                   "<text x=\"%.1f\" y=\"%.1f\" fill=\"#666\">Lower left is better. Bars: time p50 to p99.9, "
                   "error lower to upper quartile of the scenes.</text>\n",
                   left - 6, top + 20);
}

}  // namespace

std::string svg_of(const ComparisonChart& all) {
  ComparisonChart chart = all;
  std::erase_if(chart.methods, [](const ComparedMethod& m) {
    return !(m.time_us > 0) || !std::isfinite(m.slow_us) || !std::isfinite(m.median);
  });
  for (ComparedMethod& m : chart.methods) {
    for (double* error : {&m.low, &m.median, &m.high}) *error = std::max(*error, chart.least_error);
    m.slow_us = std::max(m.slow_us, m.time_us);
  }
  std::string svg = format_text(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %g %g\" font-family=\"system-ui,sans-serif\" "
      "font-size=\"14\" role=\"img\">\n<rect width=\"%g\" height=\"%g\" fill=\"#fff\"/>\n",
      k_width, k_height, k_width, k_height);
  svg += "<text x=\"74\" y=\"28\" font-size=\"19\" font-weight=\"600\">" + escaped(chart.title) + "</text>\n";
  if (chart.methods.empty()) return svg + "</svg>\n";
  double least = 1e300, greatest = 0, fastest = 1e300, slowest = 0;
  for (const ComparedMethod& m : chart.methods) {
    least = std::min(least, m.low), greatest = std::max(greatest, m.high);
    fastest = std::min(fastest, m.time_us), slowest = std::max(slowest, m.slow_us);
  }
  if (chart.threshold > 0)
    least = std::min(least, chart.threshold), greatest = std::max(greatest, chart.threshold);
  const LogAxis x(fastest, slowest, 74, k_width - 24), y(least, greatest, k_height - 112, 48);
  const Box plot{x.begin, y.end, x.end, y.begin};
  svg += axes(x, y, chart);
  std::vector<Box> occupied;
  if (chart.threshold > 0) {
    const double at = y.at(chart.threshold);
    svg +=
        format_text(
            "<path d=\"M%.1f %.1fH%.1f\" stroke=\"#b00020\" stroke-dasharray=\"6 4\"/><text x=\"%.1f\" y=\"%.1f\" "
            "fill=\"#b00020\" text-anchor=\"end\">",
            x.begin, at, x.end, x.end - 4, at - 6) +
        escaped(chart.threshold_label) + "</text>\n";
    occupied.push_back({x.end - 4 - text_width(chart.threshold_label), at - 20, x.end, at + 2});
  }
  for (const ComparedMethod& m : chart.methods) {
    const double at_x = x.at(m.time_us), at_y = y.at(m.median);
    svg += format_text(
        "<path d=\"M%.1f %.1fH%.1fM%.1f %.1fV%.1f\" stroke=\"%s\" stroke-width=\"1.6\" opacity=\"0.55\"/>\n",
        at_x, at_y, x.at(m.slow_us), at_x, y.at(m.low), y.at(m.high),
        k_colors[static_cast<std::size_t>(m.kind)]);
    occupied.push_back({at_x - 8, at_y - 8, at_x + 8, at_y + 8});
  }
  for (const ComparedMethod& m : chart.methods) {
    svg += format_text("<g transform=\"translate(%.1f %.1f)\"><title>", x.at(m.time_us), y.at(m.median)) +
           escaped(m.name) +
           format_text(": %.3g \xc2\xb5s, error %.3g, fell %ld times</title>", m.time_us, m.median, m.falls) +
           marker(m.kind, m.falls > 0) + "</g>\n";
  }
  // The last points are drawn on top, so their labels are placed first.
  for (auto m = chart.methods.rbegin(); m != chart.methods.rend(); ++m) {
    const double at_x = x.at(m->time_us), at_y = y.at(m->median);
    const Box box = label_box(at_x, at_y, text_width(m->name), occupied, plot);
    occupied.push_back(box);
    const char* color = k_colors[static_cast<std::size_t>(m->kind)];
    const double middle = 0.5 * (box.left + box.right), edge = box.top > at_y ? box.top : box.bottom;
    if (std::abs(edge - at_y) > 14)
      svg += format_text("<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"%s\" opacity=\"0.6\"/>\n", at_x, at_y,
                         std::clamp(at_x, box.left, box.right), edge, color);
    svg +=
        format_text(
            "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" fill=\"%s\"%s stroke=\"#fff\" stroke-width=\"3\" "
            "paint-order=\"stroke\">",
            middle, box.bottom - 3, color, m->is_default ? " font-weight=\"700\"" : "") +
        escaped(m->name) + "</text>\n";
  }
  return svg + legend(x.begin + 6, k_height - 34) + "</svg>\n";
}

std::string csv_of(const ComparisonChart& chart) {
  static constexpr const char* k_kinds[] = {"trephine", "published", "other"};
  std::string csv =
      "method,kind,us_p50,us_p999,error_lower_quartile,error_median,error_upper_quartile,fall_throughs\n";
  for (const ComparedMethod& m : chart.methods)
    csv += cli::csv_cell(m.name) + "," + k_kinds[static_cast<std::size_t>(m.kind)] +
           format_text(",%.4g,%.4g,%.4g,%.4g,%.4g,%ld\n", m.time_us, m.slow_us, m.low, m.median, m.high,
                       m.falls);
  return csv;
}

}  // namespace trephine::bench
