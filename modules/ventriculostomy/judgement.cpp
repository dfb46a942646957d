#include "modules/ventriculostomy/judgement.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "modules/ventriculostomy/catheter_in_place.h"
#include "sim/api/work.h"
#include "volume/base/deterministic_math.h"
#include "volume/scan/solid_runs.h"

namespace trephine::ventriculostomy {

using glm::dvec3;
using sim::field;
using volume::PlannedTrajectory;

namespace {

constexpr double k_outside = 40;  // mm; the search for bone starts this far before the start of the path
constexpr double k_step = 0.05;   // mm between positions of the path
constexpr const char* k_group = "ventriculostomy";

double degrees(double radians) noexcept { return radians * 57.295779513082320877; }
/// Returns the angle between two unit vectors, degrees.
double angle_between(const dvec3& a, const dvec3& b) noexcept {
  return degrees(deterministic_acos(std::clamp(glm::dot(a, b), -1.0, 1.0)));
}

const PlannedTrajectory* find_trajectory(const sim::OperationState& operation, const std::string& name) {
  if (!operation.plan) return nullptr;
  for (const PlannedTrajectory& one : operation.plan->trajectories)
    if (one.name == name) return &one;
  return nullptr;
}
/// Returns the trajectory of the group ventriculostomy whose entry is nearest to `entry`; null if the plan
/// has no trajectory of this group. Targets are not compared, since a tip beyond the midline may be nearer to
/// the target of the other side.
const PlannedTrajectory* nearest_trajectory(const sim::OperationState& operation, const dvec3& entry) {
  const PlannedTrajectory* best = nullptr;
  if (!operation.plan) return best;
  for (const PlannedTrajectory& one : operation.plan->trajectories)
    if (one.group == k_group &&
        (!best || glm::distance(one.entry_world, entry) < glm::distance(best->entry_world, entry)))
      best = &one;
  return best;
}

struct JudgeResult final : sim::JobResult {
  CatheterJudgement judgement;

