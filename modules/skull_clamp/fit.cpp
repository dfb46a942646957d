#include "modules/skull_clamp/fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <optional>

#include "modules/skull_clamp/head_contact.h"
#include "sim/api/work.h"
#include "volume/base/deterministic_math.h"
#include "volume/scan/solid_runs.h"

namespace trephine::skull_clamp {

using glm::dvec3;
using sim::field;

namespace {

constexpr double k_radian = 57.295779513082320877;  // degrees per radian
constexpr double k_pin_reach = 40;  // mm outward from a tip in which bone and scalp are searched
constexpr double k_search = 60;     // mm inward from a tip in which bone is searched
constexpr double k_band = 20;  // mm above and below the sweatband: bone there determines the skull's centre
constexpr double k_loose = 1;  // mm from a planned position to its pin's axis; larger distances are reported

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f", value);
  return text;
}

struct FitResult final : sim::JobResult {
  ClampFitted fitted;
  LocatedStatus error;

  std::string_view failure() const noexcept override { return reason_of(error); }
  std::uint64_t hash() const override {
    MixHash mix;
    sim::add_value(mix, fitted);
    if (error) sim::add_bytes(mix, error->reason);
    return mix.value();
  }
};

const dvec3* find_landmark(const volume::SurgicalPlan* plan, const char* name) {
  if (plan == nullptr) return nullptr;
  for (const volume::PlannedLandmark& one : plan->landmarks)
    if (one.name == name) return &one.position_world;
  return nullptr;
}

struct Plane {
  dvec3 point_world{0.0}, normal_world{0, 0, 1};
  double height(const dvec3& p) const noexcept { return glm::dot(p - point_world, normal_world); }
};
/// Returns the plane of the sweatband: the plane "sweatband" of the plan or, without it, the plane through
/// the landmarks glabella and inion that is parallel to the x axis. Its normal points upward. Empty if the
/// plan defines neither.
std::optional<Plane> sweatband(const volume::SurgicalPlan* plan) {
  if (plan == nullptr) return std::nullopt;
  for (const volume::PlannedPlane& one : plan->planes)
    if (one.name == "sweatband")
      return Plane{one.point_world, one.normal_world.z < 0 ? -one.normal_world : one.normal_world};
  const dvec3 *front = find_landmark(plan, "glabella"), *back = find_landmark(plan, "inion");
  if (front == nullptr || back == nullptr || glm::distance(*front, *back) < 1) return std::nullopt;
  const dvec3 normal = glm::cross(dvec3(1, 0, 0), *back - *front);
  if (!(glm::length(normal) > 0)) return std::nullopt;
  return Plane{*front, (normal.z < 0 ? -1.0 : 1.0) * glm::normalize(normal)};
}

/// Returns the centre of the skull: the landmark "skull centre" if the plan has it. Otherwise, with a
/// sweatband: the middle of the box around the bone within k_band of the sweatband, at the height of the
/// sweatband. Without a sweatband: the middle of the box around all bone.
dvec3 skull_centre(const volume::SurgicalPlan* plan, const std::optional<Plane>& band,
                   const volume::Field& bone) {
  if (const dvec3* centre = find_landmark(plan, "skull centre")) return *centre;
  const volume::Volume& scan = bone.volume();
  const Plane plane = band.value_or(Plane{});
  const dvec3 right = glm::normalize(dvec3(1, 0, 0) - plane.normal_world.x * plane.normal_world),
              back = glm::cross(plane.normal_world, right);
  constexpr double k_sample = 1;  // mm
  glm::ivec3 stride;
  for (int a = 0; a < 3; ++a) stride[a] = std::max(1, static_cast<int>(k_sample / scan.frame.spacing()[a]));
  dvec3 low(1e300), high(-1e300);
  for (int z = 0; z < scan.size.z; z += stride.z)
    for (int y = 0; y < scan.size.y; y += stride.y)
      for (int x = 0; x < scan.size.x; x += stride.x) {
        if (bone.at(x, y, z) < 0) continue;
        const dvec3 offset = scan.frame.world_from_volume(dvec3(x, y, z)) - plane.point_world;
        const dvec3 p(glm::dot(offset, right), glm::dot(offset, back), glm::dot(offset, plane.normal_world));
        if (band && std::abs(p.z) > k_band) continue;
        low = glm::min(low, p), high = glm::max(high, p);
      }
  if (low.x > high.x) return plane.point_world;
  dvec3 middle = 0.5 * (low + high);
  if (band) middle.z = 0;
  return plane.point_world + middle.x * right + middle.y * back + middle.z * plane.normal_world;
}

/// The approach of an operation: points around which there must be room, and the direction out of the head.
struct Site {
  std::string name;
  std::vector<dvec3> points;
  dvec3 outward{0, 0, 1};
};
std::optional<Site> find_site(const volume::SurgicalPlan* plan, const std::string& name) {
  if (plan == nullptr) return std::nullopt;
  for (const volume::PlannedOutline& one : plan->outlines)
    if (name.empty() || one.name == name) {
      // Area vector (Newell's method). Outlines have any direction: measure_posture() turns it outward.
      dvec3 middle(0), area(0);
      for (const dvec3& p : one.points_world) middle += p / static_cast<double>(one.points_world.size());
      for (std::size_t i = 0; i < one.points_world.size(); ++i)
        area += glm::cross(one.points_world[i] - middle,
                           one.points_world[(i + 1) % one.points_world.size()] - middle);
      if (!(glm::length(area) > 0)) continue;
      return Site{one.name, one.points_world, glm::normalize(area)};
    }
  for (const volume::PlannedTrajectory& one : plan->trajectories)
    if ((name.empty() || one.name == name) && one.entry_world != one.target_world)
      return Site{one.name, {one.entry_world}, glm::normalize(one.entry_world - one.target_world)};
  return std::nullopt;
}
double distance_to(const Site& site, const dvec3& p) {
  double least = 1e300;
  for (std::size_t i = 0; i < site.points.size(); ++i) {
    const dvec3 &a = site.points[i], side = site.points[(i + 1) % site.points.size()] - a;
    const double square = glm::dot(side, side);
    const double share = square > 0 ? std::clamp(glm::dot(p - a, side) / square, 0.0, 1.0) : 0;
    least = std::min(least, glm::distance(p, a + share * side));
  }
  return least;
}

/// Finds the outer table on the axis of each pin of a pose, and sets tips, gaps, thicknesses and angles of
/// `output`. Returns an error if a pin meets no bone.
LocatedStatus find_tips(const volume::Field& bone, const ClampPose& pose, double rocker_width,
                        ClampFitted& output) {
  const Pins places = pose.tips_world(rocker_width), directions = pose.directions_world();
  output.tips.clear(), output.gaps.clear(), output.thicknesses.clear(), output.angles.clear();
  for (std::size_t i = 0; i < k_pins; ++i) {
    const auto crossing = volume::skull_crossing(bone, places[i] - k_pin_reach * directions[i], directions[i],
                                                 k_pin_reach + k_search);
    if (!crossing)
      return LocatedError{"pin " + std::to_string(i + 1) + " meets no bone: move it onto the skull",
                          output.planned[i]};
    output.tips.push_back(crossing->outer_world);
    output.gaps.push_back(glm::dot(crossing->outer_world - places[i], directions[i]));
    output.thicknesses.push_back(crossing->thickness);
    output.angles.push_back(90 - angle_between(crossing->normal_world, -directions[i]));
  }
  return std::nullopt;
}

std::string trouble_of(const ClampPose& pose, const ClampLimits& limits, const ClampFitted& fitted) {
  std::string text;
  const auto add = [&text](const std::string& one) { text += (text.empty() ? "" : "; ") + one; };
  if (pose.is_opening_limited)
    add(pose.opening > 0.5 * (limits.least_opening + limits.most_opening)
            ? "the head is wider than the clamp opens (" + number_text(limits.most_opening) + " mm)"
            : "the head is narrower than the clamp closes (" + number_text(limits.least_opening) + " mm)");
  if (pose.is_swing_limited) add("the rocker swings at most " + number_text(limits.swing) + "°");
  if (text.empty())
    for (const double residual : fitted.residuals)
      if (residual > k_loose && text.empty())
        add("pins 2 and 3 are " + number_text(glm::distance(fitted.planned[1], fitted.planned[2])) +
            " mm apart, those of the rocker " + number_text(limits.rocker_width) + " mm");
  return text;
}

/// Measures the scalp under the pins, and the depth of arms and rocker in the head.
void measure_head(const volume::Field& bone, const ClampPose& pose, const dvec3& up, ClampFitted& output) {
  const HeadSolid head(bone);
  const Pins directions = pose.directions_world();
  if (head.has_skin())
    for (std::size_t i = 0; i < k_pins; ++i)
      output.scalps.push_back(head.thickness(output.tips[i], -directions[i], k_pin_reach));
  const HeadContact contact = head_contact(
      head, clamp_rods(pose, {output.tips[0], output.tips[1], output.tips[2]}, up, output.arm_depth));
  output.touch_depth = contact.depth, output.touch_length = contact.length;
  output.touch_at = contact.at_world;
}

void measure_pins(const sim::JobInput& input, const volume::Field& bone, ClampFitted& output) {
  const volume::SurgicalPlan* plan = input.state.plan.get();
  const auto band = sweatband(plan);
  output.centre = skull_centre(plan, band, bone);
  if (band) {
    output.has_band = true, output.band_normal = band->normal_world;
    for (const dvec3& tip : output.tips) output.heights.push_back(band->height(tip));
  }
  const auto distance_from_line = [](const dvec3& p, const dvec3& a, const dvec3& along) {
    return glm::length(glm::cross(p - a, along));
  };
  const dvec3 middle = 0.5 * (output.tips[1] + output.tips[2]);
  output.axis_miss =
      distance_from_line(output.centre, output.tips[0], glm::normalize(middle - output.tips[0]));
  if (const dvec3 line = output.centre - output.tips[0]; glm::length(line) > 0) {
    const dvec3 along = glm::normalize(line);
    output.pair_difference = std::abs(distance_from_line(output.tips[1], output.tips[0], along) -
                                      distance_from_line(output.tips[2], output.tips[0], along));
  }
  output.clearance = sim::Forbidden::k_reach;
  for (const auto& forbidden : input.forbidden)
    for (const dvec3& tip : output.tips)
      if (const double clearance = forbidden->clearance(sim::ToolBall{tip, 0, false});
          clearance < output.clearance)
        output.clearance = clearance, output.nearest = forbidden->name();
}

void measure_posture(const FitClamp& request, const sim::JobInput& input, const ClampPlan& plan,
                     ClampFitted& output) {
  const NeckAngles neck = neck_angles(plan.up, plan.turn);
  output.rotation = neck.rotation, output.flexion = neck.flexion, output.bend = neck.bend;
  auto site = find_site(input.state.plan.get(), request.site);
  if (!site) return;
  dvec3 middle(0);
  for (const dvec3& p : site->points) middle += p / static_cast<double>(site->points.size());
  if (glm::dot(site->outward, middle - output.centre) < 0) site->outward = -site->outward;
  output.site = site->name;
  output.site_angle = angle_between(site->outward, plan.up);
  output.access = 1e300;
  for (const dvec3& tip : output.tips) output.access = std::min(output.access, distance_to(*site, tip));
}

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  auto output = std::make_shared<FitResult>();
  auto fitted = fit(*static_cast<const FitClamp*>(parameters), input);
  if (fitted)
    output->fitted = std::move(fitted).value();
  else
    output->error = fitted.error();
  return output;
}

