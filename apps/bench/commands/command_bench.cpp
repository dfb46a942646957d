// Most commands of trephine-bench: their command lines and tables.
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

/// Drilling by this project and by other methods, compared with the exact volume and surface of the hole.
void bench_drill(const BenchArguments& arguments, Outcome& outcome) {
  Json& rows = outcome.json["rows"] = Json::array();
  for (const bench::DrillingRow& row : bench::run_drilling_benchmark(arguments.is_quick))
    rows.push_back({{"method", row.method},
                    {"burr", row.burr},
                    {"voxels", row.voxels},
                    {"rate_hz", row.rate_hz},
                    {"volume_error", row.volume_error},
                    {"surface_error_mm", row.surface_error_mm},
                    {"tick_us", to_json(row.tick)}});
  outcome.print("a burr of 4 mm moves through solid bone, 8 mm at 20 mm/s unless stated");
  outcome.print_table(rows,
                      "method = {method} | burr = {burr} | voxels = {voxels} | rate, Hz = {rate_hz:.0f} | "
                      "volume = {volume_error:.3%} | surface, mm = {surface_error_mm:.3f} | "
                      "p50, us = {tick_us/p50:.1f} | p99, us = {tick_us/p99:.1f}");
  const bench::DrillingServoLoad servo = bench::run_servo_during_drilling(arguments.is_quick ? 3 : 10);
  Json hands = Json::array();
  for (const auto& [name, report] :
       {std::pair("touching", servo.touching), std::pair("drilling", servo.drilling)}) {
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
    hands.push_back(outcome.json["servo"][name]);
    hands.back()["hand"] = name;
  }
  outcome.print("servo at 1 kHz, pressed on bone, live ({removed:.1f} mm3 drilled)",
                {{"removed", servo.removed_mm3}});
  outcome.print_table(hands,
                      "hand = {hand} | p50, us = {step_us/p50:.2f} | p99, us = {step_us/p99:.2f} | "
                      "p99.9, us = {step_us/p999:.2f} | max, us = {step_us/max:.1f} | "
                      "late p99 = {late_us/p99:.1f} | late max = {late_us/max:.1f}");
}

/// Times of connected components and of a flood fill; both include the thresholding of the voxels.
void bench_flood(int size, Outcome& outcome) {
  Json& rows = outcome.json["rows"] = Json::array();
  Json table = Json::array();
  for (const bench::FloodRow& row : bench::run_flood_benchmark(size)) {
    Json one = {{"volume", row.volume},     {"touch", row.has_corners ? 26 : 6},
                {"threads", row.threads},   {"parts", row.count},
                {"flooded", row.flooded},   {"components_ms", row.components_ms},
                {"flood_ms", row.flood_ms}, {"is_same", row.is_same}};
    if (row.itk_flood_ms) one["itk_flood_ms"] = *row.itk_flood_ms;
    if (row.itk_components_ms) one["itk_components_ms"] = *row.itk_components_ms;
    if (row.scipy_ms) one["scipy_ms"] = *row.scipy_ms;
    rows.push_back(one);
    const auto ratio = [](const std::optional<double>& theirs, double ours) {
      return theirs ? Json(*theirs / ours) : Json();
    };
    one["itk_flood_ratio"] = ratio(row.itk_flood_ms, row.flood_ms);
    one["itk_components_ratio"] = ratio(row.itk_components_ms, row.components_ms);
    one["scipy_ratio"] = ratio(row.scipy_ms, row.components_ms);
    table.push_back(std::move(one));
    if (!row.is_same) outcome.exit_code = exit_check_failed;
  }
  outcome.print(
      "components and floods of {size}^3 int16, including the threshold, ms; ratio: time of the other library "
      "divided by ours",
      {{"size", size}});
  outcome.print_table(table,
                      "volume = {volume} | neighbours = {touch} | threads = {threads} | parts = {parts} | "
                      "components = {components_ms:.1f} | flood = {flood_ms:.1f} | "
                      "ITK flood = {itk_flood_ms:.0f} | ratio = {itk_flood_ratio:.0f} | "
                      "ITK components = {itk_components_ms:.0f} | ratio = {itk_components_ratio:.0f} | "
                      "SciPy label = {scipy_ms:.0f} | ratio = {scipy_ratio:.0f} | same = {is_same}");
}

