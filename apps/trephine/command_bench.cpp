// bench.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <spawn.h>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>

#include "apps/trephine/commands.h"
#include "apps/trephine/feel_report.h"
#include "apps/trephine/text.h"
#include "apps/view/chart.h"
#include "data-tools/atomic_file.h"
#include "data-tools/open_volume.h"
#include "data-tools/operated_volume.h"
#include "haptics/methods.h"
#include "haptics/subvoxel_proxy.h"
#include "tests/bench/attack.h"
#include "tests/bench/benchmarks.h"
#include "tests/bench/peers.h"
#include "tests/bench/rays.h"
#include "tests/bench/scorer.h"
#include "tests/bench/stability.h"

namespace trephine::app {

using volume::Error;
using volume::Result;

namespace {

Json to_json(const bench::StepTimes& t) {
  return {{"count", t.count}, {"p50", t.p50}, {"p99", t.p99}, {"p999", t.p999}, {"max", t.max}};
}

void bench_surface(int size, Outcome& outcome) {
  const bench::SurfaceResult r = bench::run_surface_benchmark(size);
  Json rows = Json::array();
  outcome.text += format_text("whole surface of %d^3 int16, bits included, beside VTK FlyingEdges3D\n", size);
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
    outcome.text += format_text("%-8s %-7s %10.0f %10.0f %8.2f %10ld %8ld %8ld\n", r.volume.c_str(),
                                r.rays.c_str(), r.one_ns, r.peer_ns, has_peer ? r.peer_ns / r.one_ns : 0,
                                r.peer_differs, r.judged, r.mismatches);
    if (r.mismatches > 0) outcome.exit_code = exit_check_failed;
  }
  if (bench::peers().nanovdb_version.empty())
    outcome.text += "NanoVDB was not there when this was built: no ratio\n";
  outcome.json["rays"] = rows;
}

volume::Status bench_load(const std::string& src, Outcome& outcome) {
  auto opened = open_source(src);
  if (!opened) return opened.error();
  Source& source = opened.value();
  const double after_read = process_seconds();
  auto scene = make_scene(source, {});
  if (!scene) return scene.error();
  haptics::SubvoxelProxy method;
  if (volume::Status error = method.prepare(scene.value())) return error;
  const volume::Version version(source.volume);
  haptics::ProxyState state;
  method.step(scene.value(), version, state, {source.volume->frame.origin()});
  const double touch = process_seconds();
  outcome.json["source"] = source.name;
  outcome.json["voxels"] = source.volume->voxels.size();
  outcome.json["seconds"] = {{"start_of_process", std::max(0.0, after_read - source.read_seconds)},
                             {"read", source.read_seconds},
                             {"bits", source.bits_seconds},
                             {"open_to_touch", touch}};
  outcome.json["memory"] = memory_report(scene.value(), version);
  outcome.json["ratio_to_peer"] = nullptr;
  outcome.text += format_text(
      "%s: first possible touch %.2f s after the process began (start %.2f, read %.2f, bits %.3f)\n",
      source.name.c_str(), touch, std::max(0.0, after_read - source.read_seconds), source.read_seconds,
      source.bits_seconds);
  outcome.text += format_text("held %.3f times the voxels' bytes; resident %.0f MB\n",
                              outcome.json["memory"]["held_over_voxels"].get<double>(),
                              static_cast<double>(resident_bytes()) / 1e6);
  return std::nullopt;
}

/// One scene as plain files: volume.mha as it is touched (drilled, say), scene.json, hip.csv and, where the
/// exact answer is known, ideal.csv.
volume::Status export_scene(const std::string& folder, const bench::FeelScene& scene) {
  const std::filesystem::path place = std::filesystem::path(folder) / bench::feel_id(scene);
  std::error_code failed;
  std::filesystem::create_directories(place, failed);
  if (failed)
    return Error{"the folder cannot be made", data_tools::file_name(folder), failed.message(),
                 "a place that may be written", "choose another with --export"};
  std::optional<volume::Volume> drilled;
  if (scene.drilled) {
    auto operated = data_tools::operated_volume(*scene.drilled->version);
    if (!operated) return operated.error();
    drilled = std::move(operated).value();
  }
  if (volume::Status error =
          data_tools::write_volume((place / "volume.mha").string(), drilled ? *drilled : *scene.scene.base))
    return error;
  const volume::Shape& shape = scene.scene.shapes[0].field.shape();
  const Json says{{"id", bench::feel_id(scene)},
                  {"radius_mm", scene.radius_mm},
                  {"solid_from", shape.low},
                  {"stiffness_n_mm", scene.scene.shapes[0].material.stiffness},
                  {"rate_hz", 1000}};
  if (volume::Status error =
          data_tools::write_file_atomically((place / "scene.json").string(), says.dump(2) + "\n"))
    return error;
  std::ostringstream hip, ideal;
  scene.path.write_csv(hip);
  if (volume::Status error = data_tools::write_file_atomically((place / "hip.csv").string(), hip.str()))
    return error;
  if (!scene.distance) return std::nullopt;
  const bench::Ideal exact(scene);
  ideal << "t,proxy_x,proxy_y,proxy_z\n";
  for (std::size_t i = 0; i < exact.on_shape().proxies.size(); ++i) {
    const glm::dvec3& p = exact.on_shape().proxies[i];
    ideal << format_text("%.17g,%.17g,%.17g,%.17g\n", scene.path.samples()[i].t, p.x, p.y, p.z);
  }
  return data_tools::write_file_atomically((place / "ideal.csv").string(), ideal.str());
}

/// scene,proxy_x,proxy_y,proxy_z[,us]: a row a step, in the order of hip.csv.
Result<bench::FeelAnswers> read_answers(const std::string& path) {
  std::ifstream in(path);
  const std::string where = data_tools::file_name(path);
  if (!in)
    return Error{"the answers cannot be read", where, "", "a file of scene,proxy_x,proxy_y,proxy_z[,us]", ""};
  bench::FeelAnswers answers;
  answers.program = std::filesystem::path(path).stem().string();
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (number == 1 && line.rfind("scene,", 0) == 0) continue;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    const std::size_t comma = line.find(',');
    double x = 0, y = 0, z = 0, us = 0;
    int used = 0, used_with_us = 0;
    const char* rest = comma == std::string::npos ? "" : line.c_str() + comma;
    const int read = std::sscanf(rest, ",%lf,%lf,%lf%n,%lf%n", &x, &y, &z, &used, &us, &used_with_us);
    const int all = static_cast<int>(std::strlen(rest));
    if (!(read == 3 && used == all) && !(read == 4 && used_with_us == all))
      return Error{"the answers have a line that is none", where + ", line " + std::to_string(number), line,
                   "scene,proxy_x,proxy_y,proxy_z[,us]", "one line a step of hip.csv, numbers in mm"};
    if (!std::isfinite(x + y + z + us))
      return Error{"the answers have a number that is none", where + ", line " + std::to_string(number), line,
                   "finite numbers", ""};
    const std::string scene = line.substr(0, comma);
    answers.proxies_world[scene].emplace_back(x, y, z);
    if (read == 4) answers.us[scene].push_back(us);
  }
  for (const auto& [scene, us] : answers.us)
    if (us.size() != answers.proxies_world[scene].size())
      return Error{"the answers name times for some steps only", where, scene,
                   "us in every row of a scene, or in none", ""};
  if (answers.proxies_world.empty())
    return Error{"the answers are empty", where, "", "scene,proxy_x,proxy_y,proxy_z[,us]", ""};
  return answers;
}

