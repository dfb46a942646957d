#include "modules/bone_flap/judgement.h"

#include <algorithm>

#include "modules/bone_flap/evaluation.h"
#include "modules/bone_flap/freehand.h"
#include "sim/api/work.h"

namespace trephine::bone_flap {

using glm::dvec3;
using sim::field;

namespace {

struct JudgeResult final : sim::JobResult {
  FlapJudged judged;
  dvec3 at{0.0};
  std::vector<StructureClearance> clearances;

  std::uint64_t hash() const override {
    MixHash mix;
    sim::add_value(mix, judged);
    for (const StructureClearance& clearance : clearances) {
      sim::add_bytes(mix, clearance.structure);
      mix.add(clearance.mm), mix.add(clearance.resolved);
    }
    return mix.value();
  }
};

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const JudgeFlap*>(parameters);
  const FlapState flap = current_flap(input.state).value_or(FlapState());
  auto output = std::make_shared<JudgeResult>();
  FlapJudged& judged = output->judged;
  judged.flap = flap.flaps, judged.area = flap.area;
  output->at = flap.centre;
  const OutlineShape shape = shape_of(flap);
  judged.perimeter = shape.perimeter, judged.roundness = shape.roundness;
  judged.length = shape.length, judged.width = shape.width;
  const volume::Volume& scan = *input.anatomy.base;
  const volume::SurgicalPlan* plan = input.state.plan.get();
  std::string target = request.target;
  if (target.empty() && plan && !plan->targets.empty()) target = plan->targets.front().label;
  if (!target.empty() && !scan.labels.is_empty() && scan.label_value(target) > 0) {
    const LabelExposure exposure = exposure_of(flap, scan, scan.label_value(target));
    judged.target = target;
    judged.has_target = exposure.has_label;
    judged.exposed = 100 * exposure.share, judged.margin = exposure.margin, judged.depth = exposure.depth;
  }
  const volume::PlannedOutline* outline = find_outline(input.state, request.outline);
  std::optional<OutlineDistance> distance;
  if (outline)
    distance = distance_from_plan(flap, outline->points_world);
  else if (!request.planned.empty())
    distance = distance_from_plan(flap, request.planned);
  else if (plan)
    distance = distance_from_nearest(flap, *plan);
  if (flap.outline.empty()) distance.reset();  // a piece that is no plate
  judged.has_plan = distance.has_value();
  if (distance) judged.plan_mean = distance->mean, judged.plan_worst = distance->worst;
  output->clearances = clearances_of(flap, input.forbidden);
  return output;
}

/// Returns true if the judged flap is still the last flap, and unchanged.
bool is_current(const void*, const sim::OperationState& input, const sim::OperationState& current) {
  const sim::Body *judged_piece = freehand_piece(input), *piece = freehand_piece(current);
  if (judged_piece != nullptr || piece != nullptr)
    return judged_piece != nullptr && piece != nullptr && judged_piece->piece->hash == piece->piece->hash;
  const FlapState &judged = *input.undoable_of<FlapState>(), &now = *current.undoable_of<FlapState>();
  return judged.flaps == now.flaps && judged.outline == now.outline;
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& output = static_cast<const JudgeResult&>(result);
  work.raise_event(output.judged, output.at);
  for (const StructureClearance& clearance : output.clearances)
    work.raise_event(FlapClearance{clearance.structure, clearance.mm, clearance.is_stripped()},
                     clearance.at_world);
}

Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  const auto& request = *static_cast<const JudgeFlap*>(parameters);
  if (request.target.empty() ||
      (!anatomy.base->labels.is_empty() && anatomy.base->label_value(request.target) > 0))
    return std::nullopt;
  std::string known;  // the background is no target
  for (std::size_t i = 1; i < anatomy.base->label_names.size(); ++i)
    known += (i > 1 ? ", " : "") + anatomy.base->label_names[i];
  return Error{.what = "unknown label",
               .where = "judge-flap target",
               .found = request.target,
               .expected = known.empty() ? "a scan with labels" : known,
               .remedy = known.empty() ? "add labels to the scan" : "choose one of these"};
}

}  // namespace

const volume::PlannedOutline* find_outline(const sim::OperationState& operation, const std::string& name) {
  if (!operation.plan) return nullptr;
  const auto& outlines = operation.plan->outlines;
  const auto found = std::find_if(outlines.begin(), outlines.end(),
                                  [&](const volume::PlannedOutline& o) { return o.name == name; });
  return found == outlines.end() ? nullptr : &*found;
}

Status check_outline(const char* where, const std::string& name, const sim::OperationState& operation) {
  if (name.empty() || find_outline(operation, name) != nullptr) return std::nullopt;
  std::string known;
  if (operation.plan)
    for (const volume::PlannedOutline& outline : operation.plan->outlines)
      known += (known.empty() ? "" : ", ") + outline.name;
  return Error{.what = "unknown outline",
               .where = where,
               .found = name,
               .expected = known.empty() ? "a plan with outlines" : known,
               .remedy = known.empty() ? "add an outline to the plan" : "choose one of these"};
}

