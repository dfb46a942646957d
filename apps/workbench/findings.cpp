#include "apps/workbench/findings.h"

#include <algorithm>
#include <iterator>
#include <map>

#include "modules/catalogue.h"

namespace trephine::workbench {

using sim::Finding;

namespace {

void add(std::vector<Finding>& findings, std::string name, double value, std::string unit = "") {
  findings.push_back({.name = std::move(name), .value = value, .unit = std::move(unit)});
}

/// Adds the findings about a forbidden structure, for all hands together: tears, distance, entries and time.
/// `index`: index of the structure. `count`: number of forbidden structures.
void add_structure(const sim::OperationState& operation, std::size_t index, std::size_t count,
                   const std::string& name, std::vector<Finding>& findings) {
  double nearest = sim::Forbidden::k_reach, entries = 0, ticks = 0;
  for (std::size_t i = index; i < operation.watches.size(); i += count) {
    const sim::ForbiddenWatch& watch = operation.watches[i];
    nearest = std::min(nearest, watch.nearest);
    entries += static_cast<double>(watch.entries), ticks += static_cast<double>(watch.ticks_inside);
  }
  Finding torn{.name = name + ": torn", .value = 0, .full_at = 0, .zero_at = 1, .weight = 4};
  for (std::size_t i = 0; i < operation.chronicle.size(); ++i) {
    const sim::Event& event = operation.chronicle[i];
    const auto* tear = event.value.as<sim::StructureTorn>();
    if (tear == nullptr || tear->structure != name) continue;
    if (*torn.value == 0) torn.tick = event.tick, torn.position_world = event.position_world;
    ++*torn.value;
  }
  findings.push_back(std::move(torn));
  add(findings, name + ": nearest distance", nearest, "mm");
  if (nearest >= sim::Forbidden::k_reach)
    findings.back().reason = "The tool was never nearer. Larger distances are not measured.";
  add(findings, name + ": entries", entries);
  add(findings, name + ": time inside", ticks * operation.dt, "s");
}

/// Returns the number of refusals for each request name.
std::map<std::string, int> refusals_of(const sim::Chronicle& chronicle) {
  std::map<std::string, int> counts;
  for (std::size_t i = 0; i < chronicle.size(); ++i)
    if (const auto* refused = chronicle[i].value.as<sim::StepRefused>()) ++counts[refused->request];
  return counts;
}

void add_refusals(const sim::OperationState& operation, std::vector<Finding>& findings) {
  const std::map<std::string, int> counts = refusals_of(operation.chronicle);
  if (counts.empty() && (!operation.plan || operation.plan->procedure.is_empty())) return;
  Finding refused{.name = "refused requests", .value = 0};
  for (const auto& [request, count] : counts) {
    *refused.value += count;
    refused.reason += (refused.reason.empty() ? "" : ", ") + request + ": " + std::to_string(count);
  }
  findings.push_back(std::move(refused));
}

/// Adds the finding that states whether the procedure reached an end. Without this finding, an operation in
/// which nothing was touched would get all points, because no structure was injured.
void add_procedure(const sim::OperationState& operation, std::vector<Finding>& findings) {
  constexpr double k_weight = 10;  // assumed
  const int step = operation.undoable.procedure.step;
  if (step < 0) return;
  const volume::ProcedureStep& current = operation.plan->procedure.steps[static_cast<std::size_t>(step)];
  findings.push_back({.name = "procedure: complete",
                      .value = current.is_end ? 1 : 0,
                      .reason = current.is_end ? "" : "The operation ended in the step " + current.name + ".",
                      .full_at = 1,
                      .zero_at = 0,
                      .weight = k_weight});
}

void add_motion(const HandMotion& motion, bool has_forbidden, std::vector<Finding>& findings) {
  add(findings, "motion: working time", motion.working_seconds, "s");
  add(findings, "motion: idle time", motion.idle_seconds, "s");
  add(findings, "motion: path", motion.path, "mm");
  add(findings, "motion: mean speed", motion.mean_speed, "mm/s");
  add(findings, "motion: peak speed", motion.peak_speed, "mm/s");
  add(findings, "motion: jerk", motion.jerk, "mm/s3");
  Finding smoothness{.name = "motion: log dimensionless jerk"};
  if (motion.measured_strokes > 0)
    smoothness.value = motion.log_jerk;
  else
    smoothness.reason = "No stroke lasted a quarter of a second and changed its speed.";
  findings.push_back(std::move(smoothness));
  add(findings, "motion: strokes", static_cast<double>(motion.strokes));
  add(findings, "motion: mean length of strokes", motion.stroke_length, "mm");
  add(findings, "motion: spread of strokes", motion.stroke_spread, "mm");
  add(findings, "force: mean", motion.mean_force, "N");
  add(findings, "force: peak", motion.peak_force, "N");
  if (!has_forbidden) return;
  add(findings, "motion: time near forbidden structures", motion.near_seconds, "s");
  add(findings, "force: time pressing near forbidden structures", motion.near_force_seconds, "s");
}

/// Numbers findings that have the name of an earlier one: "L4: canal (2)".
void make_unique(std::vector<Finding>& findings) {
  std::map<std::string, int> used;
  for (Finding& finding : findings)
    if (const int number = ++used[finding.name]; number > 1)
      finding.name += " (" + std::to_string(number) + ")";
}

}  // namespace

std::vector<Finding> findings_of(sim::Engine& engine, const MotionStats* motion,
                                 const std::function<bool(double share)>& progress) {
  const std::shared_ptr<const sim::OperationState> state = engine.snapshot();
  const haptics::TouchScene& anatomy = *engine.tool().scene;
  const sim::JobInput input{*state, anatomy, haptics::solids_of(anatomy), engine.forbidden()};
  std::vector<Finding> all;
  const auto modules = modules::catalogue().modules();
  for (std::size_t i = 0; i < modules.size(); ++i) {
    if (!progress(static_cast<double>(i) / static_cast<double>(modules.size()))) break;
    for (Finding& finding : modules[i]->findings(input)) all.push_back(std::move(finding));
  }
  for (Finding& finding : operation_findings(*state, engine.forbidden(), motion))
    all.push_back(std::move(finding));
  make_unique(all);
  return all;
}

std::vector<Finding> operation_findings(const sim::OperationState& operation,
                                        std::span<const std::shared_ptr<const sim::Forbidden>> forbidden,
                                        const MotionStats* motion) {
  std::vector<Finding> findings;
  add_procedure(operation, findings);
  for (std::size_t i = 0; i < forbidden.size(); ++i)
    add_structure(operation, i, forbidden.size(), forbidden[i]->name(), findings);
  add_refusals(operation, findings);
  add(findings, "undos", static_cast<double>(operation.chronicle.undos));
  add(findings, "time", operation.seconds(), "s");
  if (motion) add_motion(motion->total(), !forbidden.empty(), findings);
  return findings;
}

sim::Score score_of(sim::Engine& engine, const MotionStats* motion,
                    const std::function<bool(double share)>& progress, std::vector<sim::Finding> additional) {
  std::vector<sim::Finding> findings = findings_of(engine, motion, progress);
  std::move(additional.begin(), additional.end(), std::back_inserter(findings));
  const volume::SurgicalPlan* const plan = engine.state().plan.get();
  return sim::score(std::move(findings),
                    plan ? volume::score_limits(*plan) : std::vector<volume::ScoreLimit>());
}

}  // namespace trephine::workbench