/// Returns true if pins, clamp model and posture are those of the fit.
bool is_current(const void*, const sim::OperationState& input, const sim::OperationState& current) {
  const ClampPlan &fitted = *input.persistent_of<ClampPlan>(), &now = *current.persistent_of<ClampPlan>();
  return fitted.pins == now.pins && fitted.model == now.model && fitted.up == now.up &&
         fitted.turn == now.turn;
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& output = static_cast<const FitResult&>(result);
  work.change_result<ClampFitted>() = output.fitted;  // a failure also removes the earlier fit
  if (output.error)
    work.raise_event(ClampFailed{output.error->reason}, output.error->position_world);
  else
    work.raise_event(output.fitted, output.fitted.origin + 0.5 * output.fitted.opening * output.fitted.axis);
  if (output.fitted.touch_depth > 0)
    work.raise_event(ClampTouchesHead{output.fitted.touch_depth, output.fitted.touch_length},
                     output.fitted.touch_at);
}

Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  const auto& request = *static_cast<const FitClamp*>(parameters);
  if (request.item < 0 || static_cast<std::size_t>(request.item) >= anatomy.items.size() ||
      anatomy.items[static_cast<std::size_t>(request.item)].is_mesh())
    return Error{.what = "unknown shape",
                 .where = "fit-clamp item",
                 .found = std::to_string(request.item),
                 .expected = "a shape of the anatomy",
                 .remedy = "pass the number of a touchable shape, 0 for the first"};
  return std::nullopt;
}