/// X-ray images compared with those of plastimatch.
void bench_xray(int size, bool is_quick, Outcome& outcome) {
  // Largest allowed RMS difference, relative to the largest line integral of the image. Plastimatch treats
  // matter at the border differently.
  const auto max_rmse = [](const bench::XrayRow& row) {
    return row.volume == "solid" ? 0.25 / row.size : 1e-6;
  };
  Json& rows = outcome.json["rows"] = Json::array();
  Json table = Json::array();
  for (const bench::XrayRow& row : bench::run_xray_benchmark(size, 512)) {
    Json one = {{"volume", row.volume},           {"filled", row.filled},
                {"threads", row.threads},         {"preparing_ms", row.preparing_ms},
                {"exact_ms", row.exact_ms},       {"joseph_ms", row.joseph_ms},
                {"joseph_rmse", row.joseph_rmse}, {"judged_rays", row.judged},
                {"worst_error", row.worst_error}};
    if (row.peer_ms) one["plastimatch_ms"] = *row.peer_ms;
    if (row.peer_rmse) one["plastimatch_rmse"] = *row.peer_rmse;
    rows.push_back(one);
    if (row.peer_ms) one["ratio"] = *row.peer_ms / row.exact_ms;
    if (row.judged == 0) one["worst_error"] = nullptr;
    table.push_back(std::move(one));
    if (row.worst_error > 1e-6 || row.peer_rmse.value_or(0) > max_rmse(row))
      outcome.exit_code = exit_check_failed;
  }
  outcome.print(
      "X-rays of {size}^3 int16 in 512^2 pixels, ms per image (mean of 12 views), compared with plastimatch's exact "
      "drr",
      {{"size", size}});
  outcome.print_table(table,
                      "volume = {volume} | filled = {filled:.0%} | threads = {threads} | "
                      "preparing = {preparing_ms:.1f} | exact = {exact_ms:.1f} | Joseph = {joseph_ms:.1f} | "
                      "plastimatch = {plastimatch_ms:.0f} | ratio = {ratio:.1f} | "
                      "its RMSE = {plastimatch_rmse:.1e} | Joseph's RMSE = {joseph_rmse:.1e} | "
                      "worst ray = {worst_error:.1e}");
  table = Json::array();
  for (const bench::XrayServoLoad::Part& part : bench::run_servo_during_xray(is_quick ? 2 : 5).parts) {
    Json one = {{"image", part.name},
                {"image_us", to_json(part.image)},
                {"servo_step_p99_us", part.servo.step_p99_us},
                {"servo_late_p99_us", part.servo.late_p99_us},
                {"overruns", part.servo.overruns}};
    outcome.json["beside_servo"].push_back(one);
    one["rate"] = part.image.p50 > 0 ? 1e6 / part.image.p50 : 0.0;
    table.push_back(std::move(one));
  }
  outcome.print("while a hand drills the built-in spine at 1 kHz; times of images, and of the servo, us");
  outcome.print_table(table,
                      "image = {image} | per s = {rate:.1f} | p50 = {image_us/p50:.0f} | "
                      "p99 = {image_us/p99:.0f} | max = {image_us/max:.0f} | "
                      "servo p99 = {servo_step_p99_us:.1f} | late p99 = {servo_late_p99_us:.1f}");
}

