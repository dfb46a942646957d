// flap: cuts a bone flap along an outline of anchors, removes the flap, judges it, and lifts it on request.
#include <algorithm>
#include <charconv>
#include <glm/geometric.hpp>

#include "apps/cli/commands.h"
#include "apps/cli/options/field_option.h"
#include "apps/view/render_window.h"
#include "apps/view/viewport.h"
#include "data-tools/cases/plan_file.h"
#include "data-tools/files/output_set.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/meshes/mesh_files.h"
#include "modules/bone_flap/judgement.h"
#include "modules/bone_flap/outline.h"
#include "modules/catalogue.h"
#include "sim/drivers/lockstep.h"
#include "volume/base/text.h"

namespace trephine::cli {

using bone_flap::CutFlap;
using bone_flap::FlapPiece;
using glm::dvec3;

namespace {

struct FlapArguments {
  workbench::SourceChoice source;
  workbench::ShapeChoice shape;
  std::string anchors, landmarks, planned;  ///< a file; prefix of the case's landmarks; a file
  std::string at, seed;                     ///< x,y,z, mm
  double diameter = 60;
  int corners = 32;
  std::vector<std::string> leave;
  CutFlap request;
  std::string target;
  std::optional<double> smallest_burr;
  double lift = 0;
  std::string output, flap, screenshot;
  workbench::RecordChoice record;
};

using Points = std::vector<dvec3>;

Result<Points> anchors_of(const FlapArguments& a, const workbench::Operation& operation) {
  const volume::Field& bone = operation.scene()->items[0].field;
  const auto case_landmarks = [&](const std::string& start, const char* option) -> Result<Points> {
    Points points;
    if (operation.source.plan)
      for (const volume::PlannedLandmark& landmark : operation.source.plan->landmarks)
        if (landmark.name.starts_with(start)) points.push_back(landmark.position_world);
    if (points.empty())
      return Error{.what = "the case has no landmarks with this prefix",
                   .where = option,
                   .found = start,
                   .expected = "a prefix of the names of its landmarks"};
    return points;
  };
  if (!a.landmarks.empty()) return case_landmarks(a.landmarks, "landmarks");
  if (!a.anchors.empty()) {
    auto plan = data_tools::read_plan(a.anchors);
    if (!plan) return plan.error();
    for (const std::string& text : plan.value().notices) notice(text);
    Points points;
    for (const volume::PlannedLandmark& landmark : plan.value().landmarks)
      points.push_back(landmark.position_world);
    if (points.empty())
      return Error{.what = "the file has no points",
                   .where = "anchors",
                   .expected = "points around the flap, in their order"};
    return points;
  }
  const auto at = parse_point(a.at, "--at");
  if (!at) return at.error();
  const Points ring = bone_flap::ring_of(bone, at.value(), a.diameter, a.corners);
  if (ring.empty())
    return Error{.what = "no bone near this position",
                 .where = "at",
                 .found = a.at,
                 .expected = "a position within 30 mm of the skull",
                 .remedy = "choose a position within the extent that trephine info prints"};
  return ring;
}

/// Returns the diameter (mm) of a burr for which the spacing of cut samples is at most half of the saw's
/// width.
double burr_for(const CutFlap& request) { return 4 * bone_flap::width_of(request.saw); }

/// Returns the last event of a type, and its position (mm, world); null if there is no such event.
template <class T>
const T* last_event(const sim::Engine& engine, dvec3* at = nullptr) {
  const sim::Chronicle& chronicle = engine.state().chronicle;
  for (std::size_t i = chronicle.size(); i-- > 0;)
    if (const T* event = chronicle[i].value.as<T>()) {
      if (at) *at = chronicle[i].position_world;
      return event;
    }
  return nullptr;
}

/// Draws the flap from outside, in a direction slightly oblique to its normal. If the normal is 0, the
/// direction from the centre of the scan replaces it. A lifted flap is drawn more from the side, so that it
/// does not cover its opening.
Status draw(sim::Lockstep& run, const workbench::Operation& operation, const dvec3& middle,
            const dvec3& normal, double lift, const std::string& path) {
  auto surface = view::make_offscreen(1200, 900);
  if (!surface) return surface.error();
  view::Viewport picture(*operation.scene(), surface.value()->window(), false);
  run.engine().freeze();
  const volume::Volume& scan = *operation.scene()->base;
  const dvec3 outward = middle - scan.frame.world_from_volume(0.5 * dvec3(scan.size - 1));
  const dvec3 view_normal = glm::normalize(normal != dvec3(0) ? normal : outward);
  dvec3 from = view::Viewport::oblique_direction(view_normal);
  if (const dvec3 sideways = from - glm::dot(from, view_normal) * view_normal;
      lift > 0 && glm::length(sideways) > 1e-6)
    from = glm::normalize(view_normal + 1.2 * glm::normalize(sideways));
  picture.show_still(run.engine().version(), run.engine().overlays(), middle, from, 0.8, 0.5);
  return view::write_png(surface.value()->window(), path);
}

/// Joins the pieces, at their original positions, into one mesh.
volume::Mesh mesh_of(const std::vector<sim::Body>& bodies) {
  std::size_t vertices = 0, corners = 0;
  for (const sim::Body& body : bodies)
    vertices += body.piece->tree->vertices().size(), corners += body.piece->tree->triangles().size();
  volume::Mesh mesh{Buffer<glm::vec3>(vertices), Buffer<std::uint32_t>(corners)};
  std::size_t v = 0, c = 0;
  for (const sim::Body& body : bodies) {
    const auto first = static_cast<std::uint32_t>(v);
    for (const dvec3& p : body.piece->tree->vertices()) mesh.vertices[v++] = glm::vec3(p);
    for (const std::uint32_t corner : body.piece->tree->triangles()) mesh.triangles[c++] = first + corner;
  }
  return mesh;
}

/// Adds the report of the flap to the outcome. Returns an error if the label of the target has no voxels.
Status report_flap(const sim::Engine& engine, Outcome& outcome) {
  Json& json = outcome.json;
  const auto& cut = *last_event<bone_flap::FlapCut>(engine);
  const auto& flap = *engine.state().undoable_of<bone_flap::FlapState>();
  json["area_mm2"] = cut.area;
  json["kerf_mm3"] = cut.kerf_size;
  json["rim_mm3"] = cut.rim_size;
  json["walls_mm2"] = cut.wall;
  json["flap_mm3"] = cut.flap_size;
  json["holes"] = cut.holes;
  json["middle_world_mm"] = json_of(flap.centre);
  json["apex_world_mm"] = json_of(flap.apex);
  outcome.print(
      "flap of {area_cm2:.1f} cm², {flap_mm3:.0f} mm³; the saw removed {kerf_mm3:.0f} mm³ along "
      "{walls_mm2:.0f} mm² of walls",
      {{"area_cm2", cut.area / 100}});
  json["pieces"] = Json::array();
  const sim::Chronicle& chronicle = engine.state().chronicle;
  for (std::size_t i = 0; i < chronicle.size(); ++i) {
    const auto* piece = chronicle[i].value.as<FlapPiece>();
    if (piece == nullptr) continue;
    json["pieces"].push_back({{"number", piece->number},
                              {"mm3", piece->size},
                              {"position_world_mm", json_of(chronicle[i].position_world)},
                              {"is_seed", piece->is_seed},
                              {"is_detached", piece->is_detached},
                              {"is_at_border", piece->is_at_border}});
    if (cut.pieces > 1 || piece->is_at_border)
      outcome.print(std::string("  piece {number}: {mm3:.0f} mm³, ") +
                        (piece->is_detached ? "removed" : "left") +
                        (piece->is_at_border ? ", cut by the scan's border" : ""),
                    json["pieces"].back());
  }
  const auto& judged = *last_event<bone_flap::FlapJudged>(engine);
  json["outline"] = {{"perimeter_mm", judged.perimeter},
                     {"length_mm", judged.length},
                     {"width_mm", judged.width},
                     {"roundness", judged.roundness}};
  outcome.print(
      "outline: {perimeter_mm:.0f} mm around, {length_mm:.0f} by {width_mm:.0f} mm, roundness "
      "{roundness:.2f}",
      json["outline"]);
  json["forbidden"] = Json::array();
  for (std::size_t i = 0; i < chronicle.size(); ++i) {
    const auto* clearance = chronicle[i].value.as<bone_flap::FlapClearance>();
    if (clearance == nullptr) continue;
    json["forbidden"].push_back({{"structure", clearance->structure},
                                 {"nearest_mm", clearance->distance},
                                 {"is_stripped", clearance->is_stripped}});
    const Json row = {{"name", workbench::words_of(clearance->structure)},
                      {"mm", std::abs(clearance->distance)}};
    if (clearance->is_stripped)
      outcome.print("the saw's foot strips {name} off the bone", row);
    else if (clearance->distance < 0)
      outcome.print("the saw goes {mm:.1f} mm into {name}", row);
    else if (clearance->distance < sim::Forbidden::k_reach)
      outcome.print("the saw stays {mm:.1f} mm from {name}", row);
  }
  if (engine.forbidden().empty())
    outcome.print("the plan has no forbidden structures: no distance was checked");
  if (!judged.target.empty()) {
    if (!judged.has_target)
      return Error{.what = "the label has no voxels",
                   .where = "target",
                   .found = judged.target,
                   .expected = "a label that is in the scan"};
    json["target"] = {{"name", judged.target},
                      {"covered_share", judged.exposed / 100},
                      {"margin_mm", judged.margin},
                      {"depth_mm", judged.depth}};
    outcome.print(
        "{name}: {covered_share:.1%} of its projection under the opening, margin {margin_mm:.1f} mm, "
        "{depth_mm:.0f} mm deep",
        json["target"]);
  }
  if (judged.has_plan) {
    json["planned"] = {{"mean_mm", judged.plan_mean}, {"worst_mm", judged.plan_worst}};
    outcome.print("distance from the planned outline: mean {mean_mm:.1f} mm, largest {worst_mm:.1f} mm",
                  json["planned"]);
  }
  return std::nullopt;
}

Status check(const FlapArguments& a) {
  const int outline_count = !a.anchors.empty() + !a.landmarks.empty() + !a.at.empty();
  if (outline_count != 1)
    return Error{.what = outline_count == 0 ? "no outline given" : "more than one outline given",
                 .expected = "one of --anchors, --landmarks, --at"};
  if (!(a.diameter >= 10 && a.diameter <= 200))
    return Error{.what = "the diameter of the flap is out of range",
                 .where = "diameter",
                 .found = text_of(a.diameter),
                 .expected = "10 to 200 mm"};
  if (a.corners < 3 || a.corners > 100)
    return Error{.what = "the number of corners is out of range",
                 .where = "corners",
                 .found = std::to_string(a.corners),
                 .expected = "3 to 100"};
  if (!(a.lift >= 0 && a.lift <= 500))
    return Error{.what = "the lift is out of range",
                 .where = "lift",
                 .found = text_of(a.lift),
                 .expected = "0 to 500 mm"};
  return std::nullopt;
}

Result<Outcome> run_flap(const FlapArguments& arguments) {
  if (Status error = check(arguments)) return *error;
  data_tools::OutputSet outputs;
  for (const std::string& input :
       {arguments.source.path, arguments.anchors, arguments.planned, arguments.record.file})
    outputs.add_input(input);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::volume);
  outputs.add_output("flap", arguments.flap, data_tools::OutputKind::mesh);
  outputs.add_output("screenshot", arguments.screenshot, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  if (Status error = check(arguments.record)) return *error;
  CutFlap request = arguments.request;
  for (const std::string& number : arguments.leave) {
    std::uint32_t n = 0;
    const char* end = number.data() + number.size();
    if (std::from_chars(number.data(), end, n).ptr != end || n < 1 || n > 1000)
      return Error{.what = "invalid number of a piece",
                   .where = "leave",
                   .found = number,
                   .expected = "1 for the largest, 2, ..."};
    request.leave.push_back({n});
  }
  if (!arguments.seed.empty()) {
    const auto seed = parse_point(arguments.seed, "--inside");
    if (!seed) return seed.error();
    request.seed.push_back(seed.value());
  }
  if (Status error = sim::Value(request).check()) return *error;
  workbench::OperationChoice choice;
  choice.procedure_use = workbench::ProcedureUse::ignored;
  choice.shape = arguments.shape;
  choice.cuts_by_command = true;
  choice.smallest_burr = arguments.smallest_burr.value_or(burr_for(request));
  workbench::SourceChoice scan = arguments.source;
  scan.uses_plan = true;
  auto opened = workbench::open_operation(scan, choice, terminal_listener());
  if (!opened) return opened.error();
  if (is_interrupted()) return interrupted("the flap");
  const workbench::Operation& operation = opened.value();
  if (!arguments.target.empty() && operation.source.volume->label_value(arguments.target) <= 0)
    return Error{.what = "unknown label",
                 .where = "target",
                 .found = arguments.target,
                 .expected = "a label of the scan"};
  auto anchors = anchors_of(arguments, operation);
  if (!anchors) return anchors.error();
  request.anchors = std::move(anchors).value();
  Points planned;
  if (!arguments.planned.empty()) {
    FlapArguments plan_arguments;
    plan_arguments.anchors = arguments.planned;
    auto read = anchors_of(plan_arguments, operation);
    if (!read) return read.error();
    planned = std::move(read).value();
  }
  auto recorder = workbench::start_recording(arguments.record, operation);
  if (!recorder) return recorder.error();
  sim::Lockstep run(operation.engine(), operation.spec.force, operation.spec.rate_hz, recorder.value().get());

  const auto begin = Clock::now();
  {
    ProgressLine progress("sawing");
    progress(0);
    const sim::Outcome result = run.apply_and_finish({request, 0});
    if (result.refused) return *result.refused;
    if (last_event<bone_flap::FlapCut>(run.engine()) != nullptr)
      if (const sim::Outcome judged =
              run.apply_and_finish({bone_flap::JudgeFlap{arguments.target, "", planned}, 0});
          judged.refused)
        return *judged.refused;
  }
  if (is_interrupted())
    return interrupted("the flap", recorder.value() && !recorder.value()->finish(run.engine()));
  const double seconds = seconds_since(begin);
  if (arguments.lift > 0 && !run.engine().state().undoable.bodies.empty()) {
    const dvec3 up = arguments.lift * run.engine().state().undoable_of<bone_flap::FlapState>()->normal;
    const std::vector<sim::Body> bodies = run.engine().state().undoable.bodies;
    for (const sim::Body& body : bodies) run.apply({sim::PlaceBody{body.id, up}, 0});
  }
  const Status not_recorded = recorder.value() ? recorder.value()->finish(run.engine()) : std::nullopt;
  Outcome outcome("flap");
  Json& json = outcome.json;
  json["source"] = name_in_report(operation.source);
  json["shape"] =
      volume::describe(operation.scene()->items[0].field.shape(), operation.source.volume->is_hounsfield);
  json["saw_mm"] = bone_flap::width_of(request.saw);
  json["anchors_world_mm"] = Json::array();
  for (const dvec3& p : request.anchors) json["anchors_world_mm"].push_back(json_of(p));
  const sim::Engine& engine = run.engine();
  const std::vector<sim::Body> pieces = engine.state().undoable.bodies;
  dvec3 middle(0), normal(0);
  if (dvec3 at; const auto* no_flap = last_event<bone_flap::FlapFailed>(engine, &at)) {
    json["refused"] = {
        {"reason", no_flap->reason}, {"position_world_mm", json_of(at)}, {"holes", no_flap->holes}};
    outcome.print("no flap: {reason}, at {position_world_mm:.1f}; nothing was cut", json["refused"]);
    outcome.exit_code = exit_check_failed;
    for (const dvec3& p : request.anchors) middle += p / static_cast<double>(request.anchors.size());
  } else if (pieces.empty()) {
    const auto* discarded = last_event<sim::JobDiscarded>(engine);
    return Error{.what = "the flap cannot be detached",
                 .found = discarded ? discarded->reason : "no piece became free",
                 .remedy = "choose another outline, or lower the least volume of a piece (--smallest)"};
  } else {
    const auto& flap = *engine.state().undoable_of<bone_flap::FlapState>();
    middle = flap.centre, normal = flap.normal;
    if (Status error = report_flap(engine, outcome)) return *error;
  }
  json["seconds"] = seconds;
  json["content_hash"] = hash_text(engine.version()->content_hash());
  json["memory"] = memory_report(*operation.scene(), *engine.version());

  if (outcome.exit_code == exit_done) {
    notify_resampled(*operation.source.volume, arguments.output);
    outputs.write(arguments.output,
                  [&] { return data_tools::write_operated(arguments.output, *engine.version()); });
    outputs.write(arguments.flap,
                  [&] { return data_tools::write_mesh(arguments.flap, mesh_of(pieces), volume::Frame()); });
  }
  outputs.write(arguments.screenshot,
                [&] { return draw(run, operation, middle, normal, arguments.lift, arguments.screenshot); });
  outputs.add_recording_status(not_recorded);
  return finished(outputs, std::move(outcome));
}

Run build_flap(Options& options) {
  auto a = std::make_shared<FlapArguments>();
  const auto add = [&](std::string_view field, const char* names) {
    return add_field(options, CutFlap::schema(), &a->request, field, names);
  };
  add_source(options, a->source).required();
  add_shape(options, a->shape);
  options
      .add("--anchors", a->anchors,
           "Points around the flap on the skull, in their order: .mrk.json, .fcsv, or .csv with name,x,y,z")
      .type("FILE");
  options.add("--landmarks", a->landmarks, "Prefix of the case's landmarks to use as points").type("NAME");
  options.add("--at", a->at, "A position on the skull, mm (LPS): the outline is a ring around it")
      .type("X,Y,Z");
  options.add("--diameter", a->diameter, "Diameter of the ring (10 to 200 mm)").type("MM").shows_default();
  options.add("--corners", a->corners, "Corners of the ring (3 to 100)").shows_default();
  add("saw", "--saw");
  add("distance", "--distance").type("MM").shows_default().means("cut-flap distance");
  options.add("--inside", a->seed, "A position on the flap, if the outline's centre is not on it")
      .type("X,Y,Z");
  options.add("--leave", a->leave, "Pieces that stay, by their numbers: 1 is the largest").type("N");
  add("smoothing", "--smoothing").type("MM");
  add("smallest", "--smallest").type("MM3").shows_default();
  add("hole", "--hole").type("MM").shows_default();
  add("space", "--space").type("MM").shows_default();
  add("thickest", "--thickest").type("MM").shows_default();
  options.add("--target", a->target, "A label that the flap should uncover: reports share, margin and depth")
      .type("LABEL");
  options.add("--planned", a->planned, "A planned outline, as --anchors: reports the flap's distance from it")
      .type("FILE");
  options
      .add("--smallest-burr", a->smallest_burr,
           "Smallest burr that will cut in this session, mm: the smaller, the finer cuts are sampled "
           "(default: as fine as the saw requires)")
      .type("MM");
  options.add("--lift", a->lift, "Lift the pieces by this distance, mm, for the picture and the session")
      .type("MM");
  options.add(
      "-o,--output", a->output,
      "Write the scan without the flap: " + data_tools::extensions_of(data_tools::OutputKind::volume));
  options.add("--flap", a->flap, "The pieces: " + data_tools::extensions_of(data_tools::OutputKind::mesh))
      .type("MESH");
  options.add("--screenshot", a->screenshot, "A picture of the flap, or of the problem if there is no flap")
      .type("PNG");
  add_record(options, a->record);
  return run_with(a, run_flap);
}

}  // namespace

const Command k_flap{
    "flap", "Cut a bone flap along an outline, and judge it",
    "  trephine flap head --at 0,-60,60 --diameter 40 --lift 30 --screenshot flap.png\n"
    "  trephine flap SCANS/HEAD --anchors outline.mrk.json -o open.mha --flap flap.stl --json\n"
    "  trephine flap head-case --at -48.7,20,48.7 --diameter 50 --target tumour --record flap.session",
    build_flap};

}  // namespace trephine::cli
