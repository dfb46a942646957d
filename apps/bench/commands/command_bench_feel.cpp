// bench feel: error and time of contact methods.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <unistd.h>

#include "apps/bench/commands/bench_commands.h"
#include "apps/bench/commands/feel_report.h"
#include "apps/bench/peers.h"
#include "apps/bench/scorer.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"
#include "data-tools/formats/open_volume.h"
#include "haptics/methods/methods.h"
#include "volume/cuts/operated_volume.h"

namespace trephine::bench {

using namespace cli;

namespace {

/// Writes one scene as plain files: volume.mha as touched (for example drilled), scene.json, hip.csv and, if
/// the exact answer is known, ideal.csv.
Status export_scene(const std::string& folder, const bench::FeelScene& scene) {
  const std::filesystem::path scene_folder = std::filesystem::path(folder) / bench::feel_id(scene);
  if (Status error = data_tools::make_folder(scene_folder.string())) return error;
  std::optional<volume::Volume> drilled;
  if (scene.drilled) {
    auto operated = volume::operated_volume(*scene.drilled->version);
    if (!operated) return operated.error();
    drilled = std::move(operated).value();
  }
  if (Status error = data_tools::write_volume((scene_folder / "volume.mha").string(),
                                              drilled ? *drilled : *scene.scene.base))
    return error;
  const volume::Shape& shape = scene.scene.items[0].field.shape();
  const Json description{{"id", bench::feel_id(scene)},
                         {"radius_mm", scene.radius_mm},
                         {"solid_from", shape.low},
                         {"stiffness_n_mm", scene.scene.items[0].material.stiffness},
                         {"rate_hz", 1000}};
  if (Status error = data_tools::write_file_atomically((scene_folder / "scene.json").string(),
                                                       text_of_json(description) + "\n"))
    return error;
  std::ostringstream hip, ideal;
  scene.path.write_csv(hip);
  if (Status error = data_tools::write_file_atomically((scene_folder / "hip.csv").string(), hip.str()))
    return error;
  if (!scene.distance) return std::nullopt;
  const bench::IdealProxies exact(scene);
  ideal << "t,proxy_x,proxy_y,proxy_z\n";
  for (std::size_t i = 0; i < exact.on_shape().proxies.size(); ++i) {
    const glm::dvec3& p = exact.on_shape().proxies[i];
    ideal << format_text("%.17g,%.17g,%.17g,%.17g\n", scene.path.samples()[i].t, p.x, p.y, p.z);
  }
  return data_tools::write_file_atomically((scene_folder / "ideal.csv").string(), ideal.str());
}

/// Reads scene,proxy_x,proxy_y,proxy_z[,us]: a row per step, in the order of hip.csv.
Result<bench::FeelResults> read_results(const std::string& path) {
  std::ifstream in(path);
  const std::string where = data_tools::file_name(path);
  if (!in)
    return Error{.what = "the results cannot be read",
                 .where = where,
                 .expected = "a file of scene,proxy_x,proxy_y,proxy_z[,us]"};
  bench::FeelResults results;
  results.program = std::filesystem::path(path).stem().string();
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
      return Error{.what = "the results have an invalid line",
                   .where = where + ", line " + std::to_string(number),
                   .found = line,
                   .expected = "scene,proxy_x,proxy_y,proxy_z[,us]",
                   .remedy = "write one line per step of hip.csv, with numbers in mm"};
    if (!std::isfinite(x + y + z + us) || (read == 4 && us <= 0))
      return Error{.what = "the results have an invalid number",
                   .where = where + ", line " + std::to_string(number),
                   .found = line,
                   .expected = "finite numbers, times above 0"};
    const std::string scene = line.substr(0, comma);
    results.proxies_world[scene].emplace_back(x, y, z);
    if (read == 4) results.us[scene].push_back(us);
  }
  for (const auto& [scene, us] : results.us)
    if (us.size() != results.proxies_world[scene].size())
      return Error{.what = "the results have times for some steps only",
                   .where = where,
                   .found = scene,
                   .expected = "us in every row of a scene, or in none"};
  if (results.proxies_world.empty())
    return Error{
        .what = "the results are empty", .where = where, .expected = "scene,proxy_x,proxy_y,proxy_z[,us]"};
  return results;
}

bench::FeelScene real_scene(const std::string& name, const std::string& motion, haptics::TouchScene scene,
                            haptics::PosePath path) {
  for (haptics::TouchItem& shape : scene.items)
    shape.material.static_friction = shape.material.dynamic_friction = 0;
  bench::FeelScene real;
  real.name = name, real.variant = "as scanned", real.motion = motion, real.group = "real";
  real.radius_mm = scene.tool->radius();
  real.scene = std::move(scene);
  real.path = std::move(path);
  return real;
}

/// Returns the path resampled at 1 kHz, at which this benchmark plays it, with at most 20 000 samples.
Result<haptics::PosePath> resampled_to_1_khz(const haptics::PosePath& path, const std::string& where) {
  constexpr std::size_t k_max = 20'000;
  std::vector<haptics::PosePath::Sample> samples;
  for (const double t : haptics::servo_times(path, 1000))
    if (samples.size() < k_max) samples.push_back({t, path.at(t)});
  return haptics::PosePath::from_samples(std::move(samples), where);
}

/// Poses of a session's first hand in its first 20 s; invalid poses are left out.
Result<haptics::PosePath> hand_of(sim::SessionReader& session, const std::string& where) {
  constexpr double k_max_seconds = 20;
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
    if (samples.back().t - samples.front().t > k_max_seconds) break;
  }
  return haptics::PosePath::from_samples(std::move(samples), where);
}

