// Findings of a skull clamp. docs/scores.md has the limits.
#include <algorithm>
#include <cmath>

#include "modules/skull_clamp/skull_clamp.h"

namespace trephine::skull_clamp {

namespace {

using sim::Finding;

/// Value that is the worst one of all pins.
enum class Worst { largest, least };
/// Adds a finding with the value and the tip of the worst pin. Without values the finding is not judged.
void add_pin(Finding finding, const std::vector<double>& values, Worst worst, const ClampFitted& fitted,
             std::vector<Finding>& findings) {
  std::size_t found = 0;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (worst == Worst::largest ? values[i] > values[found] : values[i] < values[found]) found = i;
  if (!values.empty()) {
    finding.value = values[found];
    finding.position_world = fitted.tips[found];
    finding.reason = "Pin " + std::to_string(found + 1) + ".";
  }
  findings.push_back(std::move(finding));
}

std::vector<double> absolute(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return values;
}

void add_pins(const ClampFitted& fitted, std::vector<Finding>& findings) {
  add_pin(
      {.name = "clamp: pin to its planned position", .unit = "mm", .full_at = 3, .zero_at = 10, .weight = 1},
      fitted.residuals, Worst::largest, fitted, findings);
  add_pin({.name = "clamp: least bone at a pin", .unit = "mm", .full_at = 3, .zero_at = 1, .weight = 2},
          fitted.thicknesses, Worst::least, fitted, findings);
  add_pin({.name = "clamp: least angle of a pin to the bone",
           .unit = "degrees",
           .full_at = 75,
           .zero_at = 45,
           .weight = 2},
          fitted.angles, Worst::least, fitted, findings);
  add_pin(
      {.name = "clamp: largest height over the sweatband",
       .unit = "mm",
       .reason = "The plan has no sweatband; add a plane of that name, or the landmarks glabella and inion.",
       .full_at = 10,
       .zero_at = 30,
       .weight = 2},
      absolute(fitted.heights), Worst::largest, fitted, findings);
}

void add_clearance(const ClampFitted& fitted, bool has_forbidden, std::vector<Finding>& findings) {
  Finding clearance{.name = "clamp: clearance of forbidden structures",
                    .unit = "mm",
                    .full_at = 5,
                    .zero_at = 0,
                    .weight = 2};
  if (has_forbidden)
    clearance.value = fitted.clearance;
  else
    clearance.reason = "The operation has no forbidden structures; add some to the case.";
  if (!fitted.nearest.empty()) clearance.reason = "Nearest: " + fitted.nearest + ".";
  Finding access{.name = "clamp: pin to approach", .unit = "mm", .full_at = 20, .zero_at = 0, .weight = 2};
  Finding angle{.name = "posture: angle of the approach to the vertical", .unit = "degrees"};
  if (fitted.site.empty())
    access.reason = angle.reason = "The plan has no approach; add an outline or a trajectory.";
  else
    access.value = fitted.access, angle.value = fitted.site_angle;
  findings.push_back(std::move(clearance)), findings.push_back(std::move(access));
  findings.push_back(std::move(angle));
}

void add_pose(const ClampFitted& fitted, std::vector<Finding>& findings) {
  findings.push_back({.name = "clamp: at a limit",
                      .value = fitted.trouble.empty() ? 0.0 : 1.0,
                      .reason = fitted.trouble,
                      .full_at = 0,
                      .zero_at = 1,
                      .weight = 2});
  findings.push_back({.name = "clamp: axis to the centre of the skull",
                      .value = fitted.axis_miss,
                      .unit = "mm",
                      .position_world = fitted.centre,
                      .full_at = 10,
                      .zero_at = 30,
                      .weight = 2});
  findings.push_back(
      {.name = "clamp: difference within the pair", .value = fitted.pair_difference, .unit = "mm"});
}

/// Returns a request with the approach of the newest fit. Its other members have their defaults, since the
/// state does not contain those of the newest fit.
FitClamp request_of(const sim::OperationState& operation) {
  FitClamp request;
  if (const auto* fitted = operation.result_of<ClampFitted>()) request.site = fitted->site;
  return request;
}

}  // namespace

std::vector<Finding> SkullClamp::findings(const sim::JobInput& input) const {
  const auto* plan = input.state.persistent_of<ClampPlan>();
  const auto& items = input.anatomy.items;
  if (plan == nullptr || plan->pins.empty() || items.empty() || items[0].is_mesh()) return {};
  Finding fits{.name = "clamp: fitted", .full_at = 1, .zero_at = 0, .weight = 2};
  if (plan->pins.size() != k_pins) {
    fits.reason = "The clamp has " + std::to_string(plan->pins.size()) + " of 3 pins; place the others.";
    return {fits};
  }
  const auto result = fit(request_of(input.state), input);
  fits.value = result ? 1 : 0;
  if (!result) {
    fits.reason = "The clamp does not fit: " + result.error().reason + ".";
    fits.position_world = result.error().position_world;
    return {fits};
  }
  const ClampFitted& fitted = result.value();
  std::vector<Finding> findings{fits};
  add_pose(fitted, findings);
  add_pins(fitted, findings);
  add_clearance(fitted, !input.forbidden.empty(), findings);
  findings.push_back({.name = "posture: neck rotation", .value = fitted.rotation, .unit = "degrees"});
  findings.push_back({.name = "posture: neck flexion", .value = fitted.flexion, .unit = "degrees"});
  findings.push_back({.name = "posture: neck bend", .value = fitted.bend, .unit = "degrees"});
  return findings;
}

}  // namespace trephine::skull_clamp