/// An archive's files in a folder of their own, gone afterwards.
class Unpacked {
 public:
  Unpacked() = default;
  Unpacked(const Unpacked&) = delete;
  Unpacked& operator=(const Unpacked&) = delete;
  ~Unpacked() {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
  }
  /// False when there is no such archive, or the system's tar cannot read it.
  bool unpack(const std::filesystem::path& archive) {
    std::error_code failed;
    if (!std::filesystem::exists(archive, failed)) return false;
    std::string name = (std::filesystem::temp_directory_path(failed) / "trephine-XXXXXX").string();
    if (failed || ::mkdtemp(name.data()) == nullptr) return false;
    folder_ = name;
    std::string from = archive.string(), tar = "tar", extract = "-xJf", into = "-C";
    char* const words[] = {tar.data(), extract.data(), from.data(), into.data(), folder_.data(), nullptr};
    pid_t child = 0;
    int status = 1;
    return ::posix_spawnp(&child, "tar", nullptr, nullptr, words, environ) == 0 &&
           ::waitpid(child, &status, 0) == child && status == 0;
  }
  const std::string& folder() const noexcept { return folder_; }

 private:
  std::string folder_;
};

bench::FeelScene real_scene(const std::string& name, const std::string& motion, haptics::TouchScene scene,
                            haptics::PosePath path) {
  for (haptics::TouchShape& shape : scene.shapes)
    shape.material.static_friction = shape.material.dynamic_friction = 0;
  bench::FeelScene real;
  real.name = name, real.variant = "as scanned", real.motion = motion, real.group = "real";
  real.radius_mm = scene.tool_radius;
  real.scene = std::move(scene);
  real.path = std::move(path);
  return real;
}

