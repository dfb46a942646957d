#include "modules/skull_clamp/skull_clamp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "modules/skull_clamp/clamp_surface.h"
#include "sim/api/work.h"
#include "volume/base/deterministic_math.h"

namespace trephine::skull_clamp {

using glm::dvec3;
using sim::field;

namespace {

/// Returns true if a fit describes the planned pins.
bool is_of_plan(const ClampFitted& fitted, const ClampPlan& plan) {
  return fitted.is_fitted && fitted.planned == plan.pins;
}

/// Returns a dashed circle around the head at the height of the sweatband.
sim::Overlay band_of(const ClampFitted& fitted) {
  sim::Overlay overlay;
  const dvec3 right = glm::normalize(dvec3(1, 0, 0) - fitted.band_normal.x * fitted.band_normal),
              back = glm::cross(fitted.band_normal, right);
  double radius = 0;
  for (const dvec3& tip : fitted.tips) radius = std::max(radius, glm::distance(tip, fitted.centre));
  constexpr int k_parts = 72;
  const auto point = [&](int i) {
    const double angle = 6.283185307179586 * i / k_parts;
    return fitted.centre + radius * (deterministic_cos(angle) * right + deterministic_sin(angle) * back);
  };
  for (int i = 0; i < k_parts; i += 2) overlay.lines.push_back({point(i), point(i + 1)});
  return overlay;
}

std::string millimetres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", value);
  return text;
}

sim::Overlay clamp_overlay(const ClampFitted& fitted, const dvec3& up) {
  sim::Overlay overlay;
  overlay.kind = sim::Overlay::Kind::object;
  overlay.name = "skull clamp";
  overlay.matter = volume::Matter::steel;
  overlay.surface =
      clamp_surface(pose_of(fitted), {fitted.tips[0], fitted.tips[1], fitted.tips[2]}, up, fitted.arm_depth);
  return overlay;
}

Status check_point(const dvec3& p, const char* where) {
  constexpr double k_farthest = 1e5;  // mm
  if (glm::dot(p, p) < k_farthest * k_farthest) return std::nullopt;
  return Error{.what = "a position is out of range",
               .where = where,
               .expected = "less than 100 m from the origin",
               .remedy = "choose a position on the head"};
}

}  // namespace

std::span<const sim::ValueType* const> SkullClamp::commands() const {
  static const std::array all{&sim::value_type<PlacePin>(), &sim::value_type<MovePin>(),
                              &sim::value_type<ClearPins>(), &sim::value_type<SetPosture>(),
                              &sim::value_type<SetClamp>()};
  return all;
}
std::span<const sim::JobType* const> SkullClamp::jobs() const {
  static const std::array all{&fit_job()};
  return all;
}
std::span<const sim::ValueType* const> SkullClamp::events() const {
  static const std::array all{&sim::value_type<ClampFitted>(), &sim::value_type<ClampFailed>(),
                              &sim::value_type<ClampTouchesHead>()};
  return all;
}

Status SkullClamp::allows(const sim::Command& command, const sim::OperationState& operation) const {
  const auto* plan = operation.persistent_of<ClampPlan>();
  const std::size_t count = plan ? plan->pins.size() : 0;
  if (const auto* place = command.request.as<PlacePin>()) {
    if (count == k_pins)
      return Error{.what = "the clamp has all its pins",
                   .where = "place-pin",
                   .found = "three pins",
                   .remedy = "move one (move-pin), or remove them (clear-pins)"};
    return check_point(place->at, "place-pin at");
  }
  if (const auto* move = command.request.as<MovePin>()) {
    if (move->number < 1 || static_cast<std::size_t>(move->number) > count)
      return Error{.what = "unknown pin",
                   .where = "move-pin number",
                   .found = std::to_string(move->number),
                   .expected = count == 0 ? "a placed pin" : "1 to " + std::to_string(count),
                   .remedy = count == 0 ? "place a pin first (place-pin)" : "choose one of these"};
    return check_point(move->at, "move-pin at");
  }
  if (const auto* posture = command.request.as<SetPosture>()) {
    const double length = glm::length(posture->up);
    if (length > 1e-6 && length < 1e6) return std::nullopt;
    return Error{.what = length < 1 ? "the direction up has no length" : "the direction up is too long",
                 .where = "set-posture up",
                 .expected = "a direction, such as 0,-1,0 for a patient who looks up",
                 .remedy = "pass a vector of about length 1"};
  }
  if (const auto* fit = command.request.as<FitClamp>()) return check_fitting(*fit, operation);
  return std::nullopt;
}

void SkullClamp::apply(const sim::Command& command, sim::ModuleWork& work) const {
  if (const auto* place = command.request.as<PlacePin>()) {
    work.change_settings<ClampPlan>().pins.push_back(place->at);
  } else if (const auto* move = command.request.as<MovePin>()) {
    work.change_settings<ClampPlan>().pins[static_cast<std::size_t>(move->number - 1)] = move->at;
  } else if (command.request.as<ClearPins>()) {
    work.change_settings<ClampPlan>().pins.clear();
    work.change_result<ClampFitted>() = {};
  } else if (const auto* posture = command.request.as<SetPosture>()) {
    auto& plan = work.change_settings<ClampPlan>();
    plan.up = glm::normalize(posture->up), plan.turn = posture->turn;
    work.change_result<ClampFitted>() = {};
  } else if (const auto* clamp = command.request.as<SetClamp>()) {
    work.change_settings<ClampPlan>().model = clamp->model;
    work.change_result<ClampFitted>() = {};
  }
}

