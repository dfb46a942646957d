// touch: plays a path of the stylus, records the rendered force, and judges every tick.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>

#include "apps/cli/audit/returned_energy.h"
#include "apps/cli/audit/touch_judge.h"
#include "apps/cli/commands.h"
#include "apps/cli/commands/steps_csv.h"
#include "apps/cli/options/model_options.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "haptics/force/effects.h"
#include "haptics/mesh/mesh_tree.h"
#include "volume/base/text.h"
#include "volume/base/work_counters.h"

namespace trephine::cli {

namespace {

struct TouchArguments {
  workbench::SourceChoice source;
  std::string path, output, method = haptics::k_default_method, friction;
  workbench::ShapeChoice shape;
  std::optional<double> stiffness, viscosity, pop_force;
  double alpha = 0.3, rate = 1000, radius = 0, blur = 0;
  ModelArguments models;
  std::vector<std::string> effects;  ///< name and parameters of each (haptics/force/effects.h)
  std::string stiffness_ramp;        ///< A,B,K as parse_ramp() reads it
  bool is_passive = false;
  workbench::RecordChoice record;
};

/// Parses "S,D": static and dynamic coefficient.
Status parse_friction(const std::string& text, data_tools::CaseMaterial& material) {
  if (text.empty()) return std::nullopt;
  char extra = 0;
  double s = 0, d = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf%c", &s, &d, &extra) != 2 || !(s >= 0 && s <= 2) ||
      !(d >= 0 && d <= s))
    return Error{.what = "invalid coefficients of friction",
                 .where = "--friction",
                 .found = text,
                 .expected = "S,D with 2 >= S >= D >= 0, for example 0.2,0.15"};
  material.static_friction = s;
  material.dynamic_friction = d;
  return std::nullopt;
}

/// Parses "A,B,K": two intensities and the stiffness (N/mm) at the second.
Status parse_ramp(const std::string& text, std::optional<haptics::StiffnessRamp>& ramp) {
  if (text.empty()) return std::nullopt;
  char extra = 0;
  haptics::StiffnessRamp r;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &r.intensity, &r.dense_intensity, &r.dense_stiffness,
                  &extra) != 3)
    return Error{.what = "the stiffness ramp needs three numbers",
                 .where = "--stiffness-ramp",
                 .found = text,
                 .expected = "A,B,K, for example 300,1500,1.0"};
  ramp = r;
  return std::nullopt;
}

/// Returns the surface properties that the arguments set.
Result<data_tools::CaseMaterial> material_of(const TouchArguments& arguments) {
  data_tools::CaseMaterial material;
  if (arguments.stiffness && !(*arguments.stiffness > 0 && *arguments.stiffness <= 100))
    return Error{.what = "the stiffness is out of range",
                 .where = "--stiffness",
                 .found = rounded_text(*arguments.stiffness),
                 .expected = "above 0, at most 100 N/mm"};
  material.stiffness = arguments.stiffness;
  material.viscosity = arguments.viscosity;
  material.pop_force = arguments.pop_force;
  if (Status error = parse_friction(arguments.friction, material)) return *error;
  return material;
}

/// Checks that no other option contradicts --tool.
Status check_tool(const TouchArguments& arguments) {
  if (arguments.models.tool.empty()) return std::nullopt;
  if (arguments.radius > 0)
    return Error{.what = "a hand has one tool",
                 .where = "--radius",
                 .found = "--tool and --radius",
                 .remedy = "omit one of them"};
  const haptics::MethodInfo* method = haptics::find_method(arguments.method);
  if (method && !method->takes_shells && arguments.method != haptics::k_default_method)
    return Error{.what = "the method does not touch with a model as the tool",
                 .where = "--method",
                 .found = arguments.method,
                 .expected = "shell",
                 .remedy = "omit --method"};
  return std::nullopt;
}