/// A path a thousand times a second, as the chart plays it.
Result<haptics::PosePath> at_a_kilohertz(const haptics::PosePath& path, const std::string& where) {
  constexpr std::size_t k_most = 20'000;
  std::vector<haptics::PosePath::Sample> samples;
  for (const double t : haptics::servo_times(path, 1000))
    if (samples.size() < k_most) samples.push_back({t, path.at(t)});
  return haptics::PosePath::from_samples(std::move(samples), where);
}

/// Where a session's first hand was; poses that were no place are left out.
Result<haptics::PosePath> hand_of(sim::SessionReader& session, const std::string& where) {
  constexpr double k_most_seconds = 20;
  std::vector<haptics::PosePath::Sample> samples;
  sim::LogItem item;
  for (;;) {
    const Result<bool> read = session.next(item);
    if (!read) return read.error();
    if (!read.value()) break;
    const auto* tick = std::get_if<sim::TickItem>(&item);
    if (tick == nullptr || tick->record.hand != 0 || (tick->record.raised & haptics::fault_not_finite))
      continue;
    samples.push_back({static_cast<double>(tick->record.tick) / session.header().rate_hz, tick->record.pose});
    if (samples.back().t - samples.front().t > k_most_seconds) break;
  }
  return haptics::PosePath::from_samples(std::move(samples), where);
}

/// What a hand did, over the scan that it did it to: a session, or a path over `source`.
Result<bench::FeelScene> recorded_hand(const std::string& file, const std::string& source) {
  const std::string where = data_tools::file_name(file);
  const auto play = [&](const std::string& name, haptics::TouchScene& scene,
                        const Result<haptics::PosePath>& path) -> Result<bench::FeelScene> {
    if (!path) return path.error();
    auto played = at_a_kilohertz(path.value(), where);
    if (!played) return played.error();
    return real_scene(name, "recorded hand", std::move(scene), std::move(played).value());
  };
  if (is_session_file(file)) {
    auto opened = open_session(file, source);
    if (!opened) return opened.error();
    OpenedSession& session = *opened.value();
    return play(session.source.name, session.scene, hand_of(*session.reader, where));
  }
  if (source.empty())
    return Error{"a path is of no scan", "--hand", where, "SRC too",
                 "for example: trephine bench feel head --hand path.csv -o out/"};
  const auto path = open_path(file);
  if (!path) return path.error();
  auto opened = open_touch(source, {});
  if (!opened) return opened.error();
  return play(opened.value().source.name, opened.value().scene, path);
}

