#include "modules/drilling/perforator.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "modules/drilling/burr_tick.h"
#include "volume/base/axes.h"
#include "volume/base/text.h"
#include "volume/scan/bone_labels.h"

namespace trephine::drilling {

using glm::dvec3;
using sim::field;
using volume::ToolBody;

namespace {

constexpr double k_min_depth = 1;              // mm of bone before the clutch may release
constexpr double k_hole_step = 0.25;           // mm between the points at which a hole is measured
constexpr double k_hole_gap = 1;               // mm of air inside the bone that a hole may cross
constexpr double k_max_hole = 40;              // mm, longest hole that is measured
constexpr double k_ahead[] = {0.3, 0.8, 1.3};  // mm ahead of the end at which bone holds the inner drill
// The floor that a round end leaves in the hole breaks out when the clutch releases, and the surgeon lifts it
// out: within this share of the inner drill's radius, up to this thickness (mm) below the tip.
constexpr double k_floor = 0.5, k_floor_thickness = 1.5;
// Directions around the axis, and the share of the inner drill's radius at which its end is examined.
constexpr double k_diagonal = 0.7071067811865476, k_share = 0.5;
constexpr double k_around[][2] = {{1, 0},  {k_diagonal, k_diagonal},   {0, 1},  {-k_diagonal, k_diagonal},
                                  {-1, 0}, {-k_diagonal, -k_diagonal}, {0, -1}, {k_diagonal, -k_diagonal}};

Burr inner_of(const Perforator& p) { return {.diameter = p.inner, .is_round = true, .rpm = 1000}; }
/// Returns the body of the outer drill, which is behind the end of the inner one by the lead.
ToolBody outer_of(const Perforator& p) { return ToolBody::cylinder(0.5 * p.diameter, p.diameter, 0.3); }

dvec3 tip_of(const Perforator& p, const PerforatorState& state) {
  return state.centre - 0.5 * p.inner * state.shaft;
}

/// Returns true if there is bone ahead of a point on the drill's end. A voxel whose label names soft tissue
/// does not count as bone, whatever its intensity.
bool has_bone_ahead(const dvec3& end, const dvec3& shaft, const sim::Work& work) {
  return std::any_of(std::begin(k_ahead), std::end(k_ahead), [&](double ahead) {
    const dvec3 at = end - ahead * shaft;
    return work.is_matter(at) && !volume::has_soft_label(work.remaining().base(), at);
  });
}

/// Returns true if a point on the drill's end has been in bone. On a tilted surface, a part of the end is
/// still outside while the tip drills. This part must not release the clutch.
bool has_entered(const dvec3& end, const dvec3& shaft, const sim::Work& work) {
  constexpr double k_farthest = 6;  // mm behind the end
  for (double back = 0; back <= k_farthest; back += k_hole_step)
    if (work.is_removed_matter(end + back * shaft)) return true;
  return false;
}

/// Returns true if bone holds the inner drill: there is bone ahead of its tip, and more than half of the
/// points around its end have bone ahead or have not been in bone. A small area of thicker bone does not hold
/// a drill whose end is otherwise through.
bool is_held(const Perforator& p, const PerforatorState& state, const sim::Work& work) {
  if (!has_bone_ahead(tip_of(p, state), state.shaft, work)) return false;
  const dvec3 u = glm::normalize(
                  glm::cross(state.shaft, std::abs(state.shaft.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0))),
              v = glm::cross(state.shaft, u);
  const double radius = 0.5 * p.inner, aside = k_share * radius;
  const double back = std::sqrt(radius * radius - aside * aside);
  const auto count = std::count_if(std::begin(k_around), std::end(k_around), [&](const double(&around)[2]) {
    const dvec3 end = state.centre + aside * (around[0] * u + around[1] * v) - back * state.shaft;
    return has_bone_ahead(end, state.shaft, work) || !has_entered(end, state.shaft, work);
  });
  return 2 * static_cast<std::size_t>(count) > std::size(k_around);
}

/// Returns the length of the hole behind the tip, in mm: bone that was removed along the shaft. The length is
/// measured and not stored, because the state of the drill ends with each stroke, and a hole may be continued
/// after a pause.
double hole_behind(const dvec3& tip, const dvec3& shaft, const sim::Work& work) {
  double length = 0;
  for (double back = 0; back < k_max_hole && back <= length + k_hole_gap; back += k_hole_step)
    if (work.is_removed_matter(tip + back * shaft)) length = back;
  return length;
}

/// Removes the floor of the hole: the matter around the round end, and a rest below its tip that is thin. The
/// rest has labels of soft tissue, or is less than is_held() notices. `needs_rest`: removes nothing if there
/// is no such rest.
void break_floor(const Perforator& p, const PerforatorState& state, sim::Work& work, bool needs_rest) {
  const double radius = k_floor * 0.5 * p.inner;
  const auto [u, v] = volume::perpendicular_axes(state.shaft);
  const dvec3 tip = tip_of(p, state);
  double depth = 0;
  // Matter that begins at the plane of the tip and ends within the thickness. Thicker bone is no floor.
  const auto search = [&](const dvec3& at) {
    double end = 0;
    for (double ahead = k_hole_step; ahead <= end + 2 * k_hole_step; ahead += k_hole_step)
      if (work.is_matter(at - ahead * state.shaft)) end = ahead;
    if (end <= k_floor_thickness) depth = std::max(depth, end);
  };
  search(tip);
  for (const double(&around)[2] : k_around) search(tip + radius * (around[0] * u + around[1] * v));
  if (depth > 0)
    depth += k_hole_step;
  else if (needs_rest)
    return;
  const ToolBody floor = ToolBody::cylinder(radius, p.inner, 0.3);
  const volume::ToolPose pose{tip - depth * state.shaft, state.shaft};
  work.remove(volume::ToolSweep{floor, pose, pose, false});
}

void stop(PerforatorState& state, const PerforatorStopped& event, const dvec3& tip, sim::Work& work) {
  state.has_stopped = true;
  work.raise_event(event, tip);
}

void step(const Perforator& p, PerforatorState& state, const sim::InstrumentInput& input, sim::Work& work) {
  if (input.is_fresh || !input.tick.pose.is_pressed()) state = PerforatorState{};
  if (!input.tick.pose.is_pressed() || state.has_stopped) return;
  Burr inner = inner_of(p);
  const ToolBody ball = ToolBody::ball(0.5 * p.inner), outer = outer_of(p);
  const double press = BurrTick(inner, ball, state, input, work).press();
  // Without contact the drill has no position; a contact elsewhere starts a new hole.
  if (!input.tick.has_contact) state.has_centre = false;
  if (!state.has_centre && glm::length(input.tick.proxy_world - state.centre) > 0.5 * p.inner)
    state.has_begun = false;
  if (press < p.engage_force || !input.tick.has_contact) return;
  if (!state.has_begun) {
    // In a hole that is already through the bone, the clutch does not engage: the drill stops at once. A thin
    // floor that was left there breaks out.
    PerforatorState start = state;
    if (!start.has_centre)
      start.centre = input.tick.proxy_world, start.shaft = shaft_of(input.tick.pose.orientation);
    const double depth = hole_behind(tip_of(p, start), start.shaft, work);
    if (depth >= k_min_depth && !is_held(p, start, work)) {
      break_floor(p, start, work, true);
      return stop(state, {depth, true}, tip_of(p, start), work);
    }
  }
  inner.removal_rate = p.feed * press * std::numbers::pi * outer.radius * outer.radius;
  const double outer_offset = p.lead - 0.5 * p.inner;  // from the ball's centre to the outer drill's end
  const volume::ToolPose previous{state.centre, state.shaft};
  const bool continues = state.has_centre;
  BurrTick(inner, ball, state, input, work).drill();
  if (!state.has_centre) return;
  const auto outer_pose = [&](const volume::ToolPose& at) {
    return volume::ToolPose{at.at_world + outer_offset * at.axis_world, at.axis_world};
  };
  const volume::ToolPose current{state.centre, state.shaft};
  if (!continues || glm::length(current.at_world - previous.at_world) > 0)
    state.removal_budget_mm3 -= work.remaining().mm3_of(
        work.remove(volume::ToolSweep{outer, outer_pose(continues ? previous : current), outer_pose(current),
                                      continues})
            .removed_units);
  const dvec3 tip = tip_of(p, state);
  if (!state.has_begun && work.removed().removed_units > 0)
    state.has_begun = true, state.begun_tip = tip + hole_behind(tip, state.shaft, work) * state.shaft;
  const double depth = glm::dot(state.begun_tip - tip, state.shaft);
  if (!state.has_begun || depth < k_min_depth || is_held(p, state, work)) return;
  break_floor(p, state, work, false);
  stop(state, {depth, false}, tip, work);
}

sim::ToolBall body(const Perforator& p, const PerforatorState& state, const sim::InstrumentInput& input) {
  // While the drill cuts, the ball is at the last cut. After the stop, it rests on the remaining bone.
  Burr inner = inner_of(p);
  inner.removal_rate = p.feed;
  BurrState position = state;
  position.has_centre = state.has_centre && !state.has_stopped;
  sim::ToolBall ball = ball_around(inner, ToolBody::ball(0.5 * p.inner), position, input);
  ball.is_blunt = state.has_stopped;  // a stopped drill no longer turns
  return ball;
}

sim::ToolNeeds needs(const Perforator& p, const volume::Volume& anatomy) {
  return {p.inner, std::make_shared<const haptics::ToolShape>(touch_radius(inner_of(p), anatomy))};
}

Status check(const Perforator& p, const haptics::TouchScene& scene) {
  if (!(p.inner < p.diameter))
    return Error{.what = "the inner drill is not smaller than the outer drill",
                 .where = "perforator inner",
                 .found = rounded_text(p.inner) + " mm",
                 .expected = "less than " + rounded_text(p.diameter) + " mm"};
  if (!(scene.tool->radius() > 0) || scene.tool->is_six_dof())
    return Error{.what = "a perforator needs one contact ball",
                 .where = "perforator",
                 .found = scene.tool->is_six_dof() ? "several balls" : "a point",
                 .expected = "a tool of one ball",
                 .remedy = "take the perforator with take-instrument, or begin the operation with it"};
  if (Status error = check_touch(needs(p, *scene.base), scene, "perforator")) return error;
  return check_body(ToolBody::ball(0.5 * p.inner), true, scene);
}

sim::HandForces forces(const Perforator&, const PerforatorState&) { return spin_forces({0.05, 0.1, 25}); }

}  // namespace

const sim::Schema& Perforator::schema() {
  static constexpr sim::Field fields[] = {
      field<&Perforator::diameter>("diameter", {.unit = "mm",
                                                .low = 4,
                                                .high = 20,
                                                .help = "diameter of the outer drill",
                                                .label = "Outer diameter"}),
      field<&Perforator::inner>("inner", {.unit = "mm",
                                          .low = 2,
                                          .high = 12,
                                          .help = "diameter of the inner drill, which has a round end",
                                          .label = "Inner diameter"}),
      field<&Perforator::lead>("lead", {.unit = "mm",
                                        .low = 0.5,
                                        .high = 6,
                                        .help = "distance by which the inner drill is ahead",
                                        .label = "Lead of the inner drill",
                                        .is_expert = true}),
      field<&Perforator::feed>("feed", {.unit = "mm/s/N",
                                        .low = 1e-3,
                                        .high = 10,
                                        .help = "feed per newton of contact force",
                                        .label = "Feed per newton",
                                        .is_expert = true}),
      field<&Perforator::engage_force>("engages", {.unit = "N",
                                                   .low = 0,
                                                   .high = 20,
                                                   .help = "contact force above which the clutch engages",
                                                   .label = "Engaging force",
                                                   .is_expert = true})};
  static constexpr sim::Schema table{"perforator", 1, fields};
  return table;
}

const sim::Schema& PerforatorState::schema() {
  static const std::vector<sim::Field> fields =
      joined(BurrState::schema().fields, {field<&PerforatorState::has_begun>("has_begun"),
                                          field<&PerforatorState::has_stopped>("has_stopped"),
                                          field<&PerforatorState::begun_tip>("begun_tip", {.unit = "mm"})});
  static const sim::Schema table{"perforator-state", 1, fields};
  return table;
}

const sim::Schema& PerforatorStopped::schema() {
  static constexpr sim::Field fields[] = {
      field<&PerforatorStopped::depth>("depth", {.unit = "mm", .help = "depth of the hole in bone"}),
      field<&PerforatorStopped::was_open>("was_open", {.help = "the hole was through the bone before"})};
  static constexpr sim::Schema table{"perforator-stopped", 2, fields};
  return table;
}

const sim::InstrumentType& perforator_type() noexcept {
  return sim::instrument_type<step, check, body, needs, forces>();
}
sim::Instrument perforator(const Perforator& parameters) { return {perforator_type(), parameters}; }

}  // namespace trephine::drilling
