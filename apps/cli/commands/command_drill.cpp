// drill: plays a path of a burr and writes the remaining volume.
#include "apps/cli/commands.h"
#include "apps/cli/options/burr_options.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "data-tools/formats/open_volume.h"
#include "sim/drivers/lockstep.h"
#include "volume/base/text.h"

namespace trephine::cli {

namespace {

struct DrillArguments {
  workbench::SourceChoice source;
  std::string path, output;
  workbench::ShapeChoice shape;
  drilling::Burr burr;
  double rate = 1000;                   ///< Hz
  std::optional<double> smallest_burr;  ///< mm
  std::string method = haptics::k_default_method;
  workbench::RecordChoice record;
};

/// Reports the least distance of the tool from each forbidden structure, and each visit inside it. A visit
/// sets the exit code to exit_check_failed.
void report_forbidden(const sim::Engine& engine, double dt, Outcome& outcome) {
  if (engine.forbidden().empty()) return;
  Json list = Json::array();
  for (std::size_t s = 0; s < engine.forbidden().size(); ++s) {
    const sim::ForbiddenWatch& watch = engine.watch(0, s);
    const std::string& name = engine.forbidden()[s]->name();
    Json visits = Json::array();
    const sim::Chronicle& chronicle = engine.state().chronicle;
    for (std::size_t i = 0; i < chronicle.size(); ++i) {
      const auto* entered = chronicle[i].value.as<sim::ForbiddenEntered>();
      const auto* left = chronicle[i].value.as<sim::ForbiddenLeft>();
      if (entered && entered->structure == name)
        visits.push_back({{"at_seconds", static_cast<double>(chronicle[i].tick) * dt},
                          {"position_world_mm", json_of(chronicle[i].position_world)},
                          {"is_working", entered->is_working},
                          {"deepest_mm", watch.deepest_now},
                          {"is_left", false}});
      if (left && left->structure == name) {
        visits.back()["deepest_mm"] = left->deepest;
        visits.back()["seconds"] = left->seconds;
        visits.back()["is_left"] = true;
      }
    }
    list.push_back({{"structure", name},
                    {"nearest_mm", watch.nearest},
                    {"seconds_inside", static_cast<double>(watch.ticks_inside) * dt},
                    {"visits", visits}});
    if (watch.entries == 0) {
      outcome.print(watch.nearest < sim::Forbidden::k_reach
                        ? "{structure}: never nearer than {nearest_mm:.1f} mm"
                        : "{structure}: never within {nearest_mm:.0f} mm",
                    list.back());
      continue;
    }
    outcome.print(std::string("{structure} was entered {entries} time") + (watch.entries == 1 ? "" : "s") +
                      ", {deepest_mm:.2f} mm deep at most, for {seconds_inside:.2f} s",
                  {{"structure", name},
                   {"entries", watch.entries},
                   {"deepest_mm", -watch.nearest},
                   {"seconds_inside", list.back()["seconds_inside"]}});
    outcome.exit_code = exit_check_failed;
  }
  outcome.json["forbidden"] = list;
}

/// Reports the measures of modules, and the positions of breakthroughs.
void report_measures(const sim::Engine& engine, Outcome& outcome) {
  Json measures = Json::array(), breakthroughs = Json::array();
  for (const sim::Measure& measure : engine.measures()) {
    measures.push_back({{"name", measure.name}, {"value", measure.value}, {"unit", measure.unit}});
    if (measure.unit == "K" || measure.name == "deepest plunge")
      outcome.print("{name}: {value:.1f} {unit}", measures.back());
  }
  const sim::Chronicle& chronicle = engine.state().chronicle;
  for (std::size_t i = 0; i < chronicle.size(); ++i)
    if (const auto* breakthrough = chronicle[i].value.as<drilling::Breakthrough>()) {
      breakthroughs.push_back({{"position_world_mm", json_of(chronicle[i].position_world)},
                               {"thrust_n", breakthrough->thrust},
                               {"plunge_mm", breakthrough->plunge},
                               {"seconds", breakthrough->seconds}});
      outcome.print(
          "broke through at {position_world_mm:.1f} under {thrust_n:.1f} N and plunged {plunge_mm:.1f} mm",
          breakthroughs.back());
    }
  outcome.json["measures"] = measures;
  outcome.json["breakthroughs"] = breakthroughs;
}

Result<Outcome> run_drill(const DrillArguments& arguments) {
  const drilling::Burr& burr = arguments.burr;
  data_tools::OutputSet outputs;
  for (const std::string& input : {arguments.source.path, arguments.path, arguments.record.file})
    outputs.add_input(input);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::volume);
  if (Status error = outputs.check()) return *error;
  if (Status error = check(arguments.record)) return *error;
  if (burr.is_round && burr.is_kinematic)
    return Error{.what = "round touch requires that bone stops the burr",
                 .where = "--round",
                 .found = "--kinematic",
                 .expected = "one of the two",
                 .remedy = "omit --round or --kinematic"};
  if (burr.is_round && burr.diameter > 12)
    return Error{.what = "the burr is too large for a round touch",
                 .where = "burr diameter",
                 .found = text_of(burr.diameter),
                 .expected = "at most 12 mm",
                 .remedy = "omit --round"};
  auto path = workbench::open_path(arguments.path);
  if (!path) return path.error();
  workbench::OperationChoice choice;
  choice.procedure_use = workbench::ProcedureUse::ignored;
  choice.shape = arguments.shape;
  choice.hands[0] = sim::HandSpec(drilling::burr(burr));
  choice.hands[0].method = arguments.method;
  choice.rate_hz = arguments.rate;
  choice.smallest_burr = arguments.smallest_burr;
  auto opened = workbench::open_operation(arguments.source, choice, terminal_listener());
  if (!opened) return opened.error();
  const workbench::Operation& operation = opened.value();
  const workbench::Source& source = operation.source;
  const haptics::TouchScene& scene = *operation.scene();
  auto recorder = workbench::start_recording(arguments.record, operation);
  if (!recorder) return recorder.error();
  sim::Lockstep run(operation.engine(), operation.spec.force, arguments.rate, recorder.value().get());

