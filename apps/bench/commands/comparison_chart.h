// ComparisonChart: run time against error, a point with error bars per method, as SVG and as a table.
#pragma once

#include <string>
#include <vector>

namespace trephine::bench {

/// A method in a chart: medians over scenes, with their spread.
struct ComparedMethod {
  enum class Kind : unsigned char { ours, published, library };
  std::string name;
  Kind kind = Kind::ours;
  bool is_default = false;
  double time_us = 0, slow_us = 0;       ///< p50 and p99.9 of a step, medians over the scenes
  double low = 0, median = 0, high = 0;  ///< quartiles of the error over the scenes
  long falls = 0;                        ///< falls through a surface, over all scenes
};

struct ComparisonChart {
  std::string title, error_label;  ///< label with the unit
  double threshold = 0;            ///< smallest error that a hand perceives; 0: no line
  std::string threshold_label;
  std::vector<ComparedMethod> methods;
};

/// Draws logarithmic axes, error bars (p50 to p99.9, quartiles of the error), and a name at each point. A
/// hollow point fell through a surface.
std::string svg_of(const ComparisonChart& chart);
/// Returns the points as CSV with a header.
std::string csv_of(const ComparisonChart& chart);

}  // namespace trephine::bench