std::vector<sim::Measure> SkullClamp::measures(const sim::OperationState& operation) const {
  const auto* fitted = operation.result_of<ClampFitted>();
  const auto* plan = operation.persistent_of<ClampPlan>();
  if (fitted == nullptr || plan == nullptr) return {};
  const bool is_stale =
      fitted->is_fitted && (operation.is_result_stale<ClampFitted>() || !is_of_plan(*fitted, *plan));
  std::vector<sim::Measure> all{{"clamp fitted", fitted->is_fitted ? 1.0 : 0.0, "", is_stale},
                                {"clamp at a limit", fitted->trouble.empty() ? 0.0 : 1.0, "", is_stale},
                                {"clamp opening", fitted->opening, "mm", is_stale},
                                {"clamp swing", fitted->swing, "degrees", is_stale},
                                {"clamp axis miss", fitted->axis_miss, "mm", is_stale},
                                {"clamp pair difference", fitted->pair_difference, "mm", is_stale}};
  const auto value = [](const std::vector<double>& list, std::size_t i) {
    return i < list.size() ? list[i] : 0.0;
  };
  for (std::size_t i = 0; i < k_pins; ++i) {
    const std::string pin = "clamp pin " + std::to_string(i + 1);
    all.push_back({pin + " residual", value(fitted->residuals, i), "mm", is_stale});
    all.push_back({pin + " gap", value(fitted->gaps, i), "mm", is_stale});
    all.push_back({pin + " bone", value(fitted->thicknesses, i), "mm", is_stale});
    all.push_back({pin + " scalp", value(fitted->scalps, i), "mm", is_stale});
    all.push_back({pin + " angle", value(fitted->angles, i), "degrees", is_stale});
    all.push_back({pin + " height", value(fitted->heights, i), "mm", is_stale});
  }
  all.push_back({"clamp clearance", fitted->clearance, "mm", is_stale});
  all.push_back({"clamp in head", fitted->touch_depth, "mm", is_stale});
  all.push_back({"clamp access", fitted->access, "mm", is_stale});
  all.push_back({"angle of the approach to the vertical", fitted->site_angle, "degrees", is_stale});
  all.push_back({"neck rotation", fitted->rotation, "degrees", is_stale});
  all.push_back({"neck flexion", fitted->flexion, "degrees", is_stale});
  all.push_back({"neck bend", fitted->bend, "degrees", is_stale});
  return all;
}

sim::Overlays SkullClamp::overlays(const sim::OperationState& operation) const {
  const auto* plan = operation.persistent_of<ClampPlan>();
  if (plan == nullptr || plan->pins.empty()) return {};
  sim::Overlays all;
  const auto* fitted = operation.result_of<ClampFitted>();
  const bool has_fit = fitted != nullptr && is_of_plan(*fitted, *plan);
  sim::Overlay pins;
  for (std::size_t i = 0; i < plan->pins.size(); ++i) {
    std::string text = "pin " + std::to_string(i + 1);
    if (has_fit) text += ": " + millimetres(fitted->residuals[i]);
    pins.labels.push_back({plan->pins[i], std::move(text)});
    pins.handles.push_back({plan->pins[i], MovePin{static_cast<std::int64_t>(i) + 1}});
  }
  all.push_back(std::move(pins));
  if (!has_fit) return all;
  all.push_back(clamp_overlay(*fitted, plan->up));
  if (fitted->has_band) all.push_back(band_of(*fitted));
  const auto warn = [&all](const dvec3& at, std::string text) {
    sim::Overlay warning;
    warning.kind = sim::Overlay::Kind::warning;
    warning.labels.push_back({at, std::move(text)});
    all.push_back(std::move(warning));
  };
  if (!fitted->trouble.empty()) warn(fitted->tips[0], fitted->trouble);
  if (fitted->touch_depth > 0)
    warn(fitted->touch_at, "the clamp touches the head: " + millimetres(fitted->touch_depth));
  return all;
}

const sim::Schema& PlacePin::schema() {
  static constexpr sim::Field fields[] = {
      field<&PlacePin::at>("at", {.unit = "mm", .help = "position on the head"})};
  static constexpr sim::Schema table{"place-pin", 1, fields};
  return table;
}
const sim::Schema& MovePin::schema() {
  static constexpr sim::Field fields[] = {
      field<&MovePin::number>("number",
                              {.low = 1, .high = 3, .help = "number of the pin; 1 is the single pin"}),
      field<&MovePin::at>("at", {.unit = "mm", .help = "position on the head"})};
  static constexpr sim::Schema table{"move-pin", 1, fields};
  return table;
}
const sim::Schema& ClearPins::schema() {
  static constexpr sim::Schema table{"clear-pins", 1, {}};
  return table;
}
const sim::Schema& SetClamp::schema() {
  static constexpr sim::Field fields[] = {
      field<&SetClamp::model>("model", {.choices = k_clamp_models, .help = "size of the clamp"})};
  static constexpr sim::Schema table{"set-clamp", 1, fields};
  return table;
}
const sim::Schema& SetPosture::schema() {
  static constexpr sim::Field fields[] = {
      field<&SetPosture::up>("up", {.help = "direction away from the floor, in the frame of the head"}),
      field<&SetPosture::turn>("turn", {.unit = "degrees",
                                        .low = -180,
                                        .high = 180,
                                        .help = "turn of the trunk to the left: 0 supine, 180 prone"})};
  static constexpr sim::Schema table{"set-posture", 1, fields};
  return table;
}

}  // namespace trephine::skull_clamp
