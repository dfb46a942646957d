// whole-tool: times of contact with the whole surface of a tool, and experiments of Kadlecek (2013, master
// thesis "Haptic rendering for 6/3-DOF haptic devices").
#include "apps/bench/commands/bench_commands.h"
#include "apps/bench/tool_experiments.h"
#include "apps/bench/whole_tool.h"
#include "apps/view/chart.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::bench {

using namespace cli;

namespace {

struct ToolArguments {
  bool is_quick = false;
  std::string output;  ///< folder of charts; empty: none
  long passes = 2000;
};

/// Writes the charts of forces and the slice of the VoxMap into a folder.
Status draw_charts(const std::vector<IntegratorRow>& integrators, const std::vector<SlidingForceRow>& slides,
                   const std::string& folder) {
  if (Status error = data_tools::make_folder(folder)) return error;
  view::Chart noise;
  noise.title = "Force in free motion, by integrator";
  noise.x_label = "time, s", noise.y_label = "N: mean of 20 steps (solid), mean + deviation (dashed)";
  std::size_t number = 0;
  for (const IntegratorRow& row : integrators) {
    view::ChartSeries mean{row.name, {}, row.means, true, view::chart_color(number++)};
    constexpr double k_block = 0.02, k_shown = 2;  // s
    for (std::size_t i = 0; i < row.means.size() && k_block * static_cast<double>(i) < k_shown; ++i)
      mean.x.push_back(k_block * static_cast<double>(i));
    mean.y.resize(mean.x.size());
    view::ChartSeries noisy = mean;
    noisy.name.clear();
    noisy.y.assign(row.noisy.begin(), row.noisy.begin() + static_cast<std::ptrdiff_t>(mean.x.size()));
    noisy.is_dashed = true, noisy.width = 1;
    noise.series.push_back(std::move(mean));
    noise.series.push_back(std::move(noisy));
  }
  if (Status error = view::write_chart_files(noise, folder + "/integrators")) return error;
  view::Chart slide;
  slide.title = "Force on a rod that slides over an oblique plane";
  slide.x_label = "mm", slide.y_label = "N";
  number = 0;
  for (const SlidingForceRow& row : slides) {
    view::ChartSeries force{row.method, {}, row.force, true, view::chart_color(number++)};
    for (std::size_t i = 0; i < row.force.size(); ++i)
      force.x.push_back(k_slide_step * static_cast<double>(i));
    slide.series.push_back(std::move(force));
  }
  if (Status error = view::write_chart_files(slide, folder + "/force-jumps")) return error;
  return data_tools::write_file_atomically(folder + "/voxmap.svg", draw_voxmap_slice());
}

Status run_tool(const ToolArguments& arguments, Outcome& outcome) {
  const WholeToolResult result = run_whole_tool_benchmark(arguments.is_quick);
  outcome.print(
      format_text("a burr of 4 mm with a shaft of 60 mm, on the head phantom of %d x %d x %d voxels",
                  result.size[0], result.size[1], result.size[2]));
  outcome.json["rows"] = Json::array();
  for (const WholeToolRow& row : result.rows) {
    outcome.json["rows"].push_back({{"spacing_mm", row.spacing},
                                    {"points", row.points},
                                    {"make_ms", row.make_ms},
                                    {"free_us", to_json(row.free_us)},
                                    {"slide_us", to_json(row.slide_us)},
                                    {"hole_us", to_json(row.hole_us)},
                                    {"sampling_us", to_json(row.sampling_us)},
                                    {"sampling_tested", row.tested},
                                    {"layer_us", to_json(row.layer_us)},
                                    {"fcl_us", to_json(row.fcl_us)}});
    outcome.print(format_text(
        "%6zu points (%.2f mm), made in %.0f ms. Step of shell, us, p50 / p99 / p99.9: free %.1f / %.1f / "
        "%.1f, sliding %.0f / %.0f / %.0f, levered in a hole %.0f / %.0f / %.0f",
        row.points, row.spacing, row.make_ms, row.free_us.p50, row.free_us.p99, row.free_us.p999,
        row.slide_us.p50, row.slide_us.p99, row.slide_us.p999, row.hole_us.p50, row.hole_us.p99,
        row.hole_us.p999));
    outcome.print(format_text(
        "       published voxel sampling (sum of the points' forces), us: %.1f / %.1f / %.1f; it tests points and nodes "
        "of its tree, %.0f %% of the number of points",
        row.sampling_us.p50, row.sampling_us.p99, row.sampling_us.p999, 100 * row.tested));
    outcome.print(format_text("       pressure in a layer (LayerContact), us: %.1f / %.1f / %.1f",
                              row.layer_us.p50, row.layer_us.p99, row.layer_us.p999));
    if (row.fcl_us.count > 0)
      outcome.print(format_text("       FCL, one collision query, us: %.0f / %.0f / %.0f", row.fcl_us.p50,
                                row.fcl_us.p99, row.fcl_us.p999));
  }
  for (const DenseToolRow& row : run_dense_tool_benchmark(arguments.is_quick)) {
    outcome.json["dense"].push_back({{"place", row.place},
                                     {"size", {row.size[0], row.size[1], row.size[2]}},
                                     {"points", row.points},
                                     {"near", row.near},
                                     {"sampling_us", to_json(row.sampling_us)},
                                     {"layer_us", to_json(row.layer_us)}});
    outcome.print(format_text(
        "%6zu points, %s (%d x %d x %d voxels), %.0f %% of them near matter, us: published voxel sampling %.0f / %.0f / "
        "%.0f, pressure in a layer %.0f / %.0f / %.0f",
        row.points, row.place.c_str(), row.size[0], row.size[1], row.size[2], 100 * row.near,
        row.sampling_us.p50, row.sampling_us.p99, row.sampling_us.p999, row.layer_us.p50, row.layer_us.p99,
        row.layer_us.p999));
  }
  ProgressLine progress("passes against a plate");
  bool is_stopped = false;
  const auto passes =
      run_plate_passes(arguments.passes, [&](double share) { return !(is_stopped = !progress(share)); });
  if (is_stopped) return interrupted("the passes");
  for (const PassRow& row : passes) {
    outcome.json["passes"].push_back(
        {{"method", row.method}, {"passes", row.passes}, {"through", row.through}});
    outcome.print(
        format_text("1 m/s and 10 rad/s against a plate of one voxel, %s: %ld of %ld passes go through",
                    row.method.c_str(), row.through, row.passes));
  }
  if (passes.empty() || passes.front().through > 0) outcome.exit_code = exit_check_failed;
  outcome.json["voxmap"] = {
      {"seconds", result.voxmap_seconds},
      {"mb", result.voxmap_mb},
      {"lookup_ns", result.voxmap_ns},
      {"openvdb_mb", result.openvdb_mb < 0 ? Json(nullptr) : Json(result.openvdb_mb)},
      {"openvdb_lookup_ns", result.openvdb_ns < 0 ? Json(nullptr) : Json(result.openvdb_ns)},
      {"are_lookups_equal", result.are_lookups_equal}};
  outcome.print(
      format_text("VoxMap: made in %.1f s, %.1f MB, %.1f ns per look-up at the points of a sliding tool",
                  result.voxmap_seconds, result.voxmap_mb, result.voxmap_ns));
  if (result.openvdb_ns >= 0)
    outcome.print(format_text("OpenVDB's tree of the same voxels: %.1f MB, %.1f ns per look-up, %s",
                              result.openvdb_mb, result.openvdb_ns,
                              result.are_lookups_equal ? "equal results" : "DIFFERENT RESULTS"));
  if (!result.are_lookups_equal) outcome.exit_code = exit_check_failed;
  const std::vector<IntegratorRow> integrators = compare_integrators();
  const std::vector<SlidingForceRow> slides = compare_sliding_forces();
  for (const SlidingForceRow& row : slides) {
    outcome.json["slides"].push_back({{"method", row.method}, {"largest_jump", row.jump}});
    outcome.print(format_text("force on a rod that slides over a plane, %s: jumps by %.4f %% per step",
                              row.method.c_str(), 100 * row.jump));
  }
  if (!arguments.output.empty())
    if (Status error = draw_charts(integrators, slides, arguments.output)) return error;
  for (const IntegratorRow& row : integrators) {
    outcome.json["integrators"][row.name] = {{"mean_n", row.mean}, {"noise_n", row.noise}};
    outcome.print(format_text("force in free motion, %s integration: mean %.4f N, noise %.4f N",
                              row.name.c_str(), row.mean, row.noise));
  }
  for (const LeverRow& row : run_lever_task()) {
    outcome.json["lever"].push_back(
        {{"is_limited", row.is_limited}, {"points_through", row.points}, {"turned_degrees", row.turned}});
    outcome.print(
        format_text("lever between two plates, %s: %d points pass through, the tool turns by %.1f degrees",
                    row.is_limited ? "coupling limited" : "coupling not limited", row.points, row.turned));
  }
  return std::nullopt;
}

Run build_tool(Options& options) {
  auto a = std::make_shared<ToolArguments>();
  options.add("--quick", a->is_quick, "A coarser phantom and fewer steps");
  options.add("-o,--output", a->output, "Write charts of the forces and a slice of the VoxMap")
      .type("FOLDER");
  options.add("--passes", a->passes, "Passes of a rod against a plate of one voxel (default 2000)").type("N");
  return [a]() -> Result<Outcome> {
    if (a->passes < 1 || a->passes > 100'000'000)
      return Error{.what = "the number of passes is out of range",
                   .where = "--passes",
                   .found = std::to_string(a->passes),
                   .expected = "1 to 100000000"};
    Outcome outcome("bench-whole-tool");
    if (Status error = run_tool(*a, outcome)) return *error;
    return outcome;
  };
}

}  // namespace

const Command k_whole_tool{"whole-tool", "Whole tools with six degrees of freedom, compared with FCL",
                           "  trephine-bench whole-tool --quick", build_tool};

}  // namespace trephine::bench