  std::uint64_t hash() const override {
    MixHash mix;
    sim::add_value(mix, judgement.judged);
    for (const Crossing& one : judgement.crossings) {
      sim::add_bytes(mix, one.structure);
      mix.add(one.length), mix.add(one.is_forbidden ? 1.0 : 0.0);
      mix.add(one.at_world.x), mix.add(one.at_world.y), mix.add(one.at_world.z);
    }
    for (const Clearance& one : judgement.clearances) {
      sim::add_bytes(mix, one.structure);
      mix.add(one.distance), mix.add(one.length);
    }
    return mix.value();
  }
};

/// Returns the diameter of the first catheter that a hand holds, mm; the default diameter if no hand holds a
/// catheter.
double held_diameter(const sim::OperationState& operation) {
  for (const sim::Instrument& hand : operation.settings.hands)
    if (const auto* held = hand.parameters.as<Catheter>()) return held->diameter;
  return Catheter().diameter;
}

/// Adds a crossing for each label on the path, with the length of the path in the label and the first
/// position there. Sets the length in ventricles and the depth from the dura.
void follow_labels(const volume::Volume& scan, const Layers& layers, const dvec3& from, const dvec3& ahead,
                   double length, CatheterJudgement& output) {
  const auto count = static_cast<int>(length / k_step);
  for (int i = 0; i < count; ++i) {
    const double along = (i + 0.5) * k_step;
    const dvec3 at = from + along * ahead;
    const int label = label_at(scan, at);
    if (label <= 0) continue;
    const std::string name = name_of_label(scan, label);
    auto found = std::find_if(output.crossings.begin(), output.crossings.end(),
                              [&](const Crossing& one) { return one.structure == name; });
    if (found == output.crossings.end()) found = output.crossings.insert(found, {name, 0, false, at});
    found->length += k_step;
    CatheterJudged& judged = output.judged;
    if (label == layers.ventricle || label == layers.other_ventricle) judged.in_ventricle += k_step;
    if (label == layers.dura && !judged.has_dura)
      judged.has_dura = true, judged.depth_from_dura = length - along;
  }
}

/// Returns the length of the part of a catheter whose wall is in a structure, mm.
double length_in(const sim::Forbidden& forbidden, const CatheterJudged& judged, double radius) {
  constexpr double k_between = 0.25;  // mm
  const double length = glm::distance(judged.entry, judged.tip);
  const int count = std::max(1, static_cast<int>(length / k_between));
  double inside = 0, clearance = sim::Forbidden::k_reach;
  for (int i = 0; i < count; ++i) {
    const dvec3 at = glm::mix(judged.entry, judged.tip, (i + 0.5) / count);
    clearance = forbidden.clearance(sim::ToolBall{at, radius, false}, clearance);
    if (clearance < 0) inside += length / count;
  }
  return inside;
}

/// Measures the distance of the catheter's wall to each forbidden structure, except the layers that a
/// catheter has to pass. Marks the crossings of the path with forbidden labels.
void find_clearance(const sim::JobInput& input, const Layers& layers, double radius,
                    CatheterJudgement& output) {
  CatheterJudged& judged = output.judged;
  judged.clearance = sim::Forbidden::k_reach;
  for (const auto& forbidden : input.forbidden) {
    const volume::Shape* shape = forbidden->shape();
    if (shape != nullptr && layers.is_layer(shape->label)) continue;
    const double clearance = forbidden->clearance(judged.entry, sim::ToolBall{judged.tip, radius, false});
    const double inside = clearance < 0 ? length_in(*forbidden, judged, radius) : 0;
    output.clearances.push_back({forbidden->name(), clearance, inside});
    if (clearance < judged.clearance) judged.clearance = clearance, judged.nearest = forbidden->name();
    if (shape == nullptr || shape->label < 0) continue;
    const std::string name = name_of_label(*input.anatomy.base, shape->label);
    for (Crossing& one : output.crossings) one.is_forbidden = one.is_forbidden || one.structure == name;
  }
}

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  auto output = std::make_shared<JudgeResult>();
  output->judgement = judge(*static_cast<const JudgeCatheter*>(parameters), input);
  return output;
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const CatheterJudgement& output = static_cast<const JudgeResult&>(result).judgement;
  work.change_result<CatheterJudged>() = output.judged;
  work.raise_event(output.judged, output.judged.tip);
  for (const Crossing& one : output.crossings)
    work.raise_event(CatheterCrossed{one.structure, one.length, one.is_forbidden}, one.at_world);
  for (const Clearance& one : output.clearances)
    work.raise_event(CatheterClearance{one.structure, one.distance, one.length}, output.judged.tip);
}

Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  const auto& request = *static_cast<const JudgeCatheter*>(parameters);
  if (request.item < 0 || static_cast<std::size_t>(request.item) >= anatomy.items.size() ||
      anatomy.items[static_cast<std::size_t>(request.item)].is_mesh())
    return Error{.what = "unknown shape",
                 .where = "judge-catheter item",
                 .found = std::to_string(request.item),
                 .expected = "a shape of the anatomy",
                 .remedy = "pass the number of a touchable shape, 0 for the first"};
  if (anatomy.base->labels.is_empty())
    return Error{.what = "the scan has no labels",
                 .where = "judge-catheter",
                 .expected = "labels of dura, brain and ventricles",
                 .remedy = "import the scan with labels of ventricles, dura and brain"};
  return std::nullopt;
}

}  // namespace

