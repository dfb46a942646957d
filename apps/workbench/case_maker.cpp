#include "apps/workbench/case_maker.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "data-tools/cases/case_folder.h"
#include "data-tools/files/words.h"
#include "data-tools/quality/scan_quality.h"

namespace trephine::workbench {

namespace {

/// Returns an error if a position of the plan is outside the scan.
Status check_inside(const volume::SurgicalPlan& plan, const volume::Volume& scan) {
  Status error;
  const auto check = [&](const std::string& name, const glm::dvec3& world) {
    const glm::dvec3 p = scan.frame.volume_from_world(world);
    for (int a = 0; a < 3 && !error; ++a)
      if (!(p[a] >= -0.5 && p[a] <= scan.size[a] - 0.5))
        error = Error{.what = "a position of the plan is outside the scan",
                      .where = name,
                      .expected = "a position in the scan",
                      .remedy = "remove this mark, and mark the position again"};
  };
  for (const volume::PlannedTrajectory& t : plan.trajectories)
    check(t.name, t.entry_world), check(t.name, t.target_world);
  for (const volume::PlannedLandmark& l : plan.landmarks) check(l.name, l.position_world);
  for (const volume::PlannedOutline& o : plan.outlines)
    for (const glm::dvec3& p : o.points_world) check(o.name, p);
  return error;
}

/// Returns an error if two marks have the same name, the limits of a finding are invalid, or a structure is
/// both forbidden and a target.
Status check_request(const CaseRequest& request) {
  std::set<std::string> names;
  Status error;
  const auto add = [&](const std::string& name) {
    if (!names.insert(name).second && !error)
      error = Error{.what = "two marks have the same name", .found = name, .remedy = "rename one of them"};
  };
  for (const auto& one : request.plan.trajectories) add(one.name);
  for (const auto& one : request.plan.landmarks) add(one.name);
  for (const auto& one : request.plan.outlines) add(one.name);
  for (const volume::ScoreLimit& limit : request.plan.score)
    if (!error && (!(limit.weight >= 0) || limit.full_at == limit.zero_at || !std::isfinite(limit.full_at) ||
                   !std::isfinite(limit.zero_at) || !std::isfinite(limit.weight)))
      error = Error{.what = "the limits of a finding are invalid",
                    .where = limit.finding,
                    .expected = "two different values, and points of 0 or more",
                    .remedy = "correct its row"};
  for (const volume::PlannedTarget& target : request.plan.targets)
    if (!error && std::count(request.forbidden.begin(), request.forbidden.end(), target.label) > 0)
      error = Error{.what = "a structure is forbidden and a target",
                    .found = target.label,
                    .remedy = "remove one of its two ticks"};
  return error;
}

}  // namespace

Result<data_tools::CasePlan> case_plan_of(const CaseRequest& request, const haptics::TouchScene& scene) {
  const volume::Volume& scan = *scene.base;
  if (!data_tools::is_utf8(request.name))
    return Error{
        .what = "the name of the case is not valid UTF-8", .where = "name", .remedy = "enter the name again"};
  if (request.name.find_first_not_of(' ') == std::string::npos)
    return Error{.what = "the case has no name",
                 .where = "name",
                 .expected = "a name that does not identify a patient",
                 .remedy = "enter a name, such as \"L4 training case\""};
  if (Status error = check_request(request)) return *error;
  if (Status error = volume::check(request.plan)) return *error;
  if (Status error = check_inside(request.plan, scan)) return *error;
  data_tools::CasePlan plan;
  static_cast<volume::SurgicalPlan&>(plan) = request.plan;
  plan.name = request.name;
  // Only a CT has Hounsfield units. The modality of other scans is not known here.
  plan.modality = scan.is_hounsfield ? "CT" : "";
  plan.is_hounsfield = scan.is_hounsfield;
  plan.label_names = scan.label_names;
  plan.label_colours = scan.label_colours;
  plan.models = request.models;
  for (const haptics::TouchItem& item : base_shapes(scene)) {
    if (&item.field.volume() != &scan) continue;
    data_tools::CaseStructure structure{.shape = item.field.shape(), .material = {}};
    plan.structures.push_back(std::move(structure));
  }
  for (const std::string& name : request.forbidden) {
    const int label = scan.label_value(name);
    if (scan.labels.is_empty() || label <= 0)
      return Error{.what = "unknown label",
                   .where = "forbidden structures",
                   .found = name,
                   .expected = "the name of a label of the scan",
                   .remedy = "choose a structure of the list"};
    const auto same = std::find_if(plan.structures.begin(), plan.structures.end(),
                                   [&](const auto& s) { return s.shape.label == label; });
    if (same != plan.structures.end()) {
      same->is_forbidden = true;
      continue;
    }
    data_tools::CaseStructure structure{
        .shape = {}, .is_touchable = false, .is_forbidden = true, .material = {}};
    structure.shape.name = name;
    structure.shape.label = label;
    plan.structures.push_back(std::move(structure));
  }
  return plan;
}

Status write_case_of(const CaseRequest& request, const haptics::TouchScene& scene, const std::string& folder,
                     const data_tools::Progress& progress) {
  Result<data_tools::CasePlan> plan = case_plan_of(request, scene);
  if (!plan) return plan.error();
  data_tools::CasePlan& made = plan.value();
  if (!made.structures.empty() && !made.structures[0].shape.is_label())
    made.quality = data_tools::scan_quality(*scene.base, made.structures[0].shape);
  return data_tools::write_case(folder, made, *scene.base, progress);
}

}  // namespace trephine::workbench