/// Ray casting compared with VTK's volume mappers.
Status bench_render(int size, Outcome& outcome) {
  const auto surface = view::make_offscreen(512, 512);
  if (!surface) return surface.error();
  const auto gl = view::describe_gl();
  outcome.print("{size}^3 int16 ray-cast, 512^2 pixels without shading; OpenGL: {gl}",
                {{"size", size}, {"gl", gl ? gl.value() : "not available"}});
  Json& rows = outcome.json["rows"] = Json::array();
  for (const bench::RenderRow& row : bench::run_render_benchmark(size, surface.value()->window())) {
    if (!row.is_available) {
      outcome.print("{by} is not installed, or could not draw", {{"by", row.renderer}});
      continue;
    }
    rows.push_back({{"by", row.renderer},
                    {"step_mm", row.step},
                    {"threads", row.threads},
                    {"image_ms", row.frame_ms},
                    {"after_a_cut_ms", row.changed_ms},
                    {"opacity_rms", row.error}});
  }
  outcome.print_table(rows,
                      "program = {by} | step, mm = {step_mm:.3f} | threads = {threads} | "
                      "image, ms = {image_ms:.1f} | after a cut, ms = {after_a_cut_ms:.1f} | "
                      "opacity error = {opacity_rms:.4f}");
  return std::nullopt;
}

/// Slices compared with VTK's.
void bench_reslice(int size, Outcome& outcome) {
  Json& rows = outcome.json["rows"] = Json::array();
  std::map<int, std::pair<double, double>> range;  // by threads: best and worst plane
  for (const bench::ResliceRow& row : bench::run_reslice_benchmark(size)) {
    auto [at, is_new] = range.emplace(row.threads, std::pair(row.our_ms, row.our_ms));
    at->second = {std::min(at->second.first, row.our_ms), std::max(at->second.second, row.our_ms)};
    rows.push_back({{"plane", row.plane},
                    {"threads", row.threads},
                    {"ours_ms", row.our_ms},
                    {"vtk_ms", row.peer_ms},
                    {"worst_difference", row.worst_difference}});
    if (row.worst_difference > 1) outcome.exit_code = exit_check_failed;
  }
  outcome.print("linear slices of 1024^2 pixels of {size}^3 int16, ms, compared with vtkImageReslice",
                {{"size", size}});
  outcome.print_table(rows,
                      "plane = {plane} | threads = {threads} | ours = {ours_ms:.2f} | VTK = {vtk_ms:.1f} | "
                      "differ by = {worst_difference}");
  for (const auto& [threads, ends] : range)
    outcome.print("worst plane over best, {threads} threads: {ratio:.2f}",
                  {{"threads", threads}, {"ratio", ends.second / ends.first}});
}

/// Detection of detached pieces after each stroke of a saw.
void bench_separation(Outcome& outcome) {
  Json& rows = outcome.json["rows"] = Json::array();
  for (const bench::SeparationRow& row : bench::run_separation_benchmark()) {
    rows.push_back({{"voxel_mm", row.voxel_mm},
                    {"burr_mm", row.burr_mm},
                    {"samples_a_voxel", row.samples_per_voxel},
                    {"strokes", row.strokes},
                    {"held", row.held},
                    {"detached", row.detached},
                    {"pending", row.pending},
                    {"p50_ms", row.p50_ms},
                    {"p99_ms", row.p99_ms},
                    {"whole_volume_ms", row.complete_ms},
                    {"wrong", row.wrong}});
    if (row.wrong > 0) outcome.exit_code = exit_check_failed;
  }
  outcome.print(
      "detection of pieces that a stroke detaches: a saw around a flap of the built-in head, ms per stroke");
  outcome.print_table(
      rows,
      "voxel = {voxel_mm:.2f} | burr = {burr_mm:.1f} | samples = {samples_a_voxel} | "
      "connected = {held} | detached = {detached} | pending = {pending} | p50 = {p50_ms:.2f} | "
      "p99 = {p99_ms:.2f} | whole volume = {whole_volume_ms:.1f} | wrong = {wrong}");
}

