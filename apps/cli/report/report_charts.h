// Charts of a report as inline SVG: values over time with marks of events and steps, histograms.
#pragma once

#include <string>
#include <vector>

#include "apps/workbench/report_data.h"

namespace trephine::cli {

/// An event or a step in a chart over time.
struct ChartMark {
  double seconds = 0;
  std::string text;
  bool is_danger = false, is_step = false;
};

struct TimeChart {
  std::string title;  ///< with the unit: "Force, N"
  std::string label;  ///< for readers that do not see it
  const workbench::Envelope* values = nullptr;
  double seconds = 0;       ///< of the session
  double axis_seconds = 0;  ///< length of the time axis, at least `seconds`
  double axis_top = 0;      ///< highest value of the axis; 0: that of the values
  std::vector<ChartMark> marks = {};
};
/// Draws the band between least and greatest values, with triangles for dangerous events, circles for other
/// events and labelled lines for steps.
std::string svg_of(const TimeChart& chart);

/// Draws bars of 1 mm.
std::string svg_of(const workbench::RemovalDistances& distances);

}  // namespace trephine::cli