Status check_judging(const JudgeFlap& request, const sim::OperationState& operation) {
  const FlapState* flap = operation.undoable_of<FlapState>();
  if ((flap == nullptr || flap->flaps == 0) && freehand_piece(operation) == nullptr)
    return Error{.what = "there is no bone flap to judge",
                 .where = "judge-flap",
                 .remedy = "cut the flap first, with the craniotome or along the outline (cut-flap)"};
  if (!request.outline.empty() && !request.planned.empty())
    return Error{.what = "two planned outlines are given",
                 .where = "judge-flap",
                 .found = "outline and planned",
                 .expected = "at most one of them",
                 .remedy = "omit outline or planned"};
  constexpr std::size_t k_least = 3;
  if (!request.planned.empty() && request.planned.size() < k_least)
    return Error{.what = "the planned outline has too few points",
                 .where = "judge-flap planned",
                 .found = std::to_string(request.planned.size()),
                 .expected = "at least three"};
  return check_outline("judge-flap outline", request.outline, operation);
}

const FlapJudged* judgement_of(const sim::OperationState& operation) {
  const FlapState* flap = operation.undoable_of<FlapState>();
  const sim::Body* piece = freehand_piece(operation);
  if (piece == nullptr && (flap == nullptr || flap->flaps == 0)) return nullptr;
  for (std::size_t i = operation.chronicle.size(); i-- > 0;) {
    const sim::Event& event = operation.chronicle[i];
    const auto* judged = event.value.as<FlapJudged>();
    if (judged == nullptr) continue;
    const bool is_of_flap = piece != nullptr
                                ? judged->flap == 0 && event.position_world == piece->piece->middle_world
                                : judged->flap == flap->flaps && judged->area == flap->area &&
                                      event.position_world == flap->centre;
    return is_of_flap ? judged : nullptr;
  }
  return nullptr;
}

const sim::JobType& judge_job() {
  static const sim::JobType job{&sim::value_type<JudgeFlap>(), run, is_current, adopt, check};
  return job;
}

const sim::Schema& JudgeFlap::schema() {
  static constexpr sim::Field fields[] = {
      field<&JudgeFlap::target>(
          "target", {.help = "label that the flap should expose; without it the first target of the plan",
                     .names = sim::FieldInfo::Names::label,
                     .empty_choice = "Target of the plan"}),
      field<&JudgeFlap::outline>("outline", {.help = "outline of the plan; without it the nearest one",
                                             .names = sim::FieldInfo::Names::outline,
                                             .empty_choice = "Nearest outline"}),
      field<&JudgeFlap::planned>("planned",
                                 {.unit = "mm",
                                  .low = -1e5,
                                  .high = 1e5,
                                  .help = "points of a planned outline, in order, instead of its name",
                                  .is_expert = true})};
  static constexpr sim::Schema table{"judge-flap", 1, fields};
  return table;
}

const sim::Schema& FlapJudged::schema() {
  static constexpr sim::Field fields[] = {
      field<&FlapJudged::flap>("flap", {.help = "number of the flap"}),
      field<&FlapJudged::area>("area", {.unit = "mm2", .help = "of the outer surface"}),
      field<&FlapJudged::perimeter>("perimeter", {.unit = "mm"}),
      field<&FlapJudged::length>("length", {.unit = "mm"}),
      field<&FlapJudged::width>("width", {.unit = "mm"}),
      field<&FlapJudged::roundness>("roundness", {.help = "1 for a circle"}),
      field<&FlapJudged::target>("target"),
      field<&FlapJudged::has_target>("has_target"),
      field<&FlapJudged::exposed>(
          "exposed", {.unit = "%", .help = "share of the target's projection inside the opening"}),
      field<&FlapJudged::margin>(
          "margin",
          {.unit = "mm", .help = "distance of the target from the edge of the opening; negative: outside"}),
      field<&FlapJudged::depth>("depth",
                                {.unit = "mm", .help = "of the target below the plane of the outline"}),
      field<&FlapJudged::has_plan>("has_plan"),
      field<&FlapJudged::plan_mean>("plan_mean",
                                    {.unit = "mm", .help = "mean distance from the planned outline"}),
      field<&FlapJudged::plan_worst>("plan_worst", {.unit = "mm"})};
  static constexpr sim::Schema table{"flap-judged", 1, fields};
  return table;
}

const sim::Schema& FlapClearance::schema() {
  static constexpr sim::Field fields[] = {
      field<&FlapClearance::structure>("structure"),
      field<&FlapClearance::distance>("distance", {.unit = "mm", .help = "negative: cut"}),
      field<&FlapClearance::is_stripped>("stripped")};
  static constexpr sim::Schema table{"flap-clearance", 1, fields};
  return table;
}

}  // namespace trephine::bone_flap
