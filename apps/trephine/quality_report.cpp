#include "apps/trephine/quality_report.h"

#include <cmath>

#include "apps/view/chart.h"

namespace trephine::app {

Json quality_json(const data_tools::ScanQuality& q) {
  Json json = Json::object();
  const auto add = [&json](const char* key, const std::optional<double>& value) {
    json[key] = value ? Json(*value) : Json(nullptr);
  };
  add("blur_in_plane_mm", q.blur_in_plane);
  add("blur_across_mm", q.blur_across);
  json["edges"] = q.edges;
  add("noise", q.noise);
  json["slice_step_mm"] = q.slice_step;
  add("thinnest_mm", q.thinnest);
  add("least_wall_mm", q.least_wall);
  add("least_gap_mm", q.least_gap);
  return json;
}

std::string quality_text(const data_tools::ScanQuality& q, bool is_hounsfield, double low) {
  const auto mm = [](const std::optional<double>& value) {
    return value ? format_text("%.2f mm", *value) : std::string("unknown");
  };
  const char* unit = is_hounsfield ? " HU" : "";
  std::string text = "  blur " + mm(q.blur_in_plane) + " in a slice, " + mm(q.blur_across) +
                     " across (sigma of " + format_text("%d edges, a voxel's size included)\n", q.edges);
  text += "  noise " + (q.noise ? format_text("%.0f%s", *q.noise, unit) : std::string("unknown")) +
          format_text("; slices %.3g mm apart\n", q.slice_step);
  text += format_text("  solid from %.0f%s: ", low, unit);
  text +=
      (q.thinnest ? format_text("a fiftieth of it is thinner than %.1f mm; ", *q.thinnest) : std::string()) +
      "walls are felt whole from " + mm(q.least_wall) + ", gaps open from " + mm(q.least_gap) + "\n";
  return text;
}

volume::Status write_quality_chart(const data_tools::ScanQuality& q, const std::string& path) {
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

}  // namespace trephine::app