/// The built-in scenes, and a scan when one is given, with every method.
volume::Status bench_feel(const BenchArguments& arguments, Outcome& outcome) {
  if (arguments.output.empty())
    return Error{"there is no folder for the charts", "-o", "", "-o DIR", "for example -o out/"};
  std::error_code failed;
  std::filesystem::create_directories(arguments.output, failed);
  if (failed)
    return Error{"the folder cannot be made", data_tools::file_name(arguments.output), failed.message(),
                 "a place that may be written", "choose another with -o"};
  bench::FeelOptions options;
  options.is_quick = arguments.is_quick;
  options.only = arguments.only;
  bool is_any = false;  // of the built-in ones
  options.look = [&](const bench::FeelScene& scene) -> volume::Status {
    is_any = is_any || scene.group != "real";
    return arguments.export_folder.empty() ? std::nullopt : export_scene(arguments.export_folder, scene);
  };
  // Our own answers too, in the form that --score reads.
  std::ostringstream ours;
  ours << "scene,proxy_x,proxy_y,proxy_z\n";
  if (!arguments.export_folder.empty())
    options.answered = [&ours](const bench::FeelScene& scene, const std::string& method,
                               const std::vector<glm::dvec3>& proxies) {
      if (method != haptics::k_default_method) return;
      for (const glm::dvec3& p : proxies)
        ours << format_text("%s,%.17g,%.17g,%.17g\n", bench::feel_id(scene).c_str(), p.x, p.y, p.z);
    };
  if (!arguments.score.empty()) {
    auto answers = read_answers(arguments.score);
    if (!answers) return answers.error();
    options.answers = std::move(answers).value();
  }
  // The scan that was named, and those of the real data where they are.
  std::vector<std::string> scans;
  if (!arguments.source.empty() && arguments.hand.empty()) scans.push_back(arguments.source);
  Unpacked skull;
  if (const char* data = std::getenv("TREPHINE_DATA"); data && arguments.only.empty()) {
    const std::filesystem::path folder(data);
    if (const auto spine = folder / "spine_lumbar" / "example_ct.nii.gz";
        std::filesystem::exists(spine, failed))
      scans.push_back(spine.string());
    if (skull.unpack(folder / "skull_phantom" / "bone_1mm.dicom.tar.xz")) scans.push_back(skull.folder());
  }
  for (const std::string& scan : scans) {
    auto opened = open_touch(scan, {});
    if (!opened) return opened.error();
    haptics::TouchScene& scene = opened.value().scene;
    for (const double speed : {100.0, 10.0}) {
      if (arguments.is_quick && speed < 100) continue;
      options.more.push_back(
          real_scene(scan == skull.folder() ? "skull" : opened.value().source.name,
                     format_text("slide %.0f mm/s", speed), scene,
                     bench::slide_over(scene, speed, 1, arguments.is_quick ? 1500 : 3100)));
    }
  }
  if (!arguments.hand.empty()) {
    auto hand = recorded_hand(arguments.hand, arguments.source);
    if (!hand) return hand.error();
    options.more.push_back(std::move(hand).value());
  }
  if (options.answers) {
    std::vector<std::string> known;
    for (const std::string& id : bench::feel_scene_ids(arguments.is_quick))
      if (id.find(arguments.only) != std::string::npos) known.push_back(id);
    for (const bench::FeelScene& scene : options.more) known.push_back(bench::feel_id(scene));
    for (const auto& [id, proxies] : options.answers->proxies_world)
      if (std::find(known.begin(), known.end(), id) == known.end())
        return Error{"the answers name a scene that is not played", data_tools::file_name(arguments.score),
                     id, "one of the folders that --export writes",
                     "play the same set: --quick or not, and --only"};
  }
  ProgressLine progress("feeling");
  options.progress = [&progress](double share) { return progress(share); };
  const bench::FeelReport report = bench::run_feel(options);
  if (report.is_stopped) return interrupted("the benchmark");
  if (report.failure) return report.failure;
  if (!arguments.export_folder.empty())
    if (volume::Status error = data_tools::write_file_atomically(
            (std::filesystem::path(arguments.export_folder) / "our-answers.csv").string(), ours.str()))
      return error;
  if (!is_any)
    return Error{"no scene has such a name", "--only", arguments.only,
                 "part of a name such as sphere-psf-1.5-slide-100-mm-s", ""};
  Json machine = new_report("bench-feel");
  machine.erase("schema");
  if (volume::Status error = write_feel_report(report, arguments.output, arguments.is_quick, machine))
    return error;
  outcome.json["rows"] = feel_rows(report);
  outcome.json["peers"] = feel_peers(report);
  outcome.json["split"] = feel_split(report);
  outcome.json["output"] = data_tools::file_name(arguments.output);
  outcome.text = feel_summary(report) +
                 "charts and tables: " + (std::filesystem::path(arguments.output) / "index.html").string() +
                 "\n";
  return std::nullopt;
}

