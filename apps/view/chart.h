// Chart: picture of a chart: lines and dots on linear or logarithmic axes.
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

/// Draws into memory and writes a PNG. Points that an axis cannot show (not finite; on a logarithmic axis,
/// not positive) and lines of fewer than two points are omitted.
Status write_chart(const Chart& chart, const std::string& path, int width = 1000, int height = 640);

}  // namespace trephine::view
