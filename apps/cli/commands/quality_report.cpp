#include "apps/cli/commands/quality_report.h"

#include <cmath>

#include "apps/view/chart.h"

namespace trephine::cli {

Json quality_json(const data_tools::ScanQuality& q) {
  Json json = Json::object();
  const auto add = [&json](const char* key, const std::optional<double>& value) {
    json[key] = value ? Json(*value) : Json(nullptr);
  };
  add("blur_in_plane_mm", q.blur_in_plane);
  add("blur_across_mm", q.blur_across);
  json["edges"] = q.edges;
  json["is_rough"] = q.is_rough;
  add("noise", q.noise);
  json["slice_step_mm"] = q.slice_step;
  add("thinnest_mm", q.thinnest);
  add("least_wall_mm", q.min_wall);
  add("least_gap_mm", q.min_gap);
  return json;
}

std::string quality_text(const data_tools::ScanQuality& q, bool is_hounsfield, double low) {
  const auto mm = [](const std::optional<double>& value) {
    return value ? format_text("%.2f mm", *value) : std::string("unknown");
  };
  const char* unit = is_hounsfield ? " HU" : "";
  std::string text = "  sharpness: edges are blurred by ";
  if (q.blur_in_plane)
    text += (q.is_rough ? "about " : "") + mm(q.blur_in_plane) + " within slices, " +
            (q.blur_across ? mm(q.blur_across) : std::string("an unknown amount (too few edges lie level)")) +
            format_text(" from slice to slice (sigma, at %d edges)\n", q.edges);
  else
    text += format_text("an unknown amount: only %d edge%s free enough to be measured\n", q.edges,
                        q.edges == 1 ? " is" : "s are");
  text += "  noise: " + (q.noise ? format_text("%.0f%s", *q.noise, unit) : std::string("unknown")) +
          format_text("; slices are %.3g mm apart\n", q.slice_step);
  text += format_text("  solid (from %.0f%s): ", low, unit);
  if (q.thinnest) text += "2 % of its surface has less than " + mm(q.thinnest) + " of it below";
  if (q.min_wall)
    text += (q.thinnest ? "; " : "") + std::string("a wall of ") + mm(q.min_wall) +
            " and more is touched as whole, a gap of " + mm(q.min_gap) + " and more as open";
  return text + (q.thinnest || q.min_wall ? "\n" : "unknown\n");
}

Status write_quality_chart(const data_tools::ScanQuality& q, const std::string& path) {
  if (q.edge.empty())
    return Error{.what = "no edge for the chart",
                 .where = "chart",
                 .found = "no edge far enough from others",
                 .expected = "at least one measurable edge",
                 .remedy = "pass the whole scan, with skin and air"};
  view::Chart chart;
  chart.title = "edges of the scan, laid over each other";
  chart.x_label = "mm from the edge, inward";
  chart.y_label = "share of the step";
  view::ChartSeries points;
  points.name = "voxels";
  points.color = {150, 165, 185};
  points.width = 2;
  for (const data_tools::ScanQuality::EdgePoint& point : q.edge) {
    points.x.push_back(point.place);
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
