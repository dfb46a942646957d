// Findings of a bone flap. docs/scores.md has the limits and their sources.
#include <algorithm>

#include "modules/bone_flap/evaluation.h"
#include "modules/bone_flap/freehand.h"
#include "modules/bone_flap/judgement.h"

namespace trephine::bone_flap {

namespace {

using sim::Finding;

/// Returns the tick at which the current flap was cut.
std::optional<std::uint64_t> tick_of(const FlapState& flap, const sim::Chronicle& chronicle) {
  for (std::size_t i = chronicle.size(); i-- > 0;)
    if (chronicle[i].value.as<FlapCut>() && chronicle[i].position_world == flap.centre)
      return chronicle[i].tick;
  return std::nullopt;
}

/// Compares the flap with the planned outline that is nearest to it.
void add_plan(const FlapState& flap, const volume::SurgicalPlan* plan, std::vector<Finding>& findings) {
  Finding mean{.name = "flap: distance from plan", .unit = "mm", .full_at = 2, .zero_at = 10, .weight = 3};
  Finding worst{.name = "flap: largest distance from plan", .unit = "mm"};
  const auto distance = plan ? distance_from_nearest(flap, *plan) : std::nullopt;
  if (!distance) {
    mean.reason = "The plan has no outline; add one.";
    findings.push_back(std::move(mean));
    return;
  }
  mean.value = distance->mean, worst.value = distance->worst;
  findings.push_back(std::move(mean)), findings.push_back(std::move(worst));
}

/// Judges the exposure of each target of the plan.
void add_targets(const FlapState& flap, const volume::Volume& scan, const volume::SurgicalPlan* plan,
                 std::vector<Finding>& findings) {
  const auto add = [&](const std::string& target, const LabelExposure* exposure, const std::string& reason) {
    Finding share{.name = "flap: exposed part of " + target,
                  .unit = "%",
                  .reason = reason,
                  .full_at = 100,
                  .zero_at = 80,
                  .weight = 4};
    Finding margin{.name = "flap: margin around " + target,
                   .unit = "mm",
                   .reason = reason,
                   .full_at = 5,
                   .zero_at = 0,
                   .weight = 2};
    if (exposure) share.value = 100 * exposure->share, margin.value = exposure->margin;
    findings.push_back(std::move(share)), findings.push_back(std::move(margin));
  };
  if (plan == nullptr || plan->targets.empty())
    return add("the target", nullptr, "The plan has no target; add one that names a label of the scan.");
  for (const volume::PlannedTarget& target : plan->targets) {
    const int label = scan.labels.is_empty() ? -1 : scan.label_value(target.label);
    const LabelExposure exposure = label > 0 ? exposure_of(flap, scan, label) : LabelExposure();
    if (exposure.has_label)
      add(target.name, &exposure, "");
    else
      add(target.name, nullptr, "The scan lacks the label of this target; add the label.");
  }
}

}  // namespace

std::vector<Finding> BoneFlap::findings(const sim::JobInput& input) const {
  const std::optional<FlapState> flap = current_flap(input.state);
  if (!flap) return {};
  std::vector<Finding> findings;
  const volume::SurgicalPlan* plan = input.state.plan.get();
  // Other operations detach bone as well. A piece is a flap if one was planned, or if the user judged it.
  const bool is_planned = plan != nullptr && !(plan->outlines.empty() && plan->targets.empty());
  if (flap->flaps == 0 && !is_planned && judgement_of(input.state) == nullptr) return {};
  add_targets(*flap, *input.anatomy.base, plan, findings);
  add_plan(*flap, plan, findings);
  const OutlineShape shape = shape_of(*flap);
  findings.push_back({.name = "flap: area", .value = flap->area, .unit = "mm2"});
  findings.push_back({.name = "flap: roundness", .value = shape.roundness});
  for (Finding& one : findings)
    one.tick = tick_of(*flap, input.state.chronicle), one.position_world = flap->centre;
  // Depth of the saw in structures that must not be cut. A membrane that the foot strips is not cut.
  for (const StructureClearance& clearance : clearances_of(*flap, input.forbidden))
    findings.push_back(
        {.name = "flap: saw in " + clearance.structure,
         .value = clearance.mm >= 0 || clearance.is_stripped() ? 0.0 : -clearance.mm,
         .unit = "mm",
         .reason = clearance.is_stripped() ? "The foot of the saw strips it off the bone." : "",
         .tick = tick_of(*flap, input.state.chronicle),
         .position_world = clearance.at_world,
         .full_at = 0,
         .zero_at = 2,
         .weight = 4});
  return findings;
}

}  // namespace trephine::bone_flap
