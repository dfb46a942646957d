
#include "apps/trephine/commands.h"
#include "apps/trephine/text.h"
#include "data-tools/atomic_file.h"
#include "data-tools/open_volume.h"
#include "haptics/proxy/methods.h"
#include "modules/drilling/burr.h"
#include "sim/lockstep.h"
#include "volume/operated_volume.h"

namespace trephine::app {

using volume::Error;
using volume::Result;

namespace {

/// How near the tool came to what must not be cut, and each time that it was inside; then the check failed.
void tell_forbidden(const sim::Engine& engine, double dt, Outcome& outcome) {
  if (engine.forbidden().empty()) return;
  Json all = Json::array();
  for (std::size_t s = 0; s < engine.forbidden().size(); ++s) {
    const sim::ForbiddenWatch& watch = engine.watch(0, s);
    const std::string& name = engine.forbidden()[s]->name();
    Json visits = Json::array();
    const sim::Chronicle& chronicle = engine.now().chronicle;
    for (std::size_t i = 0; i < chronicle.size(); ++i) {
      const auto* entered = chronicle[i].what.as<sim::ForbiddenEntered>();
      const auto* left = chronicle[i].what.as<sim::ForbiddenLeft>();
      const glm::dvec3& at = chronicle[i].place_world;
      if (entered && entered->structure == name)
        visits.push_back({{"at_seconds", static_cast<double>(chronicle[i].tick) * dt},
                          {"place_world_mm", {at.x, at.y, at.z}},
                          {"is_working", entered->is_working},
                          {"deepest_mm", watch.deepest_now},
                          {"is_left", false}});
      if (left && left->structure == name) {
        visits.back()["deepest_mm"] = left->deepest;
        visits.back()["seconds"] = left->seconds;
        visits.back()["is_left"] = true;
      }
    }
    all.push_back({{"structure", name},
                   {"nearest_mm", watch.nearest},
                   {"seconds_inside", static_cast<double>(watch.ticks_inside) * dt},
                   {"visits", visits}});
    if (watch.entries == 0) {
      outcome.text += watch.nearest < sim::Forbidden::k_reach
                          ? format_text("%s: never nearer than %.1f mm\n", name.c_str(), watch.nearest)
                          : format_text("%s: never within %.0f mm\n", name.c_str(), sim::Forbidden::k_reach);
      continue;
    }
    outcome.text +=
        format_text("%s was entered %lld time%s, %.2f mm deep at most, for %.2f s\n", name.c_str(),
                    static_cast<long long>(watch.entries), watch.entries == 1 ? "" : "s", -watch.nearest,
                    static_cast<double>(watch.ticks_inside) * dt);
    outcome.exit_code = exit_check_failed;
  }
  outcome.json["forbidden"] = all;
}

}  // namespace

Result<Outcome> run_drill(const DrillArguments& arguments) {
  if (volume::Status error = check_burr(arguments.burr_diameter)) return *error;
  if (volume::Status error = check_rate(arguments.rate)) return *error;
  if (!(arguments.removal_rate > 0 && arguments.removal_rate <= 1e5))
    return Error{"the removal rate is out of range", "--removal-rate", std::to_string(arguments.removal_rate),
                 "above 0, at most 100000 mm3/s", ""};
  if (!data_tools::is_writable_volume_file(arguments.output))
    return Error{"this is no volume format that trephine writes", data_tools::file_name(arguments.output), "",
                 ".mha, .nrrd, .nii or .nii.gz", "choose one of these extensions"};
  if (volume::Status error = data_tools::check_writable(arguments.output)) return *error;
  if (volume::Status error =
          check_apart(arguments.output, {arguments.source, arguments.path, arguments.record.file}))
    return *error;
  if (volume::Status error = check_record(arguments.record)) return *error;
  if (arguments.is_round && arguments.is_kinematic)
    return Error{"a burr that is not held by the bone has no round touch", "--round", "--kinematic",
                 "one of the two", ""};
  if (arguments.is_round && arguments.burr_diameter > 12)
    return Error{"the burr is too large for a round touch", "--burr-diameter",
                 std::to_string(arguments.burr_diameter), "at most 12 mm", "leave --round out"};
  auto path = open_path(arguments.path);
  if (!path) return path.error();
  auto made = haptics::make_method(arguments.method);
  if (!made) return made.error();
  const haptics::ProxyMethod& method = *made.value();
  auto opened =
      open_touch(arguments.source, arguments.shape,
                 haptics::find_method(arguments.method)->solid == haptics::MethodInfo::Solid::smooth);
  if (!opened) return opened.error();
  const Source& source = opened.value().source;
  haptics::TouchScene& scene = opened.value().scene;
  drilling::Burr burr;
  burr.diameter = arguments.burr_diameter;
  burr.is_kinematic = arguments.is_kinematic;
  burr.is_round = arguments.is_round;
  burr.removal_rate = arguments.removal_rate;
  if (volume::Status error = make_ready_for(burr, arguments.smallest_burr, arguments.burr_diameter, scene))
    return *error;
  if (volume::Status error = made.value()->prepare(scene)) {
    if (error->where == "--smallest-burr" && !arguments.smallest_burr) error->where = "--burr-diameter";
    if (arguments.is_round && error->where == "--radius")
      error->where = "--round with --method " + arguments.method;
    return *error;
  }
  haptics::ServoOptions servo;
  servo.rate_hz = arguments.rate;
  auto forbidden = forbidden_of(source);
  if (!forbidden) return forbidden.error();
  auto recorder = start_recording(arguments.record, source, scene, method, servo, drilling::burr(burr), {},
                                  forbidden.value().told);
  if (!recorder) return recorder.error();
  sim::Lockstep run(sim::Engine(scene, method, drilling::burr(burr), 1 / arguments.rate, catalogue(),
                                forbidden.value().watched),
                    servo.force, arguments.rate, recorder.value().get());

  const std::vector<double> times = haptics::servo_times(path.value(), arguments.rate);
  std::vector<double> tick_us;
  bool has_met = false;
  long hovering = 0;  // ticks in which a round burr may feel what is gone
  ProgressLine progress("drilling");
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (i % 256 == 0 && !progress(static_cast<double>(i) / static_cast<double>(times.size()))) {
      if (recorder.value() && !finish_recording(recorder.value().get(), run.engine(), 0))
        notice("the session up to here is kept: " + data_tools::file_name(arguments.record.file));
      return interrupted("drilling");
    }
    const auto begin = Clock::now();
    run.step(path.value().at(times[i]));
    has_met = has_met || run.last_record().has_contact;
    hovering += run.engine().has_stale_fields() && run.last_record().has_contact;
    if (run.last_outcome().is_changed)
      tick_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
  }
  const volume::Version& version = *run.engine().current();
  // A recording that failed takes nothing else with it.
  const volume::Status not_recorded = finish_recording(recorder.value().get(), run.engine(), 0);
  auto result = volume::operated_volume(version);
  if (!result) return result.error();
  if (volume::Status error = data_tools::write_volume(arguments.output, result.value())) return *error;
  if (not_recorded) return *not_recorded;