CatheterJudgement judge(const JudgeCatheter& request, const sim::JobInput& input) {
  const volume::Volume& scan = *input.anatomy.base;
  const volume::Field& bone = input.anatomy.items[static_cast<std::size_t>(request.item)].field;
  const Layers layers = layers_of(scan);
  const CatheterPath path = request.at.empty()
                                ? newest_path(input.state).value()
                                : CatheterPath{request.at[0], request.at[1], held_diameter(input.state)};
  CatheterJudgement output;
  CatheterJudged& judged = output.judged;
  judged.has_value = true;
  judged.tip = path.tip, judged.entry = path.start;
  const dvec3 ahead = glm::normalize(path.tip - path.start);
  const double length = glm::length(path.tip - path.start);
  // Find the bone on the path in the uncut scan, that is, before the hole was drilled.
  const auto skull = volume::skull_crossing(bone, path.start - k_outside * ahead, ahead, k_outside + length);
  if (skull) {
    judged.has_table = true, judged.entry = skull->outer_world;
    judged.depth_from_table = glm::distance(skull->outer_world, path.tip);
    judged.angle_to_surface = 90 - angle_between(skull->normal_world, -ahead);
  }
  follow_labels(scan, layers, judged.entry, ahead, glm::distance(judged.entry, judged.tip), output);
  const int label = label_at(scan, judged.tip);
  if (label > 0 && (label == layers.ventricle || label == layers.other_ventricle))
    judged.ventricle = name_of_label(scan, label);
  const PlannedTrajectory* planned = request.trajectory.empty()
                                         ? nearest_trajectory(input.state, judged.entry)
                                         : find_trajectory(input.state, request.trajectory);
  if (planned != nullptr) {
    judged.has_plan = true, judged.trajectory = planned->name;
    judged.entry_error = glm::distance(planned->entry_world, judged.entry);
    judged.target_error = glm::distance(planned->target_world, judged.tip);
    judged.direction_error =
        angle_between(glm::normalize(planned->target_world - planned->entry_world), ahead);
  }
  find_clearance(input, layers, 0.5 * path.diameter, output);
  return output;
}

std::optional<CatheterPath> newest_path(const sim::OperationState& operation) {
  for (std::size_t hand = 0; hand < operation.settings.hands.size(); ++hand)
    if (const CatheterState* state = inserted_catheter(operation, hand); state && state->depth > 0)
      return CatheterPath{state->start, state->tip(),
                          operation.settings.hands[hand].parameters.as<Catheter>()->diameter};
  const auto* passages = operation.persistent_of<CatheterPassages>();
  if (passages == nullptr || passages->starts.empty()) return std::nullopt;
  if (const auto* left = operation.undoable_of<CathetersInPlace>())
    if (const auto i = left->find_start(passages->starts.back()))
      return CatheterPath{left->starts[*i], left->tips[*i], left->diameters[*i]};
  if (glm::distance(passages->starts.back(), passages->tips.back()) < k_step) return std::nullopt;
  return CatheterPath{passages->starts.back(), passages->tips.back(), held_diameter(operation)};
}

Status check_judging(const JudgeCatheter& request, const sim::OperationState& operation) {
  if (!request.at.empty() &&
      (request.at.size() != 2 || !(glm::distance(request.at[0], request.at[1]) > k_step)))
    return Error{.what = "the path does not consist of two different points",
                 .where = "judge-catheter at",
                 .found = request.at.size() == 2 ? "two points at most 0.05 mm apart"
                                                 : std::to_string(request.at.size()) + " points",
                 .expected = "a point before the bone, and the tip",
                 .remedy = "pass two points that differ"};
  if (request.at.empty() && !newest_path(operation))
    return Error{.what = "there is no catheter to judge",
                 .where = "judge-catheter",
                 .remedy = "insert a catheter first, or pass two points (at)"};
  if (request.trajectory.empty() || find_trajectory(operation, request.trajectory)) return std::nullopt;
  std::string known;
  if (operation.plan)
    for (const PlannedTrajectory& one : operation.plan->trajectories)
      known += (known.empty() ? "" : ", ") + one.name;
  return Error{.what = "unknown trajectory",
               .where = "judge-catheter trajectory",
               .found = request.trajectory,
               .expected = known.empty() ? "a plan with trajectories" : known,
               .remedy = "choose a trajectory of the plan, or omit it"};
}

const sim::JobType& judge_job() {
  static const sim::JobType job{&sim::value_type<JudgeCatheter>(), run, nullptr, adopt, check};
  return job;
}