/// Surface nets compared with VTK's flying edges.
void bench_surface(int size, Outcome& outcome) {
  const bench::SurfaceResult r = bench::run_surface_benchmark(size);
  Json& json = outcome.json;
  json["surfaces"] = Json::array();
  for (const bench::SurfaceRow& row : r.rows)
    json["surfaces"].push_back({{"volume", row.volume},
                                {"size", row.size},
                                {"threads", row.threads},
                                {"ms", row.our_ms},
                                {"triangles", row.our_triangles},
                                {"peer", "vtkFlyingEdges3D"},
                                {"peer_ms", row.peer_ms},
                                {"peer_triangles", row.peer_triangles},
                                {"peer_over_own", row.peer_ms / row.our_ms}});
  json["surface_chunk_us"] = to_json(r.surface_chunk);
  json["drilled_chunk_vertices"] = r.drilled_chunk_vertices;
  json["drilled_chunk_us"] = to_json(r.drilled_chunk);
  outcome.print("whole surface of {size}^3 int16, occupancy included, compared with VTK FlyingEdges3D",
                {{"size", size}});
  outcome.print_table(
      json["surfaces"],
      "volume = {volume} | threads = {threads} | ms = {ms:.1f} | peer, ms = {peer_ms:.1f} | "
      "peer / own = {peer_over_own:.2f} | triangles = {triangles} | of the peer = {peer_triangles}");
  outcome.print(
      "32^3 chunk with surface: p50 {surface_chunk_us/p50:.1f} us, p99 {surface_chunk_us/p99:.1f} us; under "
      "a burr (up to {drilled_chunk_vertices} vertices): p50 {drilled_chunk_us/p50:.1f} us, p99 "
      "{drilled_chunk_us/p99:.1f} us");
}

/// Times of a step of contact, of a tick of removal, and of an update of offset fields.
void bench_step(int size, Outcome& outcome) {
  const bench::StepResult r = bench::run_step_benchmark(size);
  const bool has_peer = r.csg_tick.count > 0;
  Json& json = outcome.json;
  json["implicit"] = {{"size", size},
                      {"step_us", to_json(r.implicit)},
                      {"voxels_a_step", r.voxels_per_step},
                      {"peer_over_own", nullptr}};
  json["fixed_density"] = Json::array();
  for (const bench::ScalingRow& row : r.fixed_density)
    json["fixed_density"].push_back({{"size", row.size},
                                     {"step_us", to_json(row.step)},
                                     {"voxels_a_step", row.voxels_per_step},
                                     {"cells_a_step", row.cells_per_step}});
  json["chain_corner_us"] = to_json(r.chain_corner);
  json["removal_tick_us"] = to_json(r.removal_tick);
  json["removal_tick_peer_over_own"] = has_peer ? Json(r.csg_tick.p50 / r.removal_tick.p50) : Json();
  json["csg_tick_us"] = has_peer ? to_json(r.csg_tick) : Json();
  json["csg_tick_with_capsule_us"] = has_peer ? to_json(r.csg_tick_with_capsule) : Json();
  json["removal_tick_over_scratches_us"] = to_json(r.removal_tick_over_scratches);
  json["field_update_ms"] = to_json(r.field_update_ms);
  json["hover_ms"] = to_json(r.hover_ms);
  json["device_read_ns"] = to_json(r.device_read);
  json["device_write_ns"] = to_json(r.device_write);
  json["mapped_read_ns"] = to_json(r.mapped_read);
  json["mapped_write_ns"] = to_json(r.mapped_write);
  outcome.print(
      "step of method implicit, point, {size}^3 sphere, 100 mm/s: p50 {step_us/p50:.2f} us, p99 {step_us/p99:.2f} us, "
      "p99.9 {step_us/p999:.2f} us, {voxels_a_step:.1f} voxels per step",
      json["implicit"]);
  outcome.print("equal voxels, larger volumes:");
  outcome.print_table(json["fixed_density"],
                      "size = {size}^3 | p50, us = {step_us/p50:.2f} | p99.9, us = {step_us/p999:.2f} | "
                      "voxels per step = {voxels_a_step:.3f} | cells per step = {cells_a_step:.3f}");
  outcome.print(
      "chain, 16 balls of 6 mm in a corner of a mesh: p50 {p50:.0f} us, p99 {p99:.0f} us, p99.9 {p999:.0f} us, "
      "max {max:.0f} us",
      json["chain_corner_us"]);
  outcome.print(
      "removal tick, ball of 24 voxels in diameter at 50 mm/s, version published: p50 {p50:.1f} us, p99 {p99:.1f} us, "
      "p99.9 {p999:.1f} us",
      json["removal_tick_us"]);
  if (has_peer)
    outcome.print(
        "  OpenVDB's csgDifference: p50 {csg_tick_us/p50:.0f} us ({removal_tick_peer_over_own:.0f} times "
        "ours), with the swept ball's level set {csg_tick_with_capsule_us/p50:.0f} us ({ratio:.0f})",
        {{"ratio", r.csg_tick_with_capsule.p50 / r.removal_tick.p50}});
  else
    outcome.print("  built without OpenVDB: no ratio");
  outcome.print(
      "  the same in bone with scratches, made by a ball of 2 voxels in diameter: p50 {p50:.1f} us, p99 {p99:.1f} us, p99.9 {p999:.1f} us",
      json["removal_tick_over_scratches_us"]);
  outcome.print(
      "a burr of 4 mm at 10 mm/s, voxels of 0.5 mm: update of the offset field p50 {field_update_ms/p50:.1f} "
      "ms, p99 {field_update_ms/p99:.1f} ms; from a cut until a field contains it (hover) p50 "
      "{hover_ms/p50:.1f} ms, p99 {hover_ms/p99:.1f} ms");
  outcome.print(
      "a device whose driver reports on another thread: read p50 {device_read_ns/p50:.0f} ns, p99 "
      "{device_read_ns/p99:.0f} ns, write p50 {device_write_ns/p50:.0f} ns; with map and pedal: read p50 "
      "{mapped_read_ns/p50:.0f} ns, p99 {mapped_read_ns/p99:.0f} ns, write p50 {mapped_write_ns/p50:.0f} ns");
}