/// A recorded hand over its scan: a session, or a path over `source`.
Result<bench::FeelScene> recorded_hand(const std::string& file, const std::string& source) {
  const std::string where = data_tools::file_name(file);
  const auto play = [&](const std::string& name, haptics::TouchScene& scene,
                        const Result<haptics::PosePath>& path) -> Result<bench::FeelScene> {
    if (!path) return path.error();
    auto played = resampled_to_1_khz(path.value(), where);
    if (!played) return played.error();
    return real_scene(name, "recorded hand", std::move(scene), std::move(played).value());
  };
  if (workbench::is_session_file(file)) {
    auto opened = workbench::open_session(file, source, terminal_listener());
    if (!opened) return opened.error();
    workbench::OpenedSession& session = *opened.value();
    haptics::TouchScene scene = session.scene();
    return play(session.source.written_name(), scene, hand_of(*session.reader, where));
  }
  if (source.empty())
    return Error{.what = "a recorded path requires a scan",
                 .where = "--hand",
                 .found = where,
                 .expected = "SRC, the scan over which the path was recorded",
                 .remedy = "pass it, for example: trephine-bench feel head --hand path.csv -o out/"};
  const auto path = workbench::open_path(file);
  if (!path) return path.error();
  auto opened = workbench::open_touch(source, {}, terminal_listener());
  if (!opened) return opened.error();
  return play(opened.value().source.written_name(), opened.value().scene, path);
}

}  // namespace