/// One map: what the simulated device bore, as dots, and what theory says, as lines.
view::Chart stiffness_chart(const std::vector<bench::StiffnessRow>& rows, const std::string& what,
                            const char* title) {
  view::Chart chart{title, "servo rate (Hz)", "stiffness (N/mm)", true, true, {}};
  std::size_t color = 0;
  struct Loop {
    double alpha;
    int delay;
    bool has_encoder;
    const char* name;
  };
  for (const auto& [alpha, delay, has_encoder, name] :
       {Loop{1, 0, false, "raw"}, Loop{0.3, 0, false, "smoothed, alpha 0.3 at 1 kHz"},
        Loop{1, 2, false, "two ticks late"}, Loop{1, 0, true, "encoder 0.02 mm, friction 0.02 N"}}) {
    view::ChartSeries dots{"", {}, {}, false, view::chart_color(color), 9};
    view::ChartSeries theory{name, {}, {}, true, view::chart_color(color), 2},
        rule{std::string(name) + ", rule of thumb", {}, {}, true, view::chart_color(color), 1.2f, true};
    ++color;
    for (const bench::StiffnessRow& row : rows) {
      if (row.what != what || row.alpha != alpha || std::lround(row.delay_s * row.rate_hz) != delay ||
          (row.encoder_mm > 0) != has_encoder)
        continue;
      dots.x.push_back(row.rate_hz), dots.y.push_back(row.simulated);
      if (row.surface != "wall") continue;
      theory.x.push_back(row.rate_hz), theory.y.push_back(row.theory);
      rule.x.push_back(row.rate_hz), rule.y.push_back(row.rule);
    }
    if (dots.x.empty()) continue;
    if (color == 1) dots.name = "simulated: wall, sphere, 3 mm burr";
    chart.series.push_back(theory);
    if (what != "passive for any hand") chart.series.push_back(rule);
    chart.series.push_back(dots);
  }
  return chart;
}