/// Rays through voxels, compared with NanoVDB, and judged.
void bench_rays(int size, Outcome& outcome) {
  Json& rows = outcome.json["rays"] = Json::array();
  for (const bench::RayRow& r : bench::run_ray_benchmark(size)) {
    const bool has_peer = r.peer_ns > 0;
    rows.push_back({{"volume", r.volume},
                    {"rays", r.rays},
                    {"size", r.size},
                    {"count", r.count},
                    {"hits", r.hits},
                    {"one_ns", r.ns_per_ray},
                    {"peer_ns", has_peer ? Json(r.peer_ns) : Json()},
                    {"peer_over_own", has_peer ? Json(r.peer_ns / r.ns_per_ray) : Json()},
                    {"peer_differs", r.peer_differs},
                    {"judged", r.judged},
                    {"mismatches", r.mismatches}});
    if (r.mismatches > 0) outcome.exit_code = exit_check_failed;
  }
  outcome.print_table(
      rows,
      "volume = {volume} | rays = {rays} | ray, ns = {one_ns:.0f} | "
      "NanoVDB, ns = {peer_ns:.0f} | peer / own = {peer_over_own:.2f} | differs = {peer_differs} | "
      "judged = {judged} | wrong = {mismatches}");
  if (bench::peers().nanovdb_version.empty()) outcome.print("built without NanoVDB: no ratio");
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
  outcome.json["peer_over_own"] = nullptr;
  outcome.print(
      "{name}: first possible touch {seconds/open_to_touch:.2f} s after the process began (start "
      "{seconds/start_of_process:.2f}, read {seconds/read:.2f}, occupancy {seconds/bits:.3f})",
      {{"name", source.name}});
  outcome.print(
      "memory held: {memory/held_over_voxels:.3f} times the size of the voxels; resident: {resident:.0f} MB",
      {{"resident", 1e-6 * outcome.json["memory"]["resident_bytes"].get<double>()}});
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
  options.add("--quick", a->is_quick, "Shorter measurements during live drilling: 2 s each instead of 5 s");
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
  options.add("--quick", a->is_quick, "Fewer voxel sizes and rates, and a shorter servo test");
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
  options.add("SESSION", a->source, "A session (default: some minutes of drilling, recorded first)");
  options.add("--minutes", a->minutes, "Length of the recording").type("N").shows_default();
  options.add("-o,--output", a->output, "Keep the recording in this new file").type("SESSION");
  options.add("--scan", a->case_source, "Scan of the session, if the session does not contain it");
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
  options.add("--quick", a->is_quick,
              "Smaller and fewer scenes: one minute, or two if all peers are installed");
  options.add("--only", a->only, "Only built-in scenes whose name contains this, for example sphere")
      .type("TEXT");
  options
      .add(
          "--methods", a->methods,
          "Play scenes only with these methods, for example subvoxel mesh; times over the size of the volume are still measured for all methods")
      .type("NAME");
  options.add("--hand", a->hand, "A recorded hand for one more scene: a session, or a path over SRC")
      .type("FILE");
  options.add("--export", a->export_folder, "Write each scene for other programs: volume, hand, exact result")
      .type("DIR");
  options.add("--results", a->results, "Add another program's results to the chart").type("STEPS.csv");
  return run_of(a, "bench-feel", bench_feel);
}