double atan2_degrees(double y, double x) noexcept {
  if (x == 0 && y == 0) return 0;
  const double angle = k_radian * deterministic_acos(std::clamp(x / std::sqrt(x * x + y * y), -1.0, 1.0));
  return y < 0 ? -angle : angle;
}

}  // namespace

Result<ClampFitted, LocatedError> fit(const FitClamp& request, const sim::JobInput& input) {
  const volume::Field& bone = input.anatomy.items[static_cast<std::size_t>(request.item)].field;
  const ClampPlan& plan = *input.state.persistent_of<ClampPlan>();
  ClampFitted fitted;
  fitted.planned = plan.pins;
  const ClampLimits limits = request.limits(plan);
  Pins pins{plan.pins[0], plan.pins[1], plan.pins[2]};
  // The first pass fits the planned positions, which may be on the skin. Each further pass fits the positions
  // at which the pins of the previous pass meet bone.
  ClampPose pose;
  constexpr int k_passes = 4;
  for (int pass = 0; pass < k_passes; ++pass) {
    auto found = fit_pose(pins, limits);
    if (!found) return found.error();
    pose = found.value();
    if (auto error = find_tips(bone, pose, limits.rocker_width, fitted)) return *std::move(error);
    for (std::size_t i = 0; i < k_pins; ++i) pins[i] = fitted.tips[i];
  }
  fitted.is_fitted = true;
  fitted.origin = pose.origin_world, fitted.axis = pose.axis_world, fitted.across = pose.across_world;
  fitted.opening = pose.opening, fitted.swing = k_radian * pose.swing;
  const Pins places = pose.tips_world(limits.rocker_width), directions = pose.directions_world();
  for (std::size_t i = 0; i < k_pins; ++i)
    fitted.residuals.push_back(glm::length(glm::cross(fitted.planned[i] - places[i], directions[i])));
  fitted.trouble = trouble_of(pose, limits, fitted);
  fitted.arm_depth = size_of(plan.model).arm_depth;
  measure_head(bone, pose, plan.up, fitted);
  measure_pins(input, bone, fitted);
  measure_posture(request, input, plan, fitted);
  return fitted;
}