  Outcome outcome{new_report("drill"), "", exit_done};
  Json& json = outcome.json;
  json["source"] = source.name;
  json["shape"] = describe(scene.items[0].field.shape(), source.volume->is_hounsfield);
  json["burr_diameter_mm"] = arguments.burr_diameter;
  json["is_kinematic"] = arguments.is_kinematic;
  json["is_round"] = arguments.is_round;
  if (arguments.is_round) {
    json["touch_radius_mm"] = scene.tool_radius;
    json["ticks_hovering"] = hovering;
  }
  json["method"] = method.name();
  json["steps"] = times.size();
  json["removed_mm3_total"] = run.engine().removed_mm3();
  Json by_label = Json::object();
  const std::vector<double> removed = run.engine().removed_mm3_by_label();
  for (std::size_t i = 0; i < removed.size(); ++i)
    if (removed[i] > 0)
      by_label[i < source.volume->label_names.size() ? source.volume->label_names[i] : "all"] = removed[i];
  json["removed_mm3"] = by_label;
  json["tick_us"] = percentiles(tick_us);
  json["content_hash"] = hash_text(version.content_hash());
  json["memory"] = memory_report(scene, version);
  json["file"] = data_tools::file_name(arguments.output);
  outcome.text = format_text("removed %.2f mm3 in %zu steps\n", run.engine().removed_mm3(), times.size());
  for (const auto& [name, mm3] : by_label.items())
    outcome.text += format_text("  %s %.2f mm3\n", name.c_str(), mm3.get<double>());
  outcome.text += "written to " + arguments.output + "\n";
  tell_forbidden(run.engine(), 1 / arguments.rate, outcome);
  if (const haptics::ServoRecord& last = run.last_record(); last.has_contact) {
    const double held = glm::length(last.proxy_world - last.pose.position_world);
    const glm::ivec3 hand =
        volume::voxel_of(source.volume->frame.volume_from_world(last.pose.position_world));
    const bool is_inside =
        source.volume->contains(hand) && version.is_kept(hand) && scene.items[0].bits->is_solid(hand);
    if (held > 3)
      notice(format_text(
          is_inside ? "note: at its end the path is %.0f mm inside the bone, and the burr is held; lift "
                      "it before it moves aside"
                    : "note: at its end the hand is %.0f mm from the burr, which is caught under bone; "
                      "lift it the way it came",
          held));
  }
  if (run.engine().removed_mm3() == 0 && has_met)
    notice("note: the burr met the shape and took nothing: the path did not press, or not for long");
  else if (run.engine().removed_mm3() == 0)
    say_where(scene, path.value());
  return outcome;
}

}  // namespace trephine::app
