// pedicle: times of screws and of the probe, and the probe's force over depth.
#include <algorithm>
#include <cmath>

#include "apps/bench/commands/bench_commands.h"
#include "apps/bench/pedicle.h"
#include "apps/view/chart.h"

namespace trephine::bench {

using namespace cli;

namespace {

struct PedicleArguments {
  bool is_quick = false;
  std::string output;
};

constexpr double k_interval_mm = 0.5;  // of depth over which the force of a trace is averaged
// Means are compared where the track grows.
constexpr double k_compared_from_mm = 1, k_compared_to_mm = k_trace_plate_mm - 1;
constexpr double k_shown_mm = k_trace_plate_mm + 4;

void report_times(bool is_quick, Outcome& outcome) {
  const PedicleResult r = run_pedicle_benchmark(is_quick);
  outcome.json["scan"] = {{"width", r.width}, {"slices", r.slices}};
  outcome.json["place_ms"] = r.place_ms;
  outcome.json["judge_ms"] = r.judge_ms;
  outcome.json["overlays_ms"] = to_json(r.overlays_ms);
  outcome.json["probe_us"] = to_json(r.probe_us);
  outcome.print(
      "screws in L4 of the spine phantom, {scan/width}^2 x {scan/slices}, ms: placing {place_ms:.1f}, judging "
      "{judge_ms:.1f}");
  outcome.print("overlays while a screw turns in, ms: p50 {p50:.4f}, p99 {p99:.4f}, max {max:.4f}",
                outcome.json["overlays_ms"]);
  outcome.print("servo step of a probe whose track grows, us: p50 {p50:.2f}, p99 {p99:.2f}, p99.9 {p999:.2f}",
                outcome.json["probe_us"]);
}

/// Compares the forces of both guides, and draws them over depth if a path is given.
Status report_forces(const std::string& path, data_tools::OutputSet& outputs, Outcome& outcome) {
  struct Side {
    const char* name;
    pedicle::Guide guide;
    std::size_t color;
    InsertionTrace trace;
    std::vector<double> means;
  } sides[] = {{"guide=line", pedicle::Guide::line, 0, {}, {}},
               {"guide=walls", pedicle::Guide::walls, 1, {}, {}}};
  view::Chart chart{"Pedicle probe pushed through 16 mm of bone at 2 mm/s",
                    "depth of the tip (mm)",
                    "force (N)",
                    false,
                    false,
                    {}};
  for (Side& side : sides) {
    side.trace = trace_insertion(side.guide);
    if (side.trace.force_n.empty())
      return Error{.what = "the scene of the probe could not be prepared",
                   .remedy = "report this error; it does not depend on the options"};
    side.means = side.trace.means(k_interval_mm, k_shown_mm);
    view::ChartSeries ticks{"", {}, {}, true, view::chart_color(side.color), 1};
    for (std::size_t i = 0; i < side.trace.depth_mm.size(); ++i) {
      if (side.trace.depth_mm[i] < 0 || side.trace.depth_mm[i] > k_shown_mm) continue;
      ticks.x.push_back(side.trace.depth_mm[i]), ticks.y.push_back(side.trace.force_n[i]);
    }
    chart.series.push_back(std::move(ticks));
  }
  double largest = 0;
  for (const Side& side : sides) {
    // The first line is wider, and visible beneath the other.
    view::ChartSeries line{std::string(side.name) + ", mean", {}, {}, true, view::chart_color(side.color),
                           side.color == 0 ? 6.0f : 2.5f};
    for (std::size_t i = 0; i < side.means.size(); ++i) {
      const double depth = (static_cast<double>(i) + 0.5) * k_interval_mm;
      if (depth < k_compared_from_mm || depth > k_compared_to_mm) continue;
      line.x.push_back(depth), line.y.push_back(side.means[i]);
      largest = std::max(largest, std::abs(side.means[i] / sides[0].means[i] - 1));
    }
    outcome.json["force_over_depth"][side.name] = {{"depth_mm", line.x}, {"mean_n", line.y}};
    chart.series.push_back(std::move(line));
  }
  outcome.json["force_over_depth"]["largest_difference_percent"] = 100 * largest;
  outcome.print(
      "force over depth: the mean forces of guide=walls and guide=line, in intervals of 0.5 mm, differ by at most "
      "{largest_difference_percent:.1f} %",
      outcome.json["force_over_depth"]);
  if (!path.empty()) outputs.write(path, [&] { return view::write_chart(chart, path); });
  return std::nullopt;
}

Run build_pedicle(Options& options) {
  auto a = std::make_shared<PedicleArguments>();
  options.add("--quick", a->is_quick, "A scan with half the columns, rows and slices");
  options.add("-o,--output", a->output, "Chart of the probe's force over depth").type("PNG|SVG|CSV");
  return [a]() -> Result<Outcome> {
    data_tools::OutputSet outputs;
    outputs.add_output("--output", a->output, data_tools::OutputKind::chart);
    if (Status error = outputs.check()) return *error;
    Outcome outcome("bench-pedicle");
    report_times(a->is_quick, outcome);
    if (Status error = report_forces(a->output, outputs, outcome)) return *error;
    return finished(outputs, std::move(outcome));
  };
}

}  // namespace

const Command k_pedicle{"pedicle", "Pedicle screws and the probe: times, and the probe's force over depth",
                        "  trephine-bench pedicle --quick -o force.png", build_pedicle};

}  // namespace trephine::bench