Result<Outcome> run_touch(const TouchArguments& arguments) {
  const bool needs_scene = arguments.models.is_any() && arguments.method == haptics::k_default_method;
  const auto tool = std::make_shared<const haptics::ToolShape>(arguments.radius);
  const std::string method_name = needs_scene ? haptics::general_method(*tool).name : arguments.method;
  if (!(arguments.alpha > 0 && arguments.alpha <= 1))
    return Error{.what = "the smoothing factor is out of range",
                 .where = "--alpha",
                 .found = std::to_string(arguments.alpha),
                 .expected = "above 0, at most 1"};
  workbench::OperationChoice choice;
  choice.shape = arguments.shape;
  choice.hands[0].method = method_name;
  choice.hands[0].tool = tool;
  choice.hands[0].effects = arguments.effects;
  choice.rate_hz = arguments.rate;
  choice.blur_voxels = arguments.blur;
  choice.force.smoothing_alpha = arguments.alpha;
  choice.force.is_passive = arguments.is_passive;
  auto material = material_of(arguments);
  if (!material) return material.error();
  choice.material = material.value();
  if (Status error = parse_ramp(arguments.stiffness_ramp, choice.ramp)) return *error;
  if (Status error = choose_models(arguments.models, choice)) return *error;
  if (Status error = check_tool(arguments)) return *error;
  if (Status error = check(choice)) return *error;
  data_tools::OutputSet outputs;
  for (const std::string& model : arguments.models.files()) outputs.add_input(model);
  for (const std::string& input : {arguments.source.path, arguments.path, arguments.record.file})
    outputs.add_input(input);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::table);
  if (Status error = outputs.check()) return *error;
  if (Status error = check(arguments.record)) return *error;

  // Open the path before the scan: an error in the path is then reported without a wait for the scan.
  auto path = workbench::open_path(arguments.path);
  if (!path) return path.error();
  auto opened = workbench::open_operation(arguments.source, choice, terminal_listener());
  if (!opened) return opened.error();
  const workbench::Operation& operation = opened.value();
  const workbench::Source& source = operation.source;
  const haptics::TouchScene& scene = *operation.scene();
  if (source.is_altered && !arguments.record.file.empty())
    notice(
        "note: the touched scan differs from the scan that was read, so the touched scan is written to the session");
  auto recorder = workbench::start_recording(arguments.record, operation);
  if (!recorder) return recorder.error();

  TouchJudge judge(operation);
  const WorkCounters& work = work_counters();
  const auto surfaces_before = work.surfaces.load();
  std::map<std::string, long> events;
  std::vector<double> contact_us, free_us;
  std::string csv = k_steps_header;
  haptics::ProxyCounters total, worst;
  haptics::EnergyLedger energy;
  double strongest = 0, first_touch_seconds = 0;
  ReturnedEnergy returned(scene, haptics::ForceModel(choice.force, 1 / choice.rate_hz).alpha());
  const auto observe_tick = [&](const workbench::TouchTick& tick) {
    if (csv.size() == std::strlen(k_steps_header)) first_touch_seconds = process_seconds();
    const haptics::ServoRecord& record = tick.record;
    (record.has_contact ? contact_us : free_us).push_back(tick.step_us);
    judge.observe(tick);
    returned.observe(record);
    const haptics::ProxyCounters& counters = tick.servo.last_step().counters;
    total.voxels += counters.voxels, total.cells += counters.cells, total.iterations += counters.iterations;
    worst.voxels = std::max(worst.voxels, counters.voxels);
    for (std::size_t e = 0; e < record.event_count; ++e) ++events[haptics::event_name(record.events[e].kind)];
    strongest = std::max(strongest, glm::length(record.force_world));
    energy = tick.servo.energy();
    append_step(csv, tick.t, record, record.has_contact ? name_of(item_of(scene, record.shape)) : "");
  };
  const sim::Engine engine = workbench::play_touch(operation, path.value(), recorder.value().get(),
                                                   observe_tick, terminal_listener());
  // A failed recording does not prevent the other outputs.
  const Status not_recorded = recorder.value() ? recorder.value()->finish(engine) : std::nullopt;
  if (is_interrupted()) return interrupted("the touch", recorder.value() && !not_recorded);
  outputs.write(arguments.output, [&] { return data_tools::write_file_atomically(arguments.output, csv); });
  outputs.add_recording_status(not_recorded);

  Outcome outcome(
      "touch", (judge.fall_throughs() > 0 && judge.is_guaranteed()) || judge.ticks_inside_depth_object() > 0
                   ? exit_check_failed
                   : exit_done);
  Json& json = outcome.json;
  json["source"] = name_in_report(source);
  json["shape"] = volume::describe(scene.items[0].field.shape(), source.volume->is_hounsfield);
  json["method"] = operation.method().name();
  json["steps"] = contact_us.size() + free_us.size();
  json["step_us"] = {{"contact", percentiles(contact_us)}, {"free", percentiles(free_us)}};
  json["counters"] = {{"voxels", total.voxels},
                      {"cells", total.cells},
                      {"iterations", total.iterations},
                      {"max_voxels_in_a_step", worst.voxels},
                      {"surfaces_made", work.surfaces.load() - surfaces_before},
                      {"offset_fields_made", work.offset_fields.load()},
                      {"gl_contexts_made", work.gl_contexts.load()},
                      {"shapes_with_bits", work.occupancies.load()}};
  if (const auto& offset = scene.items[0].offset)
    json["tool"] = {
        {"radius_mm", arguments.radius}, {"step_mm", offset->step_mm()}, {"bytes", offset->bytes()}};
  for (const haptics::TouchItem& item : scene.items)
    if (item.is_mesh())
      json["meshes"].push_back(
          {{"name", item.name}, {"triangles", item.tree->triangle_count()}, {"bytes", item.tree->bytes()}});
  json["events"] = events;
  json["energy_nmm"] = {{"contact", energy.contact},
                        {"friction", energy.friction},
                        {"active", energy.active},
                        {"returned", returned.returned()},
                        {"returned_at_most", returned.bound()}};
  json["fall_throughs"] = judge.judges_falls() ? Json(judge.fall_throughs()) : Json();
  if (judge.has_depth_objects()) json["ticks_inside_depth_object"] = judge.ticks_inside_depth_object();
  json["stuck"] = judge.stuck();
  json["max_force_n"] = strongest;
  json["open_to_touch_seconds"] = first_touch_seconds;
  json["read_seconds"] = source.read_seconds;
  json["making_seconds"] = operation.build_seconds;
  json["memory"] = memory_report(scene, *engine.version());
  outcome.print("{steps} steps, {step_us/contact/count} in contact, strongest force {max_force_n:.2f} N");
  if (judge.judges_falls())
    outcome.print("fell through the surface: {fall_throughs} times; stuck at rest: {stuck} steps");
  if (returned.bound() > 0)
    outcome.print(
        "the force alone returned {energy_nmm/returned:.2f} N mm more than it absorbed; sampling and "
        "smoothing allow {energy_nmm/returned_at_most:.2f} N mm");
  if (judge.ticks_inside_depth_object() > 0)
    outcome.print(
        "inside objects touched by depth images in {ticks_inside_depth_object} of the judged ticks: the hand was too fast or "
        "too deep for them");
  if (!contact_us.empty())
    outcome.print(
        "a step in contact took {step_us/contact/p50:.2f} us (median), {step_us/contact/p999:.2f} us "
        "(99.9 %)");
  outcome.print("from start to the first step {open_to_touch_seconds:.2f} s");
  if (contact_us.empty()) print_shape_location(scene, path.value());
  return finished(outputs, std::move(outcome));
}