/// Plays these with every method: the built-in scenes; a given scan or recorded hand; and, without --only, a
/// spine and a skull of TREPHINE_DATA.
Status bench_feel(const BenchArguments& arguments, Outcome& outcome) {
  if (arguments.output.empty())
    return Error{.what = "the folder for the charts is missing",
                 .where = "-o",
                 .expected = "-o DIR",
                 .remedy = "pass a folder, such as -o out/"};
  if (Status error = data_tools::make_folder(arguments.output)) return error;
  bench::FeelOptions options;
  options.is_quick = arguments.is_quick;
  options.only = arguments.only;
  options.methods = arguments.methods;
  const std::vector<std::string> known = bench::feel_methods();
  for (const std::string& name : arguments.methods)
    if (std::find(known.begin(), known.end(), name) == known.end())
      return Error{.what = "unknown method",
                   .where = "--methods",
                   .found = name,
                   .expected = data_tools::list_of(known, known.size())};
  bool has_built_in_scene = false;  // at least one was played
  options.inspect = [&](const bench::FeelScene& scene) -> Status {
    has_built_in_scene = has_built_in_scene || scene.group != "real";
    return arguments.export_folder.empty() ? std::nullopt : export_scene(arguments.export_folder, scene);
  };
  // Collects the proxies of the default method, too, in the format that --results reads.
  std::ostringstream ours;
  ours << "scene,proxy_x,proxy_y,proxy_z\n";
  if (!arguments.export_folder.empty())
    options.on_results = [&ours](const bench::FeelScene& scene, const std::string& method,
                                 const std::vector<glm::dvec3>& proxies) {
      if (method != haptics::k_default_method) return;
      for (const glm::dvec3& p : proxies)
        ours << format_text("%s,%.17g,%.17g,%.17g\n", bench::feel_id(scene).c_str(), p.x, p.y, p.z);
    };
  if (!arguments.results.empty()) {
    auto results = read_results(arguments.results);
    if (!results) return results.error();
    options.results = std::move(results).value();
  }
  // The given scan, and the scans of the real data if present.
  std::vector<std::string> scans;
  if (!arguments.source.empty() && arguments.hand.empty()) scans.push_back(arguments.source);
  std::string skull;
  if (const char* data = std::getenv("TREPHINE_DATA"); data && arguments.only.empty()) {
    const std::filesystem::path folder(data);
    std::error_code ignored;
    if (const auto spine = folder / "spine_lumbar" / "example_ct.nii.gz";
        std::filesystem::exists(spine, ignored))
      scans.push_back(spine.string());
    if (const auto packed = folder / "skull_phantom" / "bone_1mm.dicom.tar.xz";
        std::filesystem::exists(packed, ignored))
      scans.push_back(skull = packed.string());
  }
  for (const std::string& scan : scans) {
    auto opened = workbench::open_touch(scan, {}, terminal_listener());
    if (!opened) return opened.error();
    haptics::TouchScene& scene = opened.value().scene;
    for (const double speed : {100.0, 10.0}) {
      if (arguments.is_quick && speed < 100) continue;
      options.more.push_back(
          real_scene(scan == skull ? "skull" : opened.value().source.written_name(),
                     format_text("slide %.0f mm/s", speed), scene,
                     bench::slide_over(scene, speed, 1, arguments.is_quick ? 1500 : 3100)));
    }
  }
  if (!arguments.hand.empty()) {
    auto hand = recorded_hand(arguments.hand, arguments.source);
    if (!hand) return hand.error();
    options.more.push_back(std::move(hand).value());
  }
  if (options.results) {
    std::vector<std::string> known;
    for (const std::string& id : bench::feel_scene_ids(arguments.is_quick))
      if (id.find(arguments.only) != std::string::npos) known.push_back(id);
    for (const bench::FeelScene& scene : options.more) known.push_back(bench::feel_id(scene));
    for (const auto& [id, proxies] : options.results->proxies_world)
      if (std::find(known.begin(), known.end(), id) == known.end())
        return Error{.what = "the results name an unknown scene",
                     .where = data_tools::file_name(arguments.results),
                     .found = id,
                     .expected = "the name of a folder that --export writes",
                     .remedy = "use the same --quick and --only as for --export"};
  }
  ProgressLine progress("running scenes");
  options.progress = [&progress](double share) { return progress(share); };
  const bench::FeelReport report = bench::run_feel(options);
  if (report.is_stopped) return interrupted("the benchmark");
  if (report.failure) return report.failure;
  if (!has_built_in_scene)
    return Error{.what = "unknown scene",
                 .where = "--only",
                 .found = arguments.only,
                 .expected = "part of a name such as sphere-psf-1.5-slide-100-mm-s"};
  if (!arguments.export_folder.empty())
    if (Status error = data_tools::write_file_atomically(
            (std::filesystem::path(arguments.export_folder) / "our-results.csv").string(), ours.str()))
      return error;
  Json machine = new_report("bench-feel");
  machine.erase("schema");
  if (Status error = write_feel_report(report, arguments.output, arguments.is_quick, machine)) return error;
  outcome.json["rows"] = feel_rows(report);
  outcome.json["peers"] = feel_peers(report);
  outcome.json["split"] = feel_split(report);
  print_feel_summary(report, outcome);
  outcome.print("charts and tables: {path}",
                {{"path", (std::filesystem::path(arguments.output) / "index.html").string()}});
  return std::nullopt;
}

}  // namespace trephine::bench
