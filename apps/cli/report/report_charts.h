// Charts of a report as inline SVG: values over time with marks of events and steps, histograms.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "apps/workbench/report_data.h"
#include "sim/api/finding.h"

namespace trephine::cli {

/// An event or a step in a chart over time.
struct ChartMark {
  double seconds = 0;
  std::string text;
  bool is_danger = false, is_step = false;
};

struct TimeChart {
  std::string title;  ///< with the unit: "Force, N"
  std::string label;  ///< for screen readers
  const workbench::Envelope* values = nullptr;
  double seconds = 0;       ///< of the session
  double axis_seconds = 0;  ///< length of the time axis, at least `seconds`
  double axis_top = 0;      ///< highest value of the axis; 0: that of the values
  std::vector<ChartMark> marks = {};
};
/// Draws the band between least and greatest values, with triangles for dangerous events, circles for other
/// events and labelled lines for steps.
std::string svg_of(const TimeChart& chart);

/// Values by session, in the order of the sessions.
struct CourseChart {
  struct Value {
    std::optional<double> value;  ///< empty: a gap
    sim::Finding::Verdict verdict = sim::Finding::Verdict::not_judged;
  };
  std::string title, label;  ///< as of a TimeChart
  std::vector<Value> values = {};
  std::optional<std::pair<double, double>> limits =
      {};  ///< the value that scores all points, and the one that scores none
  bool is_wide = false;
};
/// Draws a mark per session, joined by a line: disks are good, triangles fair, squares bad, rings without
/// verdict.
std::string svg_of(const CourseChart& chart);

/// Draws the paths of all hands from three sides, to one scale: thin in contact, thick with the button
/// pressed or in a track. Returns no pictures if no hand has strokes.
std::vector<std::string> svgs_of(std::span<const workbench::ToolPath> paths);

/// Draws the removed volume by its distance from a structure, in bars of 1 mm.
std::string svg_of(const workbench::RemovalDistances& distances);

}  // namespace trephine::cli
