// bench.
#include <algorithm>
#include <map>

#include "apps/trephine/bench_parts.h"
#include "apps/view/render_window.h"
#include "data-tools/open_volume.h"
#include "haptics/proxy/subvoxel_proxy.h"
#include "tests/bench/benchmarks.h"
#include "tests/bench/drilling.h"
#include "tests/bench/flood.h"
#include "tests/bench/parting.h"
#include "tests/bench/peers.h"
#include "tests/bench/rays.h"
#include "tests/bench/render.h"
#include "tests/bench/reslice.h"
#include "tests/bench/xray.h"

namespace trephine::app {

using volume::Error;
using volume::Result;

namespace {

constexpr const char* k_benchmarks =
    "surface, flood, parting, step, rays, xray, reslice, render, drill, load, dicom, open, depth, feel or "
    "stability";

Json to_json(const bench::StepTimes& t) {
  return {{"count", t.count}, {"p50", t.p50}, {"p99", t.p99}, {"p999", t.p999}, {"max", t.max}};
}

/// Ours and the ways of others, against the closed form.
void bench_drill(const BenchArguments& arguments, Outcome& outcome) {
  Json rows = Json::array();
  outcome.text = "a burr of 4 mm goes through solid bone, 8 mm at 20 mm/s where nothing else is said\n" +
                 format_text("%-30s %-10s %-22s %8s %10s %11s %10s %10s\n", "way", "burr", "voxels",
                             "rate, Hz", "volume, %", "surface, mm", "p50, us", "p99, us");
  for (const bench::DrillingRow& row : bench::run_drilling_benchmark(arguments.is_quick)) {
    rows.push_back({{"way", row.way},
                    {"burr", row.burr},
                    {"voxels", row.voxels},
                    {"rate_hz", row.rate_hz},
                    {"volume_error", row.volume_error},
                    {"surface_error_mm", row.surface_error_mm},
                    {"tick_us", to_json(row.tick)}});
    outcome.text += format_text("%-30s %-10s %-22s %8.0f %10.3f %11.3f %10.1f %10.1f\n", row.way.c_str(),
                                row.burr.c_str(), row.voxels.c_str(), row.rate_hz, 100 * row.volume_error,
                                row.surface_error_mm, row.tick.p50, row.tick.p99);
  }
  outcome.json["rows"] = rows;
  const bench::ServoBesideDrilling servo = bench::run_servo_beside_drilling(arguments.is_quick ? 3 : 10);
  outcome.text += format_text(
      "servo at 1 kHz, pressed on bone, live (%.1f mm3 were drilled)\n%-10s %9s %9s %10s %9s %10s %10s\n",
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

/// Bits, components and a flood of them, from the voxels on.
void bench_flood(int size, Outcome& outcome) {
  outcome.text += format_text(
      "floods and components of %d^3 int16, threshold included, ms, compared with ITK and SciPy\n"
      "%-8s %5s %7s %9s %11s %7s %16s %18s %15s %5s\n",
      size, "volume", "touch", "threads", "parts", "components", "flood", "ITK flood", "ITK components",
      "SciPy label", "same");
  Json rows = Json::array();
  for (const bench::FloodRow& row : bench::run_flood_benchmark(size)) {
    const auto beside = [](const std::optional<double>& theirs, double ours) {
      return theirs ? format_text("%.0f (%.0fx)", *theirs, *theirs / ours) : std::string("-");
    };
    outcome.text += format_text("%-8s %5d %7d %9lld %11.1f %7.1f %16s %18s %15s %5s\n", row.volume.c_str(),
                                row.has_corners ? 26 : 6, row.threads, row.count, row.components_ms,
                                row.flood_ms, beside(row.itk_flood_ms, row.flood_ms).c_str(),
                                beside(row.itk_components_ms, row.components_ms).c_str(),
                                beside(row.scipy_ms, row.components_ms).c_str(), row.is_same ? "yes" : "NO");
    Json one = {{"volume", row.volume},
                {"touch", row.has_corners ? 26 : 6},
                {"threads", row.threads},
                {"parts", row.count},
                {"flooded", row.flooded},

                {"components_ms", row.components_ms},
                {"flood_ms", row.flood_ms},
                {"is_same", row.is_same}};
    if (row.itk_flood_ms) one["itk_flood_ms"] = *row.itk_flood_ms;
    if (row.itk_components_ms) one["itk_components_ms"] = *row.itk_components_ms;
    if (row.scipy_ms) one["scipy_ms"] = *row.scipy_ms;
    rows.push_back(std::move(one));
    if (!row.is_same) outcome.exit_code = exit_check_failed;
  }
  outcome.json["rows"] = rows;
}

/// Projections compared with plastimatch.
void bench_xray(int size, bool is_quick, Outcome& outcome) {
  // Relative to the largest sum. Where matter reaches the border plastimatch counts otherwise.
  const auto most_rmse = [](const bench::XrayRow& row) {
    return row.volume == "solid" ? 0.25 / row.size : 1e-6;
  };
  outcome.text += format_text(
      "X-rays of %d^3 int16 in 512^2 pixels, ms an image of 12 around, compared with plastimatch's exact "
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
    if (row.worst_error > 1e-6 || row.peer_rmse.value_or(0) > most_rmse(row))
      outcome.exit_code = exit_check_failed;
  }
  outcome.json["rows"] = rows;
  outcome.text +=
      format_text("while a hand drills the built-in spine at 1 kHz\n%-15s %7s %9s %9s %9s %14s %14s\n",
                  "image", "a s", "p50, ms", "p99, ms", "max, ms", "servo p99, us", "late p99, us");
  for (const bench::XrayBesideServo::Part& part : bench::run_xray_beside_servo(is_quick ? 2 : 5).parts) {
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

/// Ray casting compared with VTK's mappers.
volume::Status bench_render(int size, Outcome& outcome) {
  const auto surface = view::make_offscreen(512, 512);
  if (!surface) return surface.error();
  const auto gl = view::describe_gl();
  outcome.text += format_text(
      "%d^3 int16 drawn directly, 512^2 pixels without light; OpenGL by %s\n%-16s %8s %8s %10s %15s %14s\n",
      size, gl ? gl.value().c_str() : "nothing", "by", "step mm", "threads", "image ms", "after a cut ms",
      "opacity within");
  Json rows = Json::array();
  for (const bench::RenderRow& row : bench::run_render_benchmark(size, surface.value()->window())) {
    if (!row.is_there) {
      outcome.text += format_text("%-16s is not installed, or could not draw\n", row.who.c_str());
      continue;
    }
    outcome.text += format_text("%-16s %8.3f %8d %10.1f %15.1f %14.4f\n", row.who.c_str(), row.step,
                                row.threads, row.frame_ms, row.changed_ms, row.error);
    rows.push_back({{"by", row.who},
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

/// After each stroke of a saw: did it free a piece?
void bench_parting(Outcome& outcome) {
  outcome.text += format_text(
      "did this stroke free a piece? A saw around a flap of the built-in head, ms\n%6s %5s %8s %5s %6s %7s "
      "%6s %6s %12s %5s\n",
      "voxel", "burr", "samples", "held", "parted", "pending", "p50", "p99", "whole volume", "wrong");
  Json rows = Json::array();
  for (const bench::PartingRow& row : bench::run_parting_benchmark()) {
    outcome.text += format_text("%6.2f %5.1f %8d %5d %6d %7d %6.2f %6.2f %12.1f %5d\n", row.voxel_mm,
                                row.burr_mm, row.samples_a_voxel, row.held, row.parted, row.pending,
                                row.p50_ms, row.p99_ms, row.whole_ms, row.wrong);
    rows.push_back({{"voxel_mm", row.voxel_mm},
                    {"burr_mm", row.burr_mm},
                    {"samples_a_voxel", row.samples_a_voxel},
                    {"strokes", row.strokes},
                    {"held", row.held},
                    {"parted", row.parted},
                    {"pending", row.pending},
                    {"p50_ms", row.p50_ms},
                    {"p99_ms", row.p99_ms},
                    {"whole_volume_ms", row.whole_ms},
                    {"wrong", row.wrong}});
    if (row.wrong > 0) outcome.exit_code = exit_check_failed;
  }
  outcome.json["rows"] = rows;
}

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

void bench_step(int size, Outcome& outcome) {
  const bench::StepResult r = bench::run_step_benchmark(size);
  outcome.json["implicit"] = {{"size", size},
                              {"step_us", to_json(r.implicit)},
                              {"voxels_a_step", r.voxels_a_step},
                              {"ratio_to_peer", nullptr}};
  outcome.text += format_text(
      "implicit step, point, %d^3 sphere, 100 mm/s: p50 %.2f us, p99 %.2f us, p99.9 %.2f us, %.1f voxels a "
      "step\n",
      size, r.implicit.p50, r.implicit.p99, r.implicit.p999, r.voxels_a_step);
  Json rows = Json::array();
  outcome.text += "the same voxels, larger volumes:\n";
  for (const bench::ScalingRow& row : r.fixed_density) {
    rows.push_back({{"size", row.size},
                    {"step_us", to_json(row.step)},
                    {"voxels_a_step", row.voxels_a_step},
                    {"cells_a_step", row.cells_a_step}});
    outcome.text += format_text("  %3d^3: p50 %.2f us, p99.9 %.2f us, %.3f voxels and %.3f cells a step\n",
                                row.size, row.step.p50, row.step.p999, row.voxels_a_step, row.cells_a_step);
  }
  outcome.json["fixed_density"] = rows;
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
    outcome.text += "  OpenVDB was not there when this was built: no ratio\n";
  outcome.json["removal_tick_over_scratches_us"] = to_json(r.removal_tick_over_scratches);
  outcome.text +=
      format_text("  over scratches of a ball of one voxel: p50 %.1f us, p99 %.1f us, p99.9 %.1f us\n",
                  r.removal_tick_over_scratches.p50, r.removal_tick_over_scratches.p99,
                  r.removal_tick_over_scratches.p999);
  outcome.json["field_update_ms"] = to_json(r.field_update_ms);
  outcome.json["hover_ms"] = to_json(r.hover_ms);
  outcome.text += format_text(
      "a round tip of 2 mm behind its burr, voxels of 0.5 mm: a field's update p50 %.1f ms, p99 %.1f ms; it "
      "hovers p50 %.1f ms, p99 %.1f ms\n",
      r.field_update_ms.p50, r.field_update_ms.p99, r.hover_ms.p50, r.hover_ms.p99);
}

void bench_rays(int size, Outcome& outcome) {
  Json rows = Json::array();
  outcome.text += format_text("%-8s %-7s %10s %10s %8s %10s %8s %8s\n", "volume", "rays", "a ray, ns",
                              "NanoVDB ns", "ratio", "it differs", "judged", "wrong");
  for (const bench::RayRow& r : bench::run_ray_benchmark(size)) {
    const bool has_peer = r.peer_ns > 0;
    rows.push_back({{"volume", r.volume},
                    {"rays", r.rays},
                    {"size", r.size},
                    {"count", r.count},
                    {"hits", r.hits},
                    {"one_ns", r.one_ns},
                    {"peer_ns", has_peer ? Json(r.peer_ns) : Json()},
                    {"ratio_to_peer", has_peer ? Json(r.peer_ns / r.one_ns) : Json()},
                    {"peer_differs", r.peer_differs},
                    {"judged", r.judged},
                    {"mismatches", r.mismatches}});
    outcome.text += format_text("%-8s %-7s %10.0f ", r.volume.c_str(), r.rays.c_str(), r.one_ns);
    outcome.text += has_peer
                        ? format_text("%10.0f %8.2f %10ld", r.peer_ns, r.peer_ns / r.one_ns, r.peer_differs)
                        : format_text("%10s %8s %10s", "-", "-", "-");
    outcome.text += format_text(" %8ld %8ld\n", r.judged, r.mismatches);
    if (r.mismatches > 0) outcome.exit_code = exit_check_failed;
  }
  if (bench::peers().nanovdb_version.empty())
    outcome.text += "NanoVDB was not there when this was built: no ratio\n";
  outcome.json["rays"] = rows;
}

volume::Status bench_load(const std::string& src, Outcome& outcome) {
  auto opened = workbench::open_touch(src, {}, person());
  if (!opened) return opened.error();
  const workbench::Source& source = opened.value().source;
  const haptics::TouchScene& scene = opened.value().scene;
  const double bits = opened.value().making_seconds;
  const double start = std::max(0.0, process_seconds() - bits - source.read_seconds);
  haptics::SubvoxelProxy method;
  if (volume::Status error = method.prepare(scene)) return error;
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
  outcome.text += format_text("held %.3f times the voxels' bytes; resident %.0f MB\n",
                              outcome.json["memory"]["held_over_voxels"].get<double>(),
                              static_cast<double>(resident_bytes()) / 1e6);
  return std::nullopt;
}

Result<Outcome> run_bench(const BenchArguments& arguments) {
  if (arguments.size < 64 || arguments.size > 800)
    return Error{"the size is out of range", "--size", std::to_string(arguments.size), "64 to 800 voxels",
                 ""};
  if (!arguments.hand.empty() && arguments.what != "feel")
    return Error{"this benchmark plays no hand", "--hand", arguments.what, "feel", ""};
  Outcome outcome{new_report("bench-" + arguments.what), "", exit_done};
  if (arguments.what == "surface")
    bench_surface(arguments.size, outcome);
  else if (arguments.what == "xray")
    bench_xray(arguments.size, arguments.is_quick, outcome);
  else if (arguments.what == "reslice")
    bench_reslice(arguments.size, outcome);
  else if (arguments.what == "render") {
    if (volume::Status error = bench_render(arguments.size, outcome)) return *error;
  } else if (arguments.what == "flood")
    bench_flood(arguments.size, outcome);
  else if (arguments.what == "parting")
    bench_parting(outcome);
  else if (arguments.what == "step")
    bench_step(arguments.size, outcome);
  else if (arguments.what == "rays")
    bench_rays(arguments.size, outcome);
  else if (arguments.what == "load") {
    if (volume::Status error = bench_load(arguments.source.empty() ? "head" : arguments.source, outcome))
      return *error;
  } else if (arguments.what == "feel") {
    if (volume::Status error = bench_feel(arguments, outcome)) return *error;
  } else if (arguments.what == "stability") {
    if (volume::Status error = bench_stability(arguments, outcome)) return *error;
  } else if (arguments.what == "dicom") {
    if (volume::Status error = bench_dicom(arguments, outcome)) return *error;
  } else if (arguments.what == "depth") {
    if (volume::Status error = bench_depth(arguments, outcome)) return *error;
  } else if (arguments.what == "drill") {
    bench_drill(arguments, outcome);
  } else if (arguments.what == "open") {
    if (volume::Status error = bench_open(arguments, outcome)) return *error;
  } else {
    return Error{"there is no such benchmark", "", arguments.what, k_benchmarks, ""};
  }
  return outcome;
}

Run build(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  options.add("WHAT", a->what, k_benchmarks).required();
  options.add("SRC", a->source,
              "A scan: for load; one more scene for feel and stability; a folder for dicom. A session: for "
              "open (none: ten minutes of drilling, recorded first). A polygonal model, or a folder of them: "
              "for depth, touched in addition to the built-in ones");
  options.add("--case", a->case_source, "The scan of that session, where the session needs it");
  options.add("--size", a->size, "Voxels along each axis (surface, step and rays)").shows_default();
  options.add("-o,--output", a->output, "Folder for the tables and charts of feel and stability").type("DIR");
  options.add("--steps", a->steps, "Random steps of stability, in all").shows_default();
  options.add(
      "--quick", a->is_quick,
      "Feel with smaller and fewer scenes: a minute, or two with every peer; dicom with a small disk; drill "
      "with fewer voxels and rates");
  options
      .add("--only", a->only,
           "Built-in scenes of feel whose name holds this, for example sphere; also methods of stability")
      .type("TEXT");
  options.add("--hand", a->hand, "A recorded hand for one more scene of feel: a session, or a path over SRC")
      .type("FILE");
  options
      .add("--export", a->export_folder, "Write each scene of feel for other programs: volume, hand, answer")
      .type("DIR");
  options.add("--score", a->score, "Put another program's answers to them on the chart").type("STEPS.csv");
  return run_with(a, run_bench);
}

}  // namespace

const Command k_bench{"bench", "Measure, together with peers in the same run",
                      "  trephine bench surface\n  trephine bench step --json\n  trephine bench drill\n  "
                      "trephine bench load SCANS/HEAD\n"
                      "  trephine bench depth\n"
                      "  trephine bench dicom\n  trephine bench open\n  trephine bench open drill.session\n"
                      "  trephine bench feel -o out/ --quick\n"
                      "  trephine bench stability SCANS/HEAD --steps 100000000 -o out/",
                      build};

}  // namespace trephine::app
