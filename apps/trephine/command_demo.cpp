// The main job, on its own: touch a skull, slide over it, drill a burr hole, and show it.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <thread>

#include "apps/trephine/commands.h"
#include "apps/view/bone_view.h"
#include "apps/view/render_window.h"
#include "apps/view/view_window.h"
#include "data-tools/atomic_file.h"
#include "haptics/walls/solid_grid.h"
#include "modules/drilling/burr.h"
#include "sim/live_session.h"
#include "volume/traversal.h"

namespace trephine::app {

using glm::dvec3;
using volume::Error;
using volume::Result;

namespace {

struct DemoArguments {
  std::string source = "head", output = "out";
  workbench::ShapeChoice shape;
  bool has_no_window = false;
  workbench::RecordChoice record;
};

constexpr double k_burr_radius = 3.5;  // mm
constexpr double k_removal_rate = 30;  // mm^3/s

/// Where on the bone the demo works.
struct Site {
  dvec3 point, normal, along;  ///< world: on the surface, outward, and a direction to slide
  double thickness;            ///< of the bone along the normal, mm
};

/// First solid on the way from a to b (world), as a share of it; negative when there is none.
double first_solid(const haptics::TouchScene& scene, const volume::Version& version, const dvec3& a,
                   const dvec3& b) {
  double hit = -1;
  const volume::Frame& frame = scene.base->frame;
  volume::traverse(frame.volume_from_world(a), frame.volume_from_world(b),
                   {glm::ivec3(0), scene.base->size - 1}, [&](const volume::VoxelVisit& v) {
                     if (!scene.items[0].bits->is_solid(v.voxel) || !version.is_kept(v.voxel)) return true;
                     hit = v.t_enter;
                     return false;
                   });
  return hit;
}

Result<Site> find_site(const haptics::TouchScene& scene, const volume::Version& version) {
  // Toward the middle of the volume from the front left above: the frontal bone of a head.
  const volume::Frame& frame = scene.base->frame;
  const dvec3 middle = frame.world_from_volume(0.5 * dvec3(scene.base->size - 1));
  const double far = 2 * glm::length(frame.world_from_volume(dvec3(scene.base->size)) - frame.origin());
  for (const dvec3& from : {dvec3(0.62, -0.42, 0.66), dvec3(-0.62, -0.42, 0.66), dvec3(0, 0, 1),
                            dvec3(0, 1, 0.2), dvec3(1, 0, 0)}) {
    const dvec3 outside = middle + far * glm::normalize(from) + dvec3(0, 0, 12);
    const double hit = first_solid(scene, version, outside, middle);
    if (hit < 0) continue;
    Site site;
    site.point = outside + hit * (middle - outside);
    int cells = 0;
    site.normal =
        haptics::outward_normal(scene.items[0], version, frame.volume_from_world(site.point), cells);
    if (glm::dot(site.normal, glm::normalize(outside - middle)) < 0.5) continue;
    site.along = glm::normalize(glm::cross(site.normal, dvec3(0.2, -0.35, 1)));
    // Through the bone until 3 mm of the way are free of it.
    double free_from = 0;
    site.thickness = 0;
    for (double depth = 0.25; depth < 20; depth += 0.25) {
      const glm::ivec3 v = volume::voxel_of(frame.volume_from_world(site.point - depth * site.normal));
      if (scene.base->contains(v) && scene.items[0].bits->is_solid(v)) free_from = depth;
      if (depth - free_from > 3) {
        site.thickness = free_from;
        break;
      }
    }
    if (site.thickness == 0) site.thickness = 8;  // a solid block: a blind hole
    return site;
  }
  return Error{"no surface to work on was found", "", "rays from five sides met nothing",
               "a skull-like shape", "choose the shape with --iso or --label"};
}

/// The hand's wish: approach, press, slide there and back, lift, drill, leave.
haptics::PosePath hand_script(const haptics::TouchScene& scene, const volume::Version& version,
                              const Site& site, double& drill_from, double& drill_to) {
  std::vector<haptics::PosePath::Sample> samples;
  double t = 0;
  const auto go = [&](double seconds, const dvec3& to, bool is_pressed) {
    t += seconds;
    samples.push_back({t, {to, {1, 0, 0, 0}, is_pressed}});
  };
  const dvec3 &p = site.point, &n = site.normal;
  constexpr double k_press = 3.0;  // mm the hand reaches into the bone; its spring makes that about 0.6 N
  const auto on_surface = [&](double s) {
    const dvec3 above = p + s * site.along + 15.0 * n;
    const double hit = first_solid(scene, version, above, above - 30.0 * n);
    return hit < 0 ? p + s * site.along : above - hit * 30.0 * n;
  };
  go(0, p + 30.0 * n, false);
  go(0.7, p + 3.0 * n, false);
  go(0.3, p - k_press * n, false);
  go(0.4, p - k_press * n, false);
  for (int i = 1; i <= 20; ++i) go(0.06, on_surface(i) - k_press * n, false);
  for (int i = 19; i >= 0; --i) go(0.06, on_surface(i) - k_press * n, false);
  go(0.3, p + 4.0 * n, false);
  drill_from = t;
  go(0.01, p + 4.0 * n, true);
  go(0.3, p - 1.0 * n, true);
  const double volume_mm3 = 3.14159265 * k_burr_radius * k_burr_radius * (site.thickness + k_burr_radius);
  const double seconds = 1.1 * volume_mm3 / k_removal_rate;
  go(seconds, p - (site.thickness + 9.0) * n, true);
  go(1.5, p - (site.thickness + 9.0) * n, true);
  drill_to = t;
  go(0.01, p - (site.thickness + 8.9) * n, false);
  go(0.8, p + 30.0 * n, false);
  go(0.2, p + 30.0 * n, false);
  return haptics::PosePath::from_samples(std::move(samples), "demo").value();
}

struct Moment {
  sim::LiveState state;
  dvec3 burr_centre{0.0};
  bool is_taken = false;
};

view::StylusLook stylus_at(const Moment& m, const Site& site) {
  view::StylusLook look;
  look.hip_world = m.state.newest.pose.position_world;
  look.has_contact = m.state.newest.has_contact;
  look.proxy_world = m.state.newest.proxy_world;
  look.force_world = m.state.newest.force_world;
  look.burr_radius = k_burr_radius;
  look.shaft_direction = glm::normalize(site.normal + 0.35 * site.along + dvec3(0, 0, 0.25));
  look.burr_centre_world = m.burr_centre;
  return look;
}

Result<Outcome> run_demo(const DemoArguments& arguments) {
  namespace fs = std::filesystem;
  const auto begin = Clock::now();
  if (volume::Status error = check(arguments.record)) return *error;
  std::error_code failed;
  fs::create_directories(arguments.output, failed);
  if (failed)
    return Error{"the folder for the pictures cannot be made", data_tools::file_name(arguments.output),
                 failed.message(), "a place that may be written", "choose another with -o"};

  notice("opening " +
         (arguments.source == "head" ? std::string("the built-in head")
                                     : data_tools::file_name(arguments.source)) +
         " ...");
  drilling::Burr burr;
  burr.diameter = 2 * k_burr_radius;
  burr.removal_rate = k_removal_rate;
  workbench::OperationChoice choice;
  choice.shape = arguments.shape;
  choice.hands[0] = sim::HandSpec(drilling::burr(burr));
  auto opened = workbench::open_operation(arguments.source, choice, person());
  if (!opened) return opened.error();
  const workbench::Operation& operation = opened.value();
  const workbench::Source& source = operation.source;
  const haptics::TouchScene& scene = *operation.scene();
  const double ready_seconds = seconds_since(begin);
  const volume::Version untouched(source.volume);
  auto found = find_site(scene, untouched);
  if (!found) return found.error();
  const Site& site = found.value();

  // Live: a servo thread with a simulated hand, an edit thread with the burr.
  double drill_from = 0, drill_to = 0;
  const haptics::PosePath script = hand_script(scene, untouched, site, drill_from, drill_to);
  haptics::HandModel hand;
  hand.stiffness = 0.25;
  haptics::VirtualDevice device(script, hand);
  auto recorder = workbench::start_recording(arguments.record, operation);
  if (!recorder) return recorder.error();
  haptics::Device* const devices[] = {&device};
  sim::LiveSession live(devices, operation.engine(), operation.servo(), recorder.value().get());
  notice("touching and drilling, live, for " +
         std::to_string(static_cast<int>(std::ceil(script.end_time()))) + " s ...");
  live.keep_trace(100'000);
  if (volume::Status error = live.start()) return *error;
  Moment touching, drilling;
  ProgressLine progress("drilling");
  int stalls = 0;  // looks at which the servo had missed its watchdog
  for (;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    sim::LiveState state = live.look();
    // A machine that was busy elsewhere for a tenth of a second takes the force away; nobody's hand is on
    // this stylus.
    if (state.newest.faults & haptics::fault_stale_scene) {
      live.reset_faults();
      ++stalls;
    }
    const double t = state.newest.t;
    if (!progress(t / script.end_time())) {
      live.stop();
      return interrupted("the demo");
    }
    const auto take = [&](Moment& m, double from) {
      if (m.is_taken || t < from || !state.newest.has_contact) return;
      m.state = state;
      const dvec3 tangent = state.newest.proxy_world + k_burr_radius * state.newest.normal_world;
      // While it drills the ball's lowest point is on its way to the HIP.
      m.burr_centre = state.newest.pose.is_pressed()
                          ? state.newest.pose.position_world + k_burr_radius * site.normal
                          : tangent;
      m.is_taken = true;
    };
    take(touching, 2.0);
    take(drilling, drill_from + 0.45 * (drill_to - drill_from));
    if (t >= script.end_time()) break;
  }
  live.stop();
  const sim::LiveState last = live.look();
  const haptics::ServoReport servo = live.servo_report();
  if (recorder.value())
    if (volume::Status error = recorder.value()->finish(live.engine(), servo.dropped)) return *error;

  // Was the bone opened, and what did the hand feel?
  const bool is_through = first_solid(scene, *last.version, site.point + 5.0 * site.normal,
                                      site.point - (site.thickness + 2.5) * site.normal) < 0;
  double strongest = 0;
  std::size_t contact_ticks = 0;
  for (const haptics::ServoRecord& r : live.trace()) {
    strongest = std::max(strongest, glm::length(r.force_world));
    contact_ticks += r.has_contact;
  }

  // Three pictures, each of the version of its moment.
  notice("drawing ...");
  auto surface = view::make_offscreen(1200, 900);
  if (!surface) return surface.error();
  std::vector<std::string> pictures;
  const auto start_drawing = Clock::now();
  {
    view::BoneView picture(surface.value()->window(), false);
    view::ChunkWorker worker(scene, 2);
    const auto update = [&](const std::shared_ptr<const volume::Version>& version, bool is_first) {
      const glm::ivec3 centre(source.volume->frame.volume_from_world(site.point)),
          reach(glm::ivec3(32.0 / source.volume->frame.spacing()));
      if (is_first)
        worker.request_all(version);
      else
        worker.request(version, glm::max(centre - reach, 0),
                       glm::min(centre + reach, source.volume->size - 1));
      worker.finish();
      for (const view::ChunkMesh& mesh : worker.take()) picture.bone().show(mesh);
    };
    const auto save = [&](const char* name) -> volume::Status {
      picture.render();
      pictures.emplace_back(name);
      return view::write_png(surface.value()->window(), (fs::path(arguments.output) / name).string());
    };
    dvec3 low, high;
    update(touching.is_taken ? touching.state.version : last.version, true);
    picture.bounds(low, high);
    const dvec3 middle = 0.5 * (low + high);
    if (touching.is_taken) picture.show(stylus_at(touching, site));
    picture.look(middle + dvec3(8, 0, 8), glm::normalize(dvec3(0.80, -0.78, 0.34)), {0, 0, 1},
                 0.86 * glm::length(high - low) / (2 * std::tan(14 * 3.14159265 / 180)));
    picture.show_text(format_text("Touch: %.2f N", glm::length(touching.state.newest.force_world)), "");
    if (volume::Status error = save("1-touch.png")) return *error;

    update(drilling.is_taken ? drilling.state.version : last.version, false);
    if (drilling.is_taken) picture.show(stylus_at(drilling, site));
    const dvec3 side = glm::normalize(
        site.normal + 0.9 * glm::normalize(glm::cross(site.normal, site.along)) - 0.7 * site.along);
    picture.look(site.point + 8.0 * site.normal, side, {0, 0, 1}, 190);
    picture.show_text(format_text("Drilling: %.2f N, %.0f mm\xc2\xb3 removed",
                                  glm::length(drilling.state.newest.force_world), drilling.state.removed_mm3),
                      "");
    if (volume::Status error = save("2-drilling.png")) return *error;

    update(last.version, false);
    view::StylusLook away;
    away.is_visible = false;
    picture.show(away);
    picture.look(site.point - 2.0 * site.normal,
                 glm::normalize(site.normal - 0.45 * site.along + 0.25 * glm::cross(site.normal, site.along)),
                 {0, 0, 1}, 120);
    picture.show_text(format_text("Burr hole: %.0f mm diameter, %.0f mm\xc2\xb3%s", 2 * k_burr_radius,
                                  last.removed_mm3, is_through ? ", through the bone" : ""),
                      "");
    if (volume::Status error = save("3-burr-hole.png")) return *error;
  }
  const double drawing_seconds = seconds_since(start_drawing);

  Outcome outcome{new_report("demo"), "", exit_done};
  Json& json = outcome.json;
  json["source"] = source.written_name();
  json["shape"] = volume::describe(scene.items[0].field.shape(), source.volume->is_hounsfield);
  json["ready_seconds"] = ready_seconds;
  json["live_seconds"] = script.end_time();
  json["drawing_seconds"] = drawing_seconds;
  json["ticks"] = servo.ticks;
  json["contact_ticks"] = contact_ticks;
  json["max_force_n"] = strongest;
  json["bone_thickness_mm"] = site.thickness;
  json["removed_mm3_total"] = last.removed_mm3;
  Json by_label = Json::object();
  const std::vector<double> removed = live.engine().removed_mm3_by_label();
  for (std::size_t i = 0; i < removed.size(); ++i)
    if (removed[i] > 0)
      by_label[i < source.volume->label_names.size() ? source.volume->label_names[i] : "all"] = removed[i];
  json["removed_mm3"] = by_label;
  json["is_through"] = is_through;
  json["strokes"] = last.strokes;
  json["servo"] = {{"rate_hz", 1000},
                   {"step_us",
                    {{"p50", servo.step_p50_us},
                     {"p99", servo.step_p99_us},
                     {"p999", servo.step_p999_us},
                     {"max", servo.step_max_us}}},
                   {"late_us",
                    {{"p50", servo.late_p50_us},
                     {"p99", servo.late_p99_us},
                     {"p999", servo.late_p999_us},
                     {"max", servo.late_max_us}}},
                   {"overruns", servo.overruns},
                   {"stalled_looks", stalls},
                   {"faults", servo.faults},
                   {"notice", servo.notice}};
  json["memory"] = memory_report(scene, *last.version);
  json["pictures"] = pictures;
  if (volume::Status error = data_tools::write_file_atomically(
          (fs::path(arguments.output) / "report.json").string(), text_of_json(json) + "\n"))
    return *error;
  outcome.text = format_text(
      "touched and drilled %s: %.0f mm3 removed%s, strongest force %.2f N\nservo: %llu steps, p50 "
      "%.1f us, p99 %.1f us\n"
      "pictures and report in %s/\n",
      source.name.c_str(), last.removed_mm3, is_through ? ", the burr hole is through" : "", strongest,
      static_cast<unsigned long long>(servo.ticks), servo.step_p50_us, servo.step_p99_us,
      arguments.output.c_str());
  if (!servo.notice.empty()) notice("note: " + servo.notice);

  if (!arguments.has_no_window && view::has_display()) {
    view::WindowOptions options;
    options.title = source.name;
    options.start = view::WindowStart{operation.engine()};
    if (auto shown = view::run_window(operation.scene(), options); !shown) return shown.error();
  }
  return outcome;
}

Run build(Options& options) {
  auto a = std::make_shared<DemoArguments>();
  options.add("SRC", a->source, "As everywhere; head when left out").shows_default();
  add_shape(options, a->shape);
  options.add("-o,--output", a->output, "Folder for pictures and report.json").shows_default();
  options.add("--no-window", a->has_no_window, "Do not open a window at the end");
  add_record(options, a->record);
  return run_with(a, run_demo);
}

}  // namespace

const Command k_demo{"demo", "Touch, slide and drill a burr hole by itself; pictures and a report",
                     "  trephine demo\n  trephine demo SCANS/HEAD -o out-head --no-window", build};

}  // namespace trephine::app