Run build_stability(Options& options) {
  auto a = std::make_shared<BenchArguments>();
  options.add("SRC", a->source, "A scan, for one more scene");
  options.add("-o,--output", a->output, "Folder for the tables and maps").type("DIR");
  options.add("--steps", a->steps, "Number of random steps in total").shows_default();
  options.add("--only", a->only, "Only methods whose name contains this").type("TEXT");
  return run_of(a, "bench-stability", bench_stability);
}

}  // namespace

const Command k_surface{"surface", "Surface extraction, compared with VTK", "  trephine-bench surface",
                        build_surface};
const Command k_flood{"flood", "Floods and components, compared with ITK and SciPy", "  trephine-bench flood",
                      build_flood};
const Command k_separation{"separation", "Detection of parts that a cut disconnects",
                           "  trephine-bench separation", build_separation};
const Command k_step{
    "step",
    "Times of a step of method implicit, a chain's step, a tick of removal, and an update of offset fields",
    "  trephine-bench step --json", build_step};
const Command k_rays{"rays", "First hits of rays through voxels, compared with NanoVDB",
                     "  trephine-bench rays", build_rays};
const Command k_xray{"xray", "X-ray images, compared with plastimatch", "  trephine-bench xray", build_xray};
const Command k_reslice{"reslice", "Slices, compared with VTK", "  trephine-bench reslice", build_reslice};
const Command k_render{"render", "Direct volume rendering, compared with VTK", "  trephine-bench render",
                       build_render};
const Command k_drill{"drill", "Drilling: error of volume and surface, time of a tick",
                      "  trephine-bench drill --quick", build_drill};
const Command k_load{"load", "Time until an opened scan can be touched", "  trephine-bench load SCANS/HEAD",
                     build_load};
const Command k_dicom{"dicom", "Finding and reading DICOM series, compared with ITK",
                      "  trephine-bench dicom --quick", build_dicom};
const Command k_open{"open", "Opening a long session at random ticks",
                     "  trephine-bench open\n  trephine-bench open drill.session", build_open};
const Command k_depth{"depth", "Contact by depth images", "  trephine-bench depth", build_depth};
const Command k_feel{"feel", "Error and time of contact methods and of other libraries, with charts",
                     "  trephine-bench feel -o out/ --quick", build_feel};
const Command k_stability{
    "stability", "Random motions that try to pass surfaces, largest stable stiffness, and generated energy",
    "  trephine-bench stability SCANS/HEAD --steps 100000000 -o out/", build_stability};

}  // namespace trephine::bench