NeckAngles neck_angles(const dvec3& up, double turn) noexcept {
  NeckAngles angles;
  // The head's long axis (z) rises above the horizontal trunk by this angle, toward `up`.
  const double rise = 90 - angle_between(up, dvec3(0, 0, 1));
  const double level = std::sqrt(up.x * up.x + up.y * up.y);
  if (level > 0) {
    angles.flexion = rise * -up.y / level;
    angles.bend = rise * up.x / level;
    // The roll is 0 if the face looks straight up, and positive if it looks to the patient's left.
    const double roll = atan2_degrees(-up.x, -up.y);
    angles.rotation = roll - turn;
    while (angles.rotation > 180) angles.rotation -= 360;
    while (angles.rotation <= -180) angles.rotation += 360;
  } else {
    angles.flexion = rise;
  }
  return angles;
}

ClampPose pose_of(const ClampFitted& fitted) noexcept {
  ClampPose pose;
  pose.origin_world = fitted.origin, pose.axis_world = fitted.axis, pose.across_world = fitted.across;
  pose.opening = fitted.opening, pose.swing = fitted.swing / k_radian;
  return pose;
}

Status check_fitting(const FitClamp& request, const sim::OperationState& operation) {
  const auto* plan = operation.persistent_of<ClampPlan>();
  if (plan == nullptr || plan->pins.size() != k_pins)
    return Error{.what = "the clamp has too few pins",
                 .where = "fit-clamp",
                 .found = std::to_string(plan ? plan->pins.size() : 0),
                 .expected = "three pins",
                 .remedy = "place pins first (place-pin)"};
  if (const ClampLimits limits = request.limits(*plan); limits.least_opening >= limits.most_opening)
    return Error{.what = "the limits of the opening are reversed",
                 .where = "fit-clamp least_opening",
                 .found = number_text(limits.least_opening) + " mm",
                 .expected = "less than " + number_text(limits.most_opening) + " mm"};
  if (request.site.empty() || find_site(operation.plan.get(), request.site)) return std::nullopt;
  return Error{.what = "unknown approach",
               .where = "fit-clamp site",
               .found = request.site,
               .expected = "an outline or a trajectory of the plan",
               .remedy = "choose an approach of the plan, or omit it"};
}