Run build_touch(Options& options) {
  auto a = std::make_shared<TouchArguments>();
  add_source(options, a->source).required();
  add_shape(options, a->shape);
  add_path(options, a->path).required();
  options.add("-o,--output", a->output, "Write a row for every step").required().type("STEPS.csv");
  add_method(options, a->method);
  options.add("--radius", a->radius, "Radius of the tool's tip, 0 (a point) to 6 mm")
      .means("tool radius")
      .shows_default()
      .type("MM");
  add_models(options, a->models);
  options
      .add("--blur", a->blur,
           "Gaussian filter of the scan before it is touched: sigma in voxels; 1.4 equals the seven taps in "
           "the publication of the ray-step method")
      .shows_default()
      .type("VOXELS");
  options.add("--stiffness", a->stiffness, "Stiffness of the surface, N/mm (default: 0.5, or the case's)")
      .type("N/MM");
  options
      .add("--stiffness-ramp", a->stiffness_ramp,
           "Harder where the scan is denser: from --stiffness at intensity A to K (N/mm) at B and above")
      .type("A,B,K");
  options.add("--viscosity", a->viscosity, "Viscosity along the surface, 0 to 0.05 N s/mm (default: 0)")
      .type("N.S/MM");
  options
      .add("--pop-through", a->pop_force,
           "Force above which the proxy passes through the surface (default: never)")
      .means("pop force")
      .type("N");
  add_effects(options, a->effects);
  options.add("--passive", a->is_passive, "Surfaces return no more energy to the hand than they absorbed");
  options
      .add("--friction", a->friction,
           "Static and dynamic friction coefficient (default: 0.2,0.15, or the case's)")
      .type("S,D");
  options.add("--alpha", a->alpha, "Smoothing of the force: weight of the newest value at 1 kHz; 1: raw")
      .shows_default()
      .type("A");
  add_rate(options, a->rate);
  add_record(options, a->record);
  return run_with(a, run_touch);
}

}  // namespace

const Command k_touch{
    "touch", "Play a path of the stylus over a shape and record contact and force",
    "  trephine touch head --path docs/examples/path.csv -o steps.csv\n"
    "  trephine touch head --label dura --path path.csv -o steps.csv --rate 4000 --json\n"
    "  trephine touch head --path path.csv -o steps.csv --effect \"viscous damping=0.004\" --passive\n"
    "  trephine touch head --mesh retractor.ply --mesh-at 0,-90,20 --path path.csv -o steps.csv",
    build_touch};

}  // namespace trephine::cli