  const std::vector<double> times = haptics::servo_times(path.value(), arguments.rate);
  std::vector<double> tick_us;
  bool has_touched = false;
  long hovering = 0;  // ticks with contact in which a round burr may still touch bone that it removed
  ProgressLine progress("drilling");
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (i % 256 == 0 && !progress(static_cast<double>(i) / static_cast<double>(times.size()))) {
      return interrupted("drilling", recorder.value() && !recorder.value()->finish(run.engine()));
    }
    const auto begin = Clock::now();
    run.step(path.value().at(times[i]));
    has_touched = has_touched || run.last_record().has_contact;
    hovering += run.engine().has_stale_fields() && run.last_record().has_contact;
    if (run.last_outcome().is_changed)
      tick_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
  }
  const volume::Version& version = *run.engine().version();
  // A failed recording does not prevent the other outputs.
  const Status not_recorded = recorder.value() ? recorder.value()->finish(run.engine()) : std::nullopt;
  notify_resampled(*source.volume, arguments.output);
  outputs.write(arguments.output, [&] { return data_tools::write_operated(arguments.output, version); });
  outputs.add_recording_status(not_recorded);

  Outcome outcome("drill");
  Json& json = outcome.json;
  json["source"] = name_in_report(source);
  json["shape"] = volume::describe(scene.items[0].field.shape(), source.volume->is_hounsfield);
  json["burr"] = sim::Value(burr).words();
  json["burr_diameter_mm"] = burr.diameter;
  json["is_kinematic"] = burr.is_kinematic;
  json["is_round"] = burr.is_round;
  if (burr.is_round) {
    json["touch_radius_mm"] = scene.tool->radius();
    json["ticks_hovering"] = hovering;
  }
  json["method"] = operation.method().name();
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
  outcome.print("removed {removed_mm3_total:.2f} mm³ in {steps} steps");
  for (const auto& [name, mm3] : by_label.items())
    outcome.print("  {name} {mm3:.2f} mm³", {{"name", name}, {"mm3", mm3}});
  report_measures(run.engine(), outcome);
  report_forbidden(run.engine(), 1 / arguments.rate, outcome);
  if (const haptics::ServoRecord& last = run.last_record(); last.has_contact) {
    const double distance = glm::length(last.proxy_world - last.pose.position_world);
    const glm::ivec3 hand =
        volume::voxel_of(source.volume->frame.volume_from_world(last.pose.position_world));
    const bool is_inside =
        source.volume->contains(hand) && version.is_kept(hand) && scene.items[0].bits->is_solid(hand);
    if (distance > 3)
      notice(format_text(
          is_inside
              ? "note: the path ends %.0f mm inside the bone, which stops the burr; lift the burr out "
                "before it moves sideways"
              : "note: the path ends %.0f mm from the burr, which is caught under bone; lift the burr out "
                "along the path on which it came",
          distance));
  }
  if (run.engine().removed_mm3() == 0 && has_touched)
    notice(
        "note: the burr touched the shape and removed nothing: the path did not press, or "
        "pressed too briefly");
  else if (run.engine().removed_mm3() == 0)
    print_shape_location(scene, path.value());
  return finished(outputs, std::move(outcome));
}

Run build_drill(Options& options) {
  auto a = std::make_shared<DrillArguments>();
  add_source(options, a->source).required();
  add_shape(options, a->shape);
  add_burr(options, a->burr).required();
  options
      .add("--smallest-burr", a->smallest_burr,
           "Smallest burr that will cut in this session, mm: the smaller, the finer cuts are sampled "
           "(default: the burr)")
      .type("MM");
  add_path(options, a->path).required();
  add_rate(options, a->rate);
  options.add("--kinematic", a->burr.is_kinematic,
              "The path moves the burr itself, which removes everything it sweeps; by default the path moves "
              "the burr's lowest point, and bone is removed where it presses");
  options.add("-o,--output", a->output, data_tools::extensions_of(data_tools::OutputKind::volume)).required();
  add_method(options, a->method);
  add_record(options, a->record);
  return run_with(a, run_drill);
}

}  // namespace

const Command k_drill{
    "drill", "Play a path of a burr and write the remaining volume",
    "  trephine drill SCANS/HEAD --burr-diameter 4 --path path.csv -o drilled.mha\n"
    "  trephine drill head --burr-diameter 6 --kinematic --path path.csv -o drilled.nii.gz --json\n"
    "  trephine drill head --burr-diameter 3 --burr-shape match-head --grade diamond --round --path path.csv "
    "-o drilled.mha",
    build_drill};

}  // namespace trephine::cli