ClampLimits FitClamp::limits(const ClampPlan& plan) const noexcept {
  ClampLimits limits = size_of(plan.model).limits;
  if (least_opening > 0) limits.least_opening = least_opening;
  if (most_opening > 0) limits.most_opening = most_opening;
  if (rocker_width > 0) limits.rocker_width = rocker_width;
  if (swing >= 0) limits.swing = swing;
  return limits;
}

const sim::JobType& fit_job() {
  static const sim::JobType job{&sim::value_type<FitClamp>(), run, is_current, adopt, check};
  return job;
}

const sim::Schema& ClampPlan::schema() {
  static constexpr sim::Field fields[] = {field<&ClampPlan::pins>("pins", {.unit = "mm"}),
                                          field<&ClampPlan::up>("up"),
                                          field<&ClampPlan::turn>("turn", {.unit = "degrees"}),
                                          field<&ClampPlan::model>("model", {.choices = k_clamp_models})};
  static constexpr sim::Schema table{"clamp-plan", 1, fields};
  return table;
}

const sim::Schema& FitClamp::schema() {
  static constexpr sim::Field fields[] = {
      field<&FitClamp::site>("site", {.help = "outline or trajectory of the approach; without it the first",
                                      .names = sim::FieldInfo::Names::approach,
                                      .empty_choice = "First of the plan"}),
      field<&FitClamp::least_opening>("least_opening",
                                      {.unit = "mm",
                                       .low = 0,
                                       .high = 400,
                                       .help = "smallest opening of the clamp; 0: that of the model",
                                       .is_expert = true}),
      field<&FitClamp::most_opening>("most_opening",
                                     {.unit = "mm",
                                      .low = 0,
                                      .high = 400,
                                      .help = "largest opening of the clamp; 0: that of the model",
                                      .is_expert = true}),
      field<&FitClamp::rocker_width>("rocker_width",
                                     {.unit = "mm",
                                      .low = 0,
                                      .high = 200,
                                      .help = "distance between the tips of the pair; 0: that of the model",
                                      .is_expert = true}),
      field<&FitClamp::swing>("swing", {.unit = "degrees",
                                        .low = -1,
                                        .high = 60,
                                        .help = "largest swing of the rocker; below 0: that of the model",
                                        .is_expert = true}),
      field<&FitClamp::item>("item", {.low = 0, .high = 63, .help = "shape of the bone", .is_expert = true})};
  static constexpr sim::Schema table{"fit-clamp", 1, fields};
  return table;
}

