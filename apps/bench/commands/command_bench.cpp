// Commands of trephine-bench: the command line of each benchmark, and the tables of most of them.
// One file: the commands share the printing of their tables.
#include <algorithm>
#include <map>

#include "apps/bench/benchmarks.h"
#include "apps/bench/commands/bench_commands.h"
#include "apps/bench/drilling.h"
#include "apps/bench/flood.h"
#include "apps/bench/peers.h"
#include "apps/bench/rays.h"
#include "apps/bench/render.h"
#include "apps/bench/reslice.h"
#include "apps/bench/separation.h"
#include "apps/bench/xray.h"
#include "apps/view/render_window.h"
#include "data-tools/formats/open_volume.h"
#include "haptics/proxy/subvoxel_proxy.h"

namespace trephine::bench {

using namespace cli;

namespace {

Json to_json(const bench::StepTimes& t) {
  return {{"count", t.count}, {"p50", t.p50}, {"p99", t.p99}, {"p999", t.p999}, {"max", t.max}};
}

/// Drilling by this project and by other methods, compared with the exact volume and surface of the hole.
void bench_drill(const BenchArguments& arguments, Outcome& outcome) {
  Json rows = Json::array();
  outcome.text = "a burr of 4 mm moves through solid bone, 8 mm at 20 mm/s unless stated\n" +
                 format_text("%-30s %-10s %-22s %8s %10s %11s %10s %10s\n", "method", "burr", "voxels",
                             "rate, Hz", "volume, %", "surface, mm", "p50, us", "p99, us");
  for (const bench::DrillingRow& row : bench::run_drilling_benchmark(arguments.is_quick)) {
    rows.push_back({{"method", row.method},
                    {"burr", row.burr},
                    {"voxels", row.voxels},
                    {"rate_hz", row.rate_hz},
                    {"volume_error", row.volume_error},
                    {"surface_error_mm", row.surface_error_mm},
                    {"tick_us", to_json(row.tick)}});
    outcome.text += format_text("%-30s %-10s %-22s %8.0f %10.3f %11.3f %10.1f %10.1f\n", row.method.c_str(),
                                row.burr.c_str(), row.voxels.c_str(), row.rate_hz, 100 * row.volume_error,
                                row.surface_error_mm, row.tick.p50, row.tick.p99);
  }
  outcome.json["rows"] = rows;
  const bench::DrillingServoLoad servo = bench::run_servo_beside_drilling(arguments.is_quick ? 3 : 10);
  outcome.text += format_text(
      "servo at 1 kHz, pressed on bone, live (%.1f mm3 drilled)\n%-10s %9s %9s %10s %9s %10s %10s\n",
      servo.removed_mm3, "hand", "p50, us", "p99, us", "p99.9, us", "max, us", "late p99", "late max");
  for (const auto& [name, report] :
       {std::pair("touching", servo.touching), std::pair("drilling", servo.drilling)}) {
    outcome.text += format_text("%-10s %9.2f %9.2f %10.2f %9.1f %10.1f %10.1f\n", name, report.step_p50_us,
                                report.step_p99_us, report.step_p999_us, report.step_max_us,
                                report.late_p99_us, report.late_max_us);
    outcome.json["servo"][name] = {{"ticks", report.ticks},
                                   {"overruns", report.overruns},
                                   {"dropped", report.dropped},
                                   {"step_us",
                                    {{"p50", report.step_p50_us},
                                     {"p99", report.step_p99_us},
                                     {"p999", report.step_p999_us},
                                     {"max", report.step_max_us}}},
                                   {"late_us",
                                    {{"p50", report.late_p50_us},
                                     {"p99", report.late_p99_us},
                                     {"p999", report.late_p999_us},
                                     {"max", report.late_max_us}}}};
  }
}

/// Times of occupancy bits, connected components and a flood fill, each from the voxels on.
void bench_flood(int size, Outcome& outcome) {
  outcome.text += format_text(
      "floods and components of %d^3 int16, threshold included, ms, compared with ITK and SciPy\n"
      "%-8s %10s %7s %9s %11s %7s %16s %18s %15s %5s\n",
      size, "volume", "neighbours", "threads", "parts", "components", "flood", "ITK flood", "ITK components",
      "SciPy label", "same");
  Json rows = Json::array();
  for (const bench::FloodRow& row : bench::run_flood_benchmark(size)) {
    const auto with_ratio = [](const std::optional<double>& theirs, double ours) {
      return theirs ? format_text("%.0f (%.0fx)", *theirs, *theirs / ours) : std::string("-");
    };
    outcome.text +=
        format_text("%-8s %10d %7d %9lld %11.1f %7.1f %16s %18s %15s %5s\n", row.volume.c_str(),
                    row.has_corners ? 26 : 6, row.threads, row.count, row.components_ms, row.flood_ms,
                    with_ratio(row.itk_flood_ms, row.flood_ms).c_str(),
                    with_ratio(row.itk_components_ms, row.components_ms).c_str(),
                    with_ratio(row.scipy_ms, row.components_ms).c_str(), row.is_same ? "yes" : "NO");
    Json one = {{"volume", row.volume},     {"touch", row.has_corners ? 26 : 6},
                {"threads", row.threads},   {"parts", row.count},
                {"flooded", row.flooded},   {"components_ms", row.components_ms},
                {"flood_ms", row.flood_ms}, {"is_same", row.is_same}};
    if (row.itk_flood_ms) one["itk_flood_ms"] = *row.itk_flood_ms;
    if (row.itk_components_ms) one["itk_components_ms"] = *row.itk_components_ms;
    if (row.scipy_ms) one["scipy_ms"] = *row.scipy_ms;
    rows.push_back(std::move(one));
    if (!row.is_same) outcome.exit_code = exit_check_failed;
  }
  outcome.json["rows"] = rows;
}

/// X-ray images compared with those of plastimatch.
void bench_xray(int size, bool is_quick, Outcome& outcome) {
  // Largest allowed difference, relative to the largest sum. Plastimatch treats matter at the border
  // differently.
  const auto max_rmse = [](const bench::XrayRow& row) {
    return row.volume == "solid" ? 0.25 / row.size : 1e-6;
  };
  outcome.text += format_text(
      "X-rays of %d^3 int16 in 512^2 pixels, ms per image of 12 views, compared with plastimatch's exact "
      "drr\n"
      "%-7s %7s %7s %10s %9s %9s %18s %11s %12s %10s\n",
      size, "volume", "filled", "threads", "preparing", "exact", "Joseph", "plastimatch", "its RMSE",
      "Joseph's RMSE", "worst ray");
  Json rows = Json::array();
  for (const bench::XrayRow& row : bench::run_xray_benchmark(size, 512)) {
    outcome.text += format_text(
        "%-7s %6.0f%% %7d %10.1f %9.1f %9.1f %18s %11s %12.1e %10s\n", row.volume.c_str(), 100 * row.filled,
        row.threads, row.preparing_ms, row.exact_ms, row.joseph_ms,
        row.peer_ms ? format_text("%.0f (%.1fx)", *row.peer_ms, *row.peer_ms / row.exact_ms).c_str() : "-",
        row.peer_rmse ? format_text("%.1e", *row.peer_rmse).c_str() : "-", row.joseph_rmse,
        row.judged > 0 ? format_text("%.1e", row.worst_error).c_str() : "-");
    Json one = {{"volume", row.volume},           {"filled", row.filled},
                {"threads", row.threads},         {"preparing_ms", row.preparing_ms},
                {"exact_ms", row.exact_ms},       {"joseph_ms", row.joseph_ms},
                {"joseph_rmse", row.joseph_rmse}, {"judged_rays", row.judged},
                {"worst_error", row.worst_error}};
    if (row.peer_ms) one["plastimatch_ms"] = *row.peer_ms;
    if (row.peer_rmse) one["plastimatch_rmse"] = *row.peer_rmse;
    rows.push_back(std::move(one));
    if (row.worst_error > 1e-6 || row.peer_rmse.value_or(0) > max_rmse(row))
      outcome.exit_code = exit_check_failed;
  }
  outcome.json["rows"] = rows;
  outcome.text +=
      format_text("while a hand drills the built-in spine at 1 kHz\n%-15s %7s %9s %9s %9s %14s %14s\n",
                  "image", "per s", "p50, ms", "p99, ms", "max, ms", "servo p99, us", "late p99, us");
  for (const bench::XrayServoLoad::Part& part : bench::run_xray_beside_servo(is_quick ? 2 : 5).parts) {
    outcome.text += format_text("%-15s %7.1f %9.1f %9.1f %9.1f %14.1f %14.1f\n", part.name.c_str(),
                                part.image.p50 > 0 ? 1e6 / part.image.p50 : 0.0, 1e-3 * part.image.p50,
                                1e-3 * part.image.p99, 1e-3 * part.image.max, part.servo.step_p99_us,
                                part.servo.late_p99_us);
    outcome.json["beside_servo"].push_back({{"image", part.name},
                                            {"image_us", to_json(part.image)},
                                            {"servo_step_p99_us", part.servo.step_p99_us},
                                            {"servo_late_p99_us", part.servo.late_p99_us},
                                            {"overruns", part.servo.overruns}});
  }
}

/// Ray casting compared with VTK's volume mappers.
Status bench_render(int size, Outcome& outcome) {
  const auto surface = view::make_offscreen(512, 512);
  if (!surface) return surface.error();
  const auto gl = view::describe_gl();
  outcome.text += format_text(
      "%d^3 int16 ray-cast, 512^2 pixels without shading; OpenGL: %s\n%-16s %8s %8s %10s %15s %14s\n", size,
      gl ? gl.value().c_str() : "not available", "program", "step mm", "threads", "image ms",
      "after a cut ms", "opacity error");
  Json rows = Json::array();
  for (const bench::RenderRow& row : bench::run_render_benchmark(size, surface.value()->window())) {
    if (!row.is_there) {
      outcome.text += format_text("%-16s is not installed, or could not draw\n", row.renderer.c_str());
      continue;
    }
    outcome.text += format_text("%-16s %8.3f %8d %10.1f %15.1f %14.4f\n", row.renderer.c_str(), row.step,
                                row.threads, row.frame_ms, row.changed_ms, row.error);
    rows.push_back({{"by", row.renderer},
                    {"step_mm", row.step},
                    {"threads", row.threads},
                    {"image_ms", row.frame_ms},
                    {"after_a_cut_ms", row.changed_ms},
                    {"opacity_rms", row.error}});
  }
  outcome.json["rows"] = rows;
  return std::nullopt;
}

/// Slices compared with VTK's.
void bench_reslice(int size, Outcome& outcome) {
  outcome.text += format_text(
      "linear slices of 1024^2 pixels of %d^3 int16, ms, compared with vtkImageReslice\n%-16s %7s %8s %16s "
      "%11s\n",
      size, "plane", "threads", "ours", "VTK", "differ by");
  Json rows = Json::array();
  std::map<int, std::pair<double, double>> range;  // by threads: best and worst plane
  for (const bench::ResliceRow& row : bench::run_reslice_benchmark(size)) {
    auto [at, is_new] = range.emplace(row.threads, std::pair(row.our_ms, row.our_ms));
    at->second = {std::min(at->second.first, row.our_ms), std::max(at->second.second, row.our_ms)};
    outcome.text += format_text("%-16s %7d %8.2f %16s %11d\n", row.plane.c_str(), row.threads, row.our_ms,
                                format_text("%.1f (%.1fx)", row.peer_ms, row.peer_ms / row.our_ms).c_str(),
                                row.worst_difference);
    rows.push_back({{"plane", row.plane},
                    {"threads", row.threads},
                    {"ours_ms", row.our_ms},
                    {"vtk_ms", row.peer_ms},
                    {"worst_difference", row.worst_difference}});
    if (row.worst_difference > 1) outcome.exit_code = exit_check_failed;
  }
  for (const auto& [threads, ends] : range)
    outcome.text +=
        format_text("worst plane over best, %d threads: %.2f\n", threads, ends.second / ends.first);
  outcome.json["rows"] = rows;
}

/// Detection of detached pieces after each stroke of a saw.
void bench_separation(Outcome& outcome) {
  outcome.text += format_text(
      "detection of pieces that a stroke detaches: a saw around a flap of the built-in head, ms per stroke\n"
      "%6s %5s %8s %5s %6s %7s %6s %6s %12s %5s\n",
      "voxel", "burr", "samples", "held", "parted", "pending", "p50", "p99", "whole volume", "wrong");
  Json rows = Json::array();
  for (const bench::SeparationRow& row : bench::run_separation_benchmark()) {
    outcome.text += format_text("%6.2f %5.1f %8d %5d %6d %7d %6.2f %6.2f %12.1f %5d\n", row.voxel_mm,
                                row.burr_mm, row.samples_a_voxel, row.held, row.parted, row.pending,
                                row.p50_ms, row.p99_ms, row.complete_ms, row.wrong);
    rows.push_back({{"voxel_mm", row.voxel_mm},
                    {"burr_mm", row.burr_mm},
                    {"samples_a_voxel", row.samples_a_voxel},
                    {"strokes", row.strokes},
                    {"held", row.held},
                    {"parted", row.parted},
                    {"pending", row.pending},
                    {"p50_ms", row.p50_ms},
                    {"p99_ms", row.p99_ms},
                    {"whole_volume_ms", row.complete_ms},
                    {"wrong", row.wrong}});
    if (row.wrong > 0) outcome.exit_code = exit_check_failed;
  }
  outcome.json["rows"] = rows;
}

/// Surface nets compared with VTK's flying edges.
void bench_surface(int size, Outcome& outcome) {
  const bench::SurfaceResult r = bench::run_surface_benchmark(size);
  Json rows = Json::array();
  outcome.text +=
      format_text("whole surface of %d^3 int16, bits included, compared with VTK FlyingEdges3D\n", size);
  for (const bench::SurfaceRow& row : r.rows) {
    const double ratio = row.peer_ms / row.our_ms;
    rows.push_back({{"volume", row.volume},
                    {"size", row.size},
                    {"threads", row.threads},
                    {"ms", row.our_ms},
                    {"triangles", row.our_triangles},
                    {"peer", "vtkFlyingEdges3D"},
                    {"peer_ms", row.peer_ms},
                    {"peer_triangles", row.peer_triangles},
                    {"ratio_to_peer", ratio}});
    outcome.text +=
        format_text("  %-7s %d thread%s  %7.1f ms   peer %7.1f ms   %.2fx   (%zu and %zu triangles)\n",
                    row.volume.c_str(), row.threads, row.threads > 1 ? "s" : " ", row.our_ms, row.peer_ms,
                    ratio, row.our_triangles, row.peer_triangles);
  }
  outcome.text += format_text(
      "32^3 chunk with surface: p50 %.1f us, p99 %.1f us; under a burr (up to %zu vertices): p50 %.1f us, "
      "p99 %.1f us\n",
      r.surface_chunk.p50, r.surface_chunk.p99, r.drilled_chunk_vertices, r.drilled_chunk.p50,
      r.drilled_chunk.p99);
  outcome.json["surfaces"] = rows;
  outcome.json["surface_chunk_us"] = to_json(r.surface_chunk);
  outcome.json["drilled_chunk_vertices"] = r.drilled_chunk_vertices;
  outcome.json["drilled_chunk_us"] = to_json(r.drilled_chunk);
}

/// Times of a step of contact, of a tick of removal, and of an update of offset fields.
void bench_step(int size, Outcome& outcome) {
  const bench::StepResult r = bench::run_step_benchmark(size);
  outcome.json["implicit"] = {{"size", size},
                              {"step_us", to_json(r.implicit)},
                              {"voxels_a_step", r.voxels_per_step},
                              {"ratio_to_peer", nullptr}};
  outcome.text += format_text(
      "implicit step, point, %d^3 sphere, 100 mm/s: p50 %.2f us, p99 %.2f us, p99.9 %.2f us, %.1f voxels per "
      "step\n",
      size, r.implicit.p50, r.implicit.p99, r.implicit.p999, r.voxels_per_step);
  Json rows = Json::array();
  outcome.text += "equal voxels, larger volumes:\n";
  for (const bench::ScalingRow& row : r.fixed_density) {
    rows.push_back({{"size", row.size},
                    {"step_us", to_json(row.step)},
                    {"voxels_a_step", row.voxels_per_step},
                    {"cells_a_step", row.cells_per_step}});
    outcome.text +=
        format_text("  %3d^3: p50 %.2f us, p99.9 %.2f us, %.3f voxels and %.3f cells per step\n", row.size,
                    row.step.p50, row.step.p999, row.voxels_per_step, row.cells_per_step);
  }
  outcome.json["fixed_density"] = rows;
  outcome.json["chain_corner_us"] = to_json(r.chain_corner);
  outcome.text += format_text(
      "chain, 16 balls of 3 mm in a corner of a mesh: p50 %.0f us, p99 %.0f us, p99.9 %.0f us, max %.0f us\n",
      r.chain_corner.p50, r.chain_corner.p99, r.chain_corner.p999, r.chain_corner.max);
  outcome.json["removal_tick_us"] = to_json(r.removal_tick);
  outcome.json["removal_tick_ratio_to_peer"] =
      r.csg_tick.count > 0 ? Json(r.csg_tick.p50 / r.removal_tick.p50) : Json();
  outcome.text += format_text(
      "removal tick, ball of 12 voxels at 50 mm/s, version published: p50 %.1f us, p99 %.1f us, p99.9 %.1f "
      "us\n",
      r.removal_tick.p50, r.removal_tick.p99, r.removal_tick.p999);
  outcome.json["csg_tick_us"] = r.csg_tick.count > 0 ? to_json(r.csg_tick) : Json();
  outcome.json["csg_tick_with_capsule_us"] = r.csg_tick.count > 0 ? to_json(r.csg_tick_with_capsule) : Json();
  if (r.csg_tick.count > 0)
    outcome.text += format_text(
        "  OpenVDB's csgDifference: p50 %.0f us (%.0f times ours), with the swept ball's level set %.0f us "
        "(%.0f)\n",
        r.csg_tick.p50, r.csg_tick.p50 / r.removal_tick.p50, r.csg_tick_with_capsule.p50,
        r.csg_tick_with_capsule.p50 / r.removal_tick.p50);
  else
    outcome.text += "  built without OpenVDB: no ratio\n";
  outcome.json["removal_tick_over_scratches_us"] = to_json(r.removal_tick_over_scratches);
  outcome.text +=
      format_text("  over scratches of a ball of one voxel: p50 %.1f us, p99 %.1f us, p99.9 %.1f us\n",
                  r.removal_tick_over_scratches.p50, r.removal_tick_over_scratches.p99,
                  r.removal_tick_over_scratches.p999);
  outcome.json["field_update_ms"] = to_json(r.field_update_ms);
  outcome.json["hover_ms"] = to_json(r.hover_ms);
  outcome.text += format_text(
      "a round tip of 2 mm behind its burr, voxels of 0.5 mm: field update p50 %.1f ms, p99 %.1f ms; "
      "hover p50 %.1f ms, p99 %.1f ms\n",
      r.field_update_ms.p50, r.field_update_ms.p99, r.hover_ms.p50, r.hover_ms.p99);
}

/// Rays through voxels, compared with NanoVDB, and judged.
void bench_rays(int size, Outcome& outcome) {
  Json rows = Json::array();
  outcome.text += format_text("%-8s %-7s %10s %10s %8s %10s %8s %8s\n", "volume", "rays", "ray, ns",
                              "NanoVDB ns", "ratio", "differs", "judged", "wrong");
  for (const bench::RayRow& r : bench::run_ray_benchmark(size)) {
    const bool has_peer = r.peer_ns > 0;
    rows.push_back({{"volume", r.volume},
                    {"rays", r.rays},
                    {"size", r.size},
                    {"count", r.count},
                    {"hits", r.hits},
                    {"one_ns", r.ns_per_ray},
                    {"peer_ns", has_peer ? Json(r.peer_ns) : Json()},
                    {"ratio_to_peer", has_peer ? Json(r.peer_ns / r.ns_per_ray) : Json()},
                    {"peer_differs", r.peer_differs},
                    {"judged", r.judged},
                    {"mismatches", r.mismatches}});
    outcome.text += format_text("%-8s %-7s %10.0f ", r.volume.c_str(), r.rays.c_str(), r.ns_per_ray);
    outcome.text +=
        has_peer ? format_text("%10.0f %8.2f %10ld", r.peer_ns, r.peer_ns / r.ns_per_ray, r.peer_differs)
                 : format_text("%10s %8s %10s", "-", "-", "-");
    outcome.text += format_text(" %8ld %8ld\n", r.judged, r.mismatches);
    if (r.mismatches > 0) outcome.exit_code = exit_check_failed;
  }
  if (bench::peers().nanovdb_version.empty()) outcome.text += "built without NanoVDB: no ratio\n";
  outcome.json["rays"] = rows;
}

/// Time from the start of the process until a scan can be touched.
Status bench_load(const std::string& src, Outcome& outcome) {
  auto opened = workbench::open_touch(src, {}, terminal_listener());
  if (!opened) return opened.error();
  const workbench::Source& source = opened.value().source;
  const haptics::TouchScene& scene = opened.value().scene;
  const double bits = opened.value().build_seconds;
  const double start = std::max(0.0, process_seconds() - bits - source.read_seconds);
  haptics::SubvoxelProxy method;
  if (Status error = method.prepare(scene)) return error;
  const volume::Version version(source.volume);
  haptics::ProxyState state;
  method.step(scene, version, state, {source.volume->frame.origin()});
  const double touch = process_seconds();
  outcome.json["source"] = name_in_report(source);
  outcome.json["voxels"] = source.volume->voxels.size();
  outcome.json["seconds"] = {
      {"start_of_process", start}, {"read", source.read_seconds}, {"bits", bits}, {"open_to_touch", touch}};
  outcome.json["memory"] = memory_report(scene, version);
  outcome.json["ratio_to_peer"] = nullptr;
  outcome.text += format_text(
      "%s: first possible touch %.2f s after the process began (start %.2f, read %.2f, bits %.3f)\n",
      source.name.c_str(), touch, start, source.read_seconds, bits);
  outcome.text += format_text("memory held: %.3f times the size of the voxels; resident: %.0f MB\n",
                              outcome.json["memory"]["held_over_voxels"].get<double>(),
                              static_cast<double>(resident_bytes()) / 1e6);
  return std::nullopt;
}

/// Returns the function of a command. `schema`: of its report; `bench` adds text and rows to the outcome.
template <class Bench>
Run run_of(std::shared_ptr<BenchArguments> a, const char* schema, const Bench& bench) {
  return [a, schema, bench]() -> Result<Outcome> {
    if (a->size < 64 || a->size > 800)
      return Error{.what = "the size is out of range",
                   .where = "--size",
                   .found = std::to_string(a->size),
                   .expected = "64 to 800 voxels"};
    Outcome outcome(schema);
    if (Status error = bench(*a, outcome)) return *error;
    return outcome;
  };
}

/// Returns the function of a benchmark on volumes of --size.
template <class Bench>
Run build_sized(Options& options, const char* schema, const Bench& bench) {
  auto a = std::make_shared<BenchArguments>();
  options.add("--size", a->size, "Voxels along each axis").shows_default();
  return run_of(a, schema, [bench](const BenchArguments& arguments, Outcome& outcome) -> Status {
    bench(arguments.size, outcome);
    return std::nullopt;
  });
}

Run build_surface(Options& options) { return build_sized(options, "bench-surface", bench_surface); }
Run build_flood(Options& options) { return build_sized(options, "bench-flood", bench_flood); }
Run build_step(Options& options) { return build_sized(options, "bench-step", bench_step); }
Run build_rays(Options& options) { return build_sized(options, "bench-rays", bench_rays); }
Run build_reslice(Options& options) { return build_sized(options, "bench-reslice", bench_reslice); }

Run build_render(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  options.add("--size", a->size, "Voxels along each axis").shows_default();
  return run_of(a, "bench-render",
                [](const BenchArguments& one, Outcome& outcome) { return bench_render(one.size, outcome); });
}

Run build_xray(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  options.add("--size", a->size, "Voxels along each axis").shows_default();
  options.add("--quick", a->is_quick, "Fewer rays are judged");
  return run_of(a, "bench-xray", [](const BenchArguments& one, Outcome& outcome) -> Status {
    bench_xray(one.size, one.is_quick, outcome);
    return std::nullopt;
  });
}

Run build_separation(Options&) {
  return run_of(std::make_shared<BenchArguments>(), "bench-separation",
                [](const BenchArguments&, Outcome& outcome) -> Status {
                  bench_separation(outcome);
                  return std::nullopt;
                });
}

Run build_drill(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  options.add("--quick", a->is_quick, "Fewer voxels and rates");
  return run_of(a, "bench-drill", [](const BenchArguments& one, Outcome& outcome) -> Status {
    bench_drill(one, outcome);
    return std::nullopt;
  });
}

Run build_load(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  a->source = "head";
  options.add("SRC", a->source, "A scan").shows_default();
  return run_of(a, "bench-load",
                [](const BenchArguments& one, Outcome& outcome) { return bench_load(one.source, outcome); });
}

Run build_dicom(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  options.add("SRC", a->source, "A folder of series (default: a disk that the benchmark writes)");
  options.add("--quick", a->is_quick, "A small disk");
  return run_of(a, "bench-dicom", bench_dicom);
}

Run build_open(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  options.add("SESSION", a->source, "A session (default: ten minutes of drilling, recorded first)");
  options.add("--scan", a->case_source, "The scan of the session, where the session needs it");
  return run_of(a, "bench-open", bench_open);
}

Run build_depth(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  options.add("SRC", a->source, "A polygonal model, or a folder of them, in addition to the built-in ones");
  options.add("--quick", a->is_quick, "Smaller and fewer scenes");
  return run_of(a, "bench-depth", bench_depth);
}

Run build_feel(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  options.add("SRC", a->source, "A scan, for one more scene");
  options.add("-o,--output", a->output, "Folder for the tables and charts").type("DIR");
  options.add("--quick", a->is_quick, "Smaller and fewer scenes: a minute, or two with every peer");
  options.add("--only", a->only, "Built-in scenes whose name contains this, for example sphere").type("TEXT");
  options.add("--hand", a->hand, "A recorded hand for one more scene: a session, or a path over SRC")
      .type("FILE");
  options.add("--export", a->export_folder, "Write each scene for other programs: volume, hand, answer")
      .type("DIR");
  options.add("--score", a->score, "Add another program's answers to the chart").type("STEPS.csv");
  return run_of(a, "bench-feel", bench_feel);
}

Run build_stability(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  options.add("SRC", a->source, "A scan, for one more scene");
  options.add("-o,--output", a->output, "Folder for the tables and maps").type("DIR");
  options.add("--steps", a->steps, "Random steps, in all").shows_default();
  options.add("--only", a->only, "Methods whose name contains this").type("TEXT");
  return run_of(a, "bench-stability", bench_stability);
}

}  // namespace

const Command k_surface{"surface", "Surface extraction, compared with VTK", "  trephine-bench surface",
                        build_surface};
const Command k_flood{"flood", "Floods and components, compared with ITK and SciPy", "  trephine-bench flood",
                      build_flood};
const Command k_separation{"separation", "Detection of parts that a cut disconnects",
                           "  trephine-bench separation", build_separation};
const Command k_step{"step", "Time of a step of each contact method", "  trephine-bench step --json",
                     build_step};
const Command k_rays{"rays", "Rays through voxels, compared with Embree and NanoVDB", "  trephine-bench rays",
                     build_rays};
const Command k_xray{"xray", "X-ray images, compared with plastimatch", "  trephine-bench xray", build_xray};
const Command k_reslice{"reslice", "Slices, compared with VTK", "  trephine-bench reslice", build_reslice};
const Command k_render{"render", "Direct volume rendering, compared with VTK", "  trephine-bench render",
                       build_render};
const Command k_drill{"drill", "Drilling: error of volume and surface, time of a tick",
                      "  trephine-bench drill --quick", build_drill};
const Command k_load{"load", "Opening a scan until it can be touched", "  trephine-bench load SCANS/HEAD",
                     build_load};
const Command k_dicom{"dicom", "Finding and reading DICOM series, compared with ITK",
                      "  trephine-bench dicom --quick", build_dicom};
const Command k_open{"open", "Opening a long session at random ticks",
                     "  trephine-bench open\n  trephine-bench open drill.session", build_open};
const Command k_depth{"depth", "Contact by depth images", "  trephine-bench depth", build_depth};
const Command k_feel{"feel", "Error and time of contact methods and of other libraries, with charts",
                     "  trephine-bench feel -o out/ --quick", build_feel};
const Command k_stability{"stability", "Random attacks, stability maps and energy",
                          "  trephine-bench stability SCANS/HEAD --steps 100000000 -o out/", build_stability};

}  // namespace trephine::bench