/// Random attacks, maps and energies; on a scan too when one is given.
volume::Status bench_stability(const BenchArguments& arguments, Outcome& outcome) {
  if (arguments.steps < 1000 || arguments.steps > 10'000'000'000)
    return Error{"the number of steps is out of range", "--steps", std::to_string(arguments.steps),
                 "1000 to 10000000000", ""};
  bench::AttackOptions options;
  options.steps = arguments.steps;
  if (!arguments.source.empty()) {
    auto opened = open_touch(arguments.source, {});
    if (!opened) return opened.error();
    options.more.emplace_back(opened.value().source.name, opened.value().scene);
  }
  if (!arguments.output.empty()) {
    std::error_code failed;
    std::filesystem::create_directories(arguments.output, failed);
    if (failed)
      return Error{"the folder cannot be made", data_tools::file_name(arguments.output), failed.message(),
                   "a place that may be written", "choose another with -o"};
  }
  if (!arguments.only.empty()) {
    for (const haptics::MethodInfo& info : haptics::method_catalogue())
      if (std::string(info.name).find(arguments.only) != std::string::npos)
        options.methods.emplace_back(info.name);
    if (options.methods.empty())
      return Error{"no method has such a name", "--only", arguments.only,
                   "part of one of " + haptics::method_names(), ""};
  }
  ProgressLine progress("attacking");
  bool is_stopped = false;
  options.progress = [&](double share) { return !(is_stopped = !progress(share)); };
  const std::vector<bench::AttackRow> attacks = bench::run_attack(options);
  if (is_stopped) return interrupted("the attack");
  const std::vector<bench::StiffnessRow> maps = bench::run_stiffness_maps(options.progress);
  if (is_stopped) return interrupted("the maps");
  const std::vector<bench::EnergyRow> energies = bench::run_energy_test();
  // An hour of contact, a minute where few steps were asked for.
  const bench::SoakRow soak = bench::run_contact_soak(
      options.steps >= 1'000'000 ? 3'600'000 : bench::SoakRow::k_early, options.progress);
  if (is_stopped) return interrupted("the soak");

  long falls = 0, steps = 0;
  outcome.text += format_text("%-16s %-46s %10s %10s %6s %6s %6s\n", "method", "scene", "steps", "contacts",
                              "fell", "sunk", "buried");
  std::string csv =
      "method,scene,steps,contacts,fall_throughs,judged_by_shape,sunk,buried,not_finite,fastest_mm_s\n";
  for (const bench::AttackRow& row : attacks) {
    falls += row.fall_throughs + row.sunk + row.not_finite, steps += row.steps;
    // What was never touched was not tested.
    outcome.text += format_text("%-16s %-46s %10ld %10ld ", row.method.c_str(), row.scene.c_str(), row.steps,
                                row.contacts);
    outcome.text += row.contacts > 0
                        ? format_text("%6ld %6ld %6ld\n", row.fall_throughs, row.sunk, row.buried)
                        : format_text("%6s %6s %6s\n", "-", "-", "-");
    std::string scene = row.scene;
    std::replace(scene.begin(), scene.end(), ',', ';');
    csv += format_text("%s,%s,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%.0f\n", row.method.c_str(), scene.c_str(),
                       row.steps, row.contacts, row.fall_throughs, row.judged_by_shape, row.sunk, row.buried,
                       row.not_finite, row.fastest_mm_s);
    outcome.json["attacks"].push_back({{"method", row.method},
                                       {"scene", row.scene},
                                       {"steps", row.steps},
                                       {"contacts", row.contacts},
                                       {"fall_throughs", row.fall_throughs},
                                       {"judged_by_shape", row.judged_by_shape},
                                       {"sunk", row.sunk},
                                       {"buried", row.buried},
                                       {"not_finite", row.not_finite},
                                       {"fastest_mm_s", row.fastest_mm_s}});
  }
  outcome.text += format_text(
      "%ld steps at up to 10 m/s, cut and undone under the tool: fell through %ld times\n", steps, falls);
  outcome.text += format_text(
      "%.1f minutes of simulated contact: proxy drift %.1e mm, hash %016llx; without friction (%.1f minutes, "
      "%.0f %% in "
      "contact) energy made %.4f N mm at most\n",
      static_cast<double>(soak.steps) / 60e3, soak.drift_mm, static_cast<unsigned long long>(soak.hash),
      static_cast<double>(soak.frictionless_steps) / 60e3,
      100.0 * static_cast<double>(soak.frictionless_contacts) /
          static_cast<double>(std::max(1L, soak.frictionless_steps)),
      soak.most_made);
  outcome.json["soak"] = {{"steps", soak.steps},
                          {"contacts", soak.contacts},
                          {"not_finite", soak.not_finite},
                          {"drift_mm", soak.drift_mm},
                          {"most_made_nmm", soak.most_made},
                          {"frictionless_steps", soak.frictionless_steps},
                          {"frictionless_contacts", soak.frictionless_contacts},
                          {"hash", format_text("%016llx", static_cast<unsigned long long>(soak.hash))}};
  std::string map_csv = "surface,what,rate_hz,alpha,delay_s,coulomb_n,encoder_mm,simulated,theory,rule\n";
  double worst = 0, least = 1e300;
  for (const bench::StiffnessRow& row : maps) {
    // With an encoder theory says what suffices.
    const double off = std::abs(row.simulated / row.theory - 1);
    if (row.encoder_mm == 0 && !(off <= worst)) worst = off;
    if (row.encoder_mm > 0) least = std::min(least, row.simulated / row.theory);
    map_csv += format_text("%s,%s,%g,%g,%g,%g,%g,%.4f,%.4f,%.4f\n", row.surface.c_str(), row.what.c_str(),
                           row.rate_hz, row.alpha, row.delay_s, row.coulomb_n, row.encoder_mm, row.simulated,
                           row.theory, row.rule);
    outcome.json["stiffness"].push_back({{"surface", row.surface},
                                         {"what", row.what},
                                         {"rate_hz", row.rate_hz},
                                         {"alpha", row.alpha},
                                         {"delay_s", row.delay_s},
                                         {"coulomb_n", row.coulomb_n},
                                         {"encoder_mm", row.encoder_mm},
                                         {"simulated", row.simulated},
                                         {"theory", row.theory},
                                         {"rule", row.rule}});
  }
  outcome.text += format_text(
      "largest stiffness, 250 Hz to 10 kHz: within %.1f %% of theory; with an encoder and friction at least "
      "%.3f of what theory says suffices\n",
      100 * worst, least);
  outcome.text += format_text("energy made, N mm:\n  %-7s %8s %6s %10s %12s %8s\n", "on a", "K/bound", "late",
                              "without", "controlled", "a step");
  for (const bench::EnergyRow& row : energies) {
    outcome.text +=
        format_text("  %-7s %8.1f %6d %10.3f %12.3f %8.3f\n", row.surface.c_str(), row.stiffness_over_bound,
                    row.delay_ticks, row.most_made, row.most_made_with, row.one_step_without);
    outcome.json["energy"].push_back({{"surface", row.surface},
                                      {"contact_share", row.contact_share},
                                      {"most_made", row.most_made},
                                      {"most_made_with", row.most_made_with},
                                      {"stiffness_over_bound", row.stiffness_over_bound},
                                      {"delay_ticks", row.delay_ticks},
                                      {"balance_without", row.balance_without},
                                      {"balance_with", row.balance_with},
                                      {"one_step", row.one_step},
                                      {"share_cut", row.share_cut}});
  }
  outcome.exit_code = falls > 0 ? exit_check_failed : exit_done;
  if (arguments.output.empty()) return std::nullopt;
  const auto path = [&](const char* name) {
    return (std::filesystem::path(arguments.output) / name).string();
  };
  if (volume::Status error = data_tools::write_file_atomically(path("attacks.csv"), csv)) return error;
  if (volume::Status error = data_tools::write_file_atomically(path("stiffness.csv"), map_csv)) return error;
  if (volume::Status error =
          data_tools::write_file_atomically(path("stability.json"), outcome.json.dump(1) + "\n"))
    return error;
  if (volume::Status error = view::write_chart(
          stiffness_chart(maps, "stable without a hand", "Stiffness that stays stable without a hand"),
          path("stable-stiffness.png")))
    return error;
  if (volume::Status error = view::write_chart(
          stiffness_chart(maps, "passive for any hand", "Stiffness that is passive for any hand"),
          path("passive-stiffness.png")))
    return error;
  outcome.text += "tables and maps: " + arguments.output + "\n";
  return std::nullopt;
}

}  // namespace

Result<Outcome> run_bench(const BenchArguments& arguments) {
  if (arguments.size < 64 || arguments.size > 800)
    return Error{"the size is out of range", "--size", std::to_string(arguments.size), "64 to 800 voxels",
                 ""};
  if (!arguments.hand.empty() && arguments.what != "feel")
    return Error{"this benchmark plays no hand", "--hand", arguments.what, "feel", ""};
  Outcome outcome{new_report("bench-" + arguments.what), "", exit_done};
  if (arguments.what == "surface")
    bench_surface(arguments.size, outcome);
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
  } else {
    return Error{"there is no such benchmark", "", arguments.what,
                 "surface, step, rays, load, feel or stability", ""};
  }
  return outcome;
}

}  // namespace trephine::app
