// Chart: lines and dots on linear or logarithmic axes, as a picture, as SVG or as a table.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::view {

struct ChartSeries {
  std::string name;  ///< empty: not in the legend
  std::vector<double> x, y;
  bool is_line = false;  ///< false: dots
  std::array<std::uint8_t, 3> color{40, 90, 160};
  float width = 2;  ///< width of the line or diameter of the dots, pixels
  bool is_dashed = false;
};

struct Chart {
  std::string title, x_label, y_label;
  bool is_x_log = false, is_y_log = false;
  std::vector<ChartSeries> series;
};

/// Returns colour `i` of a palette of 16. The first six are distinguishable with red-green blindness (Okabe
/// and Ito 2008).
std::array<std::uint8_t, 3> chart_color(std::size_t i);

/// Returns the chart as SVG. Points that an axis cannot show (not finite; on a logarithmic axis, not
/// positive) and lines of fewer than two points are omitted.
std::string svg_of(const Chart& chart, int width = 1000, int height = 640);

/// Returns all points as CSV: name of the series, x, y.
std::string csv_of(const Chart& chart);

/// Writes SVG or CSV if the name of the file has this extension, else a PNG, which omits points as svg_of()
/// does.
Status write_chart(const Chart& chart, const std::string& path, int width = 1000, int height = 640);

/// Writes the chart as PNG, SVG and CSV. `stem`: the path without its extension.
Status write_chart_files(const Chart& chart, const std::string& stem);

}  // namespace trephine::view