const sim::Schema& JudgeCatheter::schema() {
  static constexpr sim::Field fields[] = {
      field<&JudgeCatheter::trajectory>(
          "trajectory",
          {.help =
               "trajectory of the plan; empty: that planned ventriculostomy whose entry is nearest to the catheter",
           .names = sim::FieldInfo::Names::trajectory,
           .empty_choice = "Nearest planned trajectory"}),
      field<&JudgeCatheter::at>(
          "at", {.unit = "mm",
                 .low = -1e5,
                 .high = 1e5,
                 .help = "two points, before the bone and at the tip; empty: the newest catheter",
                 .most_values = 2,
                 .is_expert = true}),
      field<&JudgeCatheter::item>("item",
                                  {.low = 0, .high = 63, .help = "shape of the bone", .is_expert = true})};
  static constexpr sim::Schema table{"judge-catheter", 1, fields};
  return table;
}

const sim::Schema& CatheterJudged::schema() {
  static constexpr sim::Field fields[] = {
      field<&CatheterJudged::has_value>("has_value"),
      field<&CatheterJudged::has_plan>("has_plan",
                                       {.help = "the path was compared with a trajectory of the plan"}),
      field<&CatheterJudged::trajectory>("trajectory"),
      field<&CatheterJudged::entry_error>("entry_error", {.unit = "mm"}),
      field<&CatheterJudged::target_error>("target_error", {.unit = "mm"}),
      field<&CatheterJudged::direction_error>("direction_error", {.unit = "degrees"}),
      field<&CatheterJudged::has_table>("has_table", {.help = "the path meets the outer table"}),
      field<&CatheterJudged::depth_from_table>("depth_from_table", {.unit = "mm"}),
      field<&CatheterJudged::angle_to_surface>(
          "angle_to_surface", {.unit = "degrees", .help = "angle to the outer table; 90 is perpendicular"}),
      field<&CatheterJudged::has_dura>("has_dura", {.help = "the path meets the dura"}),
      field<&CatheterJudged::depth_from_dura>("depth_from_dura", {.unit = "mm"}),
      field<&CatheterJudged::ventricle>("ventricle",
                                        {.help = "label of the ventricle that contains the tip"}),
      field<&CatheterJudged::in_ventricle>("in_ventricle", {.unit = "mm", .help = "length in ventricles"}),
      field<&CatheterJudged::nearest>(
          "nearest", {.help = "nearest forbidden structure other than dura, brain and ventricles"}),
      field<&CatheterJudged::clearance>(
          "clearance", {.unit = "mm", .help = "distance of the catheter's wall from that structure"}),
      field<&CatheterJudged::entry>("entry", {.unit = "mm"}),
      field<&CatheterJudged::tip>("tip", {.unit = "mm"})};
  static constexpr sim::Schema table{"catheter-judged", 1, fields};
  return table;
}

const sim::Schema& CatheterCrossed::schema() {
  static constexpr sim::Field fields[] = {
      field<&CatheterCrossed::structure>("structure"),
      field<&CatheterCrossed::length>("length",
                                      {.unit = "mm", .help = "length of the path in the structure"}),
      field<&CatheterCrossed::is_forbidden>(
          "forbidden", {.help = "the structure is forbidden, and is not dura, brain or a ventricle"})};
  static constexpr sim::Schema table{"catheter-crossed", 1, fields};
  return table;
}

const sim::Schema& CatheterClearance::schema() {
  static constexpr sim::Field fields[] = {
      field<&CatheterClearance::structure>("structure"),
      field<&CatheterClearance::distance>(
          "distance", {.unit = "mm", .help = "distance from the catheter's wall; negative: depth"}),
      field<&CatheterClearance::length>("length",
                                        {.unit = "mm", .help = "length of the catheter in the structure"})};
  static constexpr sim::Schema table{"catheter-clearance", 1, fields};
  return table;
}

const sim::Schema& CatheterPassages::schema() {
  static constexpr sim::Field fields[] = {
      field<&CatheterPassages::count>("count"), field<&CatheterPassages::starts>("starts", {.unit = "mm"}),
      field<&CatheterPassages::directions>("directions"),
      field<&CatheterPassages::tips>("tips", {.unit = "mm"}), field<&CatheterPassages::hands>("hands")};
  static constexpr sim::Schema table{"catheter-passages", 1, fields};
  return table;
}

}  // namespace trephine::ventriculostomy
