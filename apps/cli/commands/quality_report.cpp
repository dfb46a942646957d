#include "apps/cli/commands/quality_report.h"

#include <cmath>

#include "apps/view/chart.h"

namespace trephine::cli {

void report_quality(const data_tools::ScanQuality& q, bool is_hounsfield, double low, Rows& rows) {
  const auto json_of = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
  rows.json["quality"] = {{"blur_in_plane_mm", json_of(q.blur_in_plane)},
                          {"blur_across_mm", json_of(q.blur_across)},
                          {"edges", q.edge_count},
                          {"is_rough", q.is_rough},
                          {"noise", json_of(q.noise)},
                          {"slice_step_mm", q.slice_step},
                          {"thinnest_mm", json_of(q.thinnest)},
                          {"least_wall_mm", json_of(q.min_wall)},
                          {"least_gap_mm", json_of(q.min_gap)}};
  const Json& row = rows.json["quality"];
  if (q.blur_in_plane)
    rows.print(std::string("  sharpness: edges are blurred by ") + (q.is_rough ? "about " : "") +
                   "{blur_in_plane_mm:.2f} mm within slices, " +
                   (q.blur_across ? "{blur_across_mm:.2f} mm"
                                  : "an unknown amount (too few edges are parallel to the slices)") +
                   " from slice to slice (sigma, at {edges} edges)",
               row);
  else
    rows.print(std::string("  sharpness: edges are blurred by an unknown amount: only {edges} edge") +
                   (q.edge_count == 1 ? " is" : "s are") + " far enough from other edges to be measured",
               row);
  const std::string unit = is_hounsfield ? " HU" : "";
  rows.print("  noise: {noise:.0f}" + (q.noise ? unit : "") + "; slices are {slice_step_mm:.3g} mm apart",
             row);
  std::string solid;
  if (q.thinnest) solid = "2 % of its walls are thinner than {quality/thinnest_mm:.2f} mm";
  if (q.min_wall)
    solid += std::string(q.thinnest ? "; " : "") +
             "walls of {quality/least_wall_mm:.2f} mm and more are touched without holes, gaps of "
             "{quality/least_gap_mm:.2f} mm and more are open";
  rows.print("  solid (from {low:.0f}" + unit + "): " + (solid.empty() ? "unknown" : solid), {{"low", low}});
}

Status write_quality_chart(const data_tools::ScanQuality& q, const std::string& path) {
  if (q.edge_points.empty())
    return Error{.what = "no edge for the chart",
                 .where = "chart",
                 .found = "no edge far enough from others",
                 .expected = "at least one measurable edge",
                 .remedy = "pass the whole scan, with skin and air"};
  view::Chart chart;
  chart.title = "edges of the scan, superimposed";
  chart.x_label = "mm from the edge, inward";
  chart.y_label = "share of the edge's rise in intensity";
  view::ChartSeries points;
  points.name = "voxels";
  points.color = {150, 165, 185};
  points.width = 2;
  for (const data_tools::ScanQuality::EdgePoint& point : q.edge_points) {
    points.x.push_back(point.distance);
    points.y.push_back(point.share);
  }
  chart.series.push_back(std::move(points));
  if (q.blur_in_plane) {
    view::ChartSeries line;
    line.name = format_text("sigma %.2f mm", *q.blur_in_plane);
    line.is_line = true;
    line.color = view::chart_color(1);
    for (double s = -4; s <= 4; s += 0.05) {
      line.x.push_back(s * *q.blur_in_plane);
      line.y.push_back(0.5 * std::erfc(-s / std::sqrt(2.0)));
    }
    chart.series.push_back(std::move(line));
  }
  return view::write_chart(chart, path);
}

}  // namespace trephine::cli
