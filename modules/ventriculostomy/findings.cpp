// Findings of a ventriculostomy. docs/scores.md has the limits and their sources.
#include <algorithm>

#include "modules/ventriculostomy/ventriculostomy.h"

namespace trephine::ventriculostomy {

namespace {

using sim::Finding;

constexpr const char* k_no_plan = "The plan has no trajectory of the group ventriculostomy; add one.";

/// Findings of a catheter with their names and limits. Their values are set later; all() returns them in the
/// order of the score.
struct CatheterFindings {
  Finding target{.name = "catheter: tip to target", .unit = "mm", .full_at = 4, .zero_at = 16, .weight = 4};
  Finding entry{.name = "catheter: entry to plan", .unit = "mm", .full_at = 4, .zero_at = 16, .weight = 2};
  Finding angle{.name = "catheter: angle to plan", .unit = "degrees"};
  Finding grade{.name = "catheter: grade of the tip", .full_at = 1, .zero_at = 3, .weight = 4};
  Finding in_ventricle{.name = "catheter: length in ventricles", .unit = "mm"};
  Finding table{.name = "catheter: depth from outer table", .unit = "mm"};
  Finding dura{.name = "catheter: depth from dura", .unit = "mm"};
  Finding surface{.name = "catheter: angle to outer table", .unit = "degrees"};
  Finding crossed{.name = "catheter: forbidden structures crossed", .full_at = 0, .zero_at = 1, .weight = 4};
  Finding clearance{.name = "catheter: clearance of forbidden structures", .unit = "mm"};

  std::vector<Finding> all() const {
    return {target, entry, angle, grade, in_ventricle, table, dura, surface, crossed, clearance};
  }
};

const volume::PlannedTrajectory* find_trajectory(const volume::SurgicalPlan* plan, const std::string& name) {
  if (plan == nullptr) return nullptr;
  const auto found = std::find_if(plan->trajectories.begin(), plan->trajectories.end(),
                                  [&](const auto& one) { return one.name == name; });
  return found == plan->trajectories.end() ? nullptr : &*found;
}

/// Grades the tip as Kakarla et al. (2008): 1 in the planned ventricle, 2 in the other ventricle, 3
/// elsewhere.
void grade_tip(const CatheterJudged& judged, const volume::Volume& scan, const volume::SurgicalPlan* plan,
               Finding& grade) {
  const Layers layers = layers_of(scan);
  if (layers.ventricle < 0) {
    grade.reason = "The scan has no label of a ventricle; add one.";
    return;
  }
  const auto* planned = find_trajectory(plan, judged.trajectory);
  if (judged.ventricle.empty()) {
    grade.value = 3, grade.reason = "The tip is outside the ventricles.";
    return;
  }
  const int target = planned ? label_at(scan, planned->target_world) : -1;
  if (target <= 0 || (target != layers.ventricle && target != layers.other_ventricle)) {
    grade.reason =
        planned ? "The target of the plan is outside the ventricles; move it into one." : k_no_plan;
    return;
  }
  grade.value = judged.ventricle == name_of_label(scan, target) ? 1 : 2;
  grade.reason = "The tip is in " + judged.ventricle + ".";
}

void compare_with_plan(const CatheterJudged& judged, CatheterFindings& findings) {
  if (!judged.has_plan) {
    findings.target.reason = findings.entry.reason = findings.angle.reason = k_no_plan;
    return;
  }
  findings.target.value = judged.target_error, findings.angle.value = judged.direction_error;
  if (judged.has_table)
    findings.entry.value = judged.entry_error;
  else
    findings.entry.reason = "The path meets no bone.";
}

void set_depths(const CatheterJudged& judged, CatheterFindings& findings) {
  findings.in_ventricle.value = judged.in_ventricle;
  if (judged.has_table)
    findings.table.value = judged.depth_from_table, findings.surface.value = judged.angle_to_surface;
  else
    findings.table.reason = findings.surface.reason = "The path meets no bone.";
  if (judged.has_dura)
    findings.dura.value = judged.depth_from_dura;
  else
    findings.dura.reason = "The path meets no label dura; add the label to the scan.";
}

void count_crossings(const CatheterJudgement& judgement, bool has_forbidden, CatheterFindings& findings) {
  if (!has_forbidden) {
    findings.crossed.reason = findings.clearance.reason =
        "The operation has no forbidden structures; add some to the case.";
    return;
  }
  double count = 0;
  for (const Crossing& one : judgement.crossings) {
    if (!one.is_forbidden) continue;
    ++count;
    findings.crossed.reason += (count > 1 ? ", " : "Crossed: ") + one.structure;
    findings.crossed.position_world = one.at_world;
  }
  if (count > 0) findings.crossed.reason += ".";
  findings.crossed.value = count;
  findings.clearance.value = judgement.judged.clearance;
  if (!judgement.judged.nearest.empty())
    findings.clearance.reason = "Nearest: " + judgement.judged.nearest + ".";
}

}  // namespace

std::vector<Finding> Ventriculostomy::findings(const sim::JobInput& input) const {
  const auto* passages = input.state.persistent_of<CatheterPassages>();
  const auto& items = input.anatomy.items;
  if (passages == nullptr || passages->count == 0 || items.empty() || items[0].is_mesh()) return {};
  const volume::Volume& scan = *input.anatomy.base;
  CatheterFindings findings;
  std::string problem;
  if (scan.labels.is_empty())
    problem = "The scan has no labels; add labels of dura, brain and ventricles.";
  else if (!newest_path(input.state))
    problem = "The catheter did not move in the head.";
  if (problem.empty()) {
    const CatheterJudgement judgement = judge({}, input);
    const CatheterJudged& judged = judgement.judged;
    compare_with_plan(judged, findings);
    grade_tip(judged, scan, input.state.plan.get(), findings.grade);
    set_depths(judged, findings);
    count_crossings(judgement, !input.forbidden.empty(), findings);
    findings.target.position_world = findings.grade.position_world = judged.tip;
    findings.entry.position_world = judged.entry;
  }
  std::vector<Finding> all = findings.all();
  if (!problem.empty())
    for (Finding& one : all) one.reason = problem;
  all.push_back({.name = "catheter: passages",
                 .value = static_cast<double>(passages->count),
                 .full_at = 1,
                 .zero_at = 4,
                 .weight = 2});
  return all;
}

}  // namespace trephine::ventriculostomy
