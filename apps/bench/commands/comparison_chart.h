// ComparisonChart: run time against error, a point with error bars per method, as SVG and as a table.
#pragma once

#include <string>
#include <vector>

namespace trephine::bench {

/// A method in a chart: medians over scenes, with their spread.
struct ComparedMethod {
  enum class Kind : unsigned char { ours, published, other };
  std::string name;
  Kind kind = Kind::ours;
  bool is_default = false;
  double time_us = 0, slow_us = 0;       ///< p50 and p99.9 of a step, medians over the scenes
  double low = 0, median = 0, high = 0;  ///< quartiles of the error over the scenes
  long falls = 0;                        ///< falls through a surface, over all scenes
};

struct ComparisonChart {
  std::string title, error_label;  ///< label with the unit
  double threshold = 0;            ///< value of a reference line; 0: no line
  std::string threshold_label;
  double least_error = 1e-4;
  std::vector<ComparedMethod> methods;
};

/// Draws logarithmic axes, error bars (p50 to p99.9, quartiles of the error), and a name at each point. A
/// hollow marker: the method fell through a surface. Errors below `least_error` are drawn at it; methods
/// without a positive time are left out.
std::string svg_of(const ComparisonChart& chart);
/// Returns the points as CSV with a header.
std::string csv_of(const ComparisonChart& chart);

}  // namespace trephine::bench