const sim::Schema& ClampFitted::schema() {
  static constexpr sim::Field fields[] = {
      field<&ClampFitted::is_fitted>("is_fitted"),
      field<&ClampFitted::planned>("planned", {.unit = "mm"}),
      field<&ClampFitted::tips>("tips", {.unit = "mm", .help = "pins on the outer table"}),
      field<&ClampFitted::origin>("origin", {.unit = "mm"}),
      field<&ClampFitted::axis>("axis"),
      field<&ClampFitted::across>("across"),
      field<&ClampFitted::opening>("opening", {.unit = "mm"}),
      field<&ClampFitted::swing>("swing", {.unit = "degrees"}),
      field<&ClampFitted::residuals>(
          "residuals", {.unit = "mm", .help = "distance of the planned position from the axis of its pin"}),
      field<&ClampFitted::gaps>("gaps", {.unit = "mm", .help = "distance along the pin to the outer table"}),
      field<&ClampFitted::thicknesses>("bone", {.unit = "mm", .help = "bone along each pin"}),
      field<&ClampFitted::scalps>("scalp", {.unit = "mm", .help = "tissue over the bone along each pin"}),
      field<&ClampFitted::arm_depth>("arm_depth", {.unit = "mm"}),
      field<&ClampFitted::touch_depth>("touch_depth",
                                       {.unit = "mm", .help = "depth of arms and rocker in the head"}),
      field<&ClampFitted::touch_length>("touch_length", {.unit = "mm"}),
      field<&ClampFitted::touch_at>("touch_at", {.unit = "mm"}),
      field<&ClampFitted::angles>(
          "angles", {.unit = "degrees", .help = "angle of the pin to the outer table; 90 is perpendicular"}),
      field<&ClampFitted::has_band>("has_band", {.help = "the plan defines the sweatband"}),
      field<&ClampFitted::band_normal>("band_normal"),
      field<&ClampFitted::heights>("heights", {.unit = "mm", .help = "height above the sweatband"}),
      field<&ClampFitted::centre>("centre", {.unit = "mm", .help = "centre of the skull"}),
      field<&ClampFitted::axis_miss>(
          "axis_miss", {.unit = "mm", .help = "distance of the centre from the axis of the clamp"}),
      field<&ClampFitted::pair_difference>("pair_difference", {.unit = "mm"}),
      field<&ClampFitted::nearest>("nearest", {.help = "forbidden structure nearest to a pin"}),
      field<&ClampFitted::clearance>("clearance",
                                     {.unit = "mm", .help = "distance of the tips from that structure"}),
      field<&ClampFitted::site>("site"),
      field<&ClampFitted::access>("access",
                                  {.unit = "mm", .help = "distance of the nearest pin from the approach"}),
      field<&ClampFitted::site_angle>(
          "site_angle", {.unit = "degrees", .help = "angle between the normal of the approach and up"}),
      field<&ClampFitted::rotation>("rotation", {.unit = "degrees", .help = "of the neck, to the left"}),
      field<&ClampFitted::flexion>("flexion", {.unit = "degrees"}),
      field<&ClampFitted::bend>("bend", {.unit = "degrees", .help = "of the neck, to the left"}),
      field<&ClampFitted::trouble>("trouble")};
  static constexpr sim::Schema table{"clamp-fitted", 1, fields};
  return table;
}

const sim::Schema& ClampTouchesHead::schema() {
  static constexpr sim::Field fields[] = {
      field<&ClampTouchesHead::depth>("depth", {.unit = "mm"}),
      field<&ClampTouchesHead::length>("length",
                                       {.unit = "mm", .help = "length of arms and rocker in the head"})};
  static constexpr sim::Schema table{"clamp-touches-head", 1, fields};
  return table;
}

const sim::Schema& ClampFailed::schema() {
  static constexpr sim::Field fields[] = {field<&ClampFailed::reason>("reason")};
  static constexpr sim::Schema table{"clamp-failed", 1, fields};
  return table;
}

}  // namespace trephine::skull_clamp
