#include "modules/drilling/perforator.h"

#include <glm/geometric.hpp>
#include <numbers>

#include "modules/drilling/burr_tick.h"

namespace trephine::drilling {

using glm::dvec3;
using sim::field;
using volume::ToolBody;

namespace {

constexpr double k_least_depth = 1;            // mm of bone before the clutch may let go
constexpr double k_ahead[] = {0.3, 0.8, 1.3};  // mm ahead of the tip where the inner drill is held by bone

Burr inner_of(const Perforator& p) { return {.diameter = p.inner, .is_round = true, .rpm = 1000}; }
/// Behind the inner one's end by the lead.
ToolBody outer_of(const Perforator& p) { return ToolBody::cylinder(0.5 * p.diameter, p.diameter, 0.3); }

dvec3 tip_of(const Perforator& p, const PerforatorState& state) {
  return state.centre - 0.5 * p.inner * state.shaft;
}

/// Does bone hold the inner drill?
bool is_held(const Perforator& p, const PerforatorState& state, const sim::Work& work) {
  const dvec3 tip = tip_of(p, state);
  for (const double ahead : k_ahead)
    if (work.is_matter(tip - ahead * state.shaft)) return true;
  return false;
}

void step(const Perforator& p, PerforatorState& state, const sim::InstrumentInput& input, sim::Work& work) {
  if (input.is_fresh || !input.tick.pose.is_pressed()) state = PerforatorState{};
  if (!input.tick.pose.is_pressed() || state.has_stopped) return;
  Burr inner = inner_of(p);
  const ToolBody ball = ToolBody::ball(0.5 * p.inner), outer = outer_of(p);
  const double press = BurrTick(inner, ball, state, input, work).press();
  // In the air it has no place; set down elsewhere it begins again.
  if (!input.tick.has_contact) state.has_centre = false;
  if (!state.has_centre && glm::length(input.tick.proxy_world - state.centre) > 0.5 * p.inner)
    state.has_begun = false;
  if (press < p.engages || !input.tick.has_contact) return;
  inner.removal_rate = p.feed * press * std::numbers::pi * outer.radius * outer.radius;
  const double up = p.lead - 0.5 * p.inner;  // from the ball's middle to the outer drill's end
  const volume::ToolPlace before{state.centre, state.shaft};
  const bool goes_on = state.has_centre;
  BurrTick(inner, ball, state, input, work).drill();
  if (!state.has_centre) return;
  const auto behind = [&](const volume::ToolPlace& at) {
    return volume::ToolPlace{at.at_world + up * at.axis_world, at.axis_world};
  };
  const volume::ToolPlace now{state.centre, state.shaft};
  if (!goes_on || glm::length(now.at_world - before.at_world) > 0)
    state.owed_mm3 -= work.left().mm3_of(
        work.remove(volume::ToolSweep{outer, behind(goes_on ? before : now), behind(now), goes_on})
            .removed_units);
  if (!state.has_begun && work.removed().removed_units > 0)
    state.has_begun = true, state.begun_tip = tip_of(p, state);
  const double depth = glm::dot(state.begun_tip - tip_of(p, state), state.shaft);
  if (!state.has_begun || depth < k_least_depth || is_held(p, state, work)) return;
  state.has_stopped = true;
  work.raise_event(PerforatorStopped{depth}, tip_of(p, state));
}

sim::ToolBall body(const Perforator& p, const PerforatorState& state, const sim::InstrumentInput& input) {
  return ball_around(inner_of(p), ToolBody::ball(0.5 * p.inner), state, input);
}

sim::ToolNeeds needs(const Perforator& p, const volume::Volume& anatomy) {
  return {p.inner, touch_radius(inner_of(p), anatomy), {}};
}

volume::Status check(const Perforator& p, const haptics::TouchScene& scene) {
  if (!(p.inner < p.diameter))
    return volume::Error{"the inner drill is no smaller than the outer one", "perforator inner",
                         std::to_string(p.inner) + " mm", "less than " + std::to_string(p.diameter) + " mm",
                         ""};
  if (!(scene.tool_radius > 0) || !scene.tool_balls.empty())
    return volume::Error{"a perforator needs one ball to touch with", "perforator",
                         scene.tool_balls.empty() ? "a point" : "several balls", "a tool of one ball",
                         "begin the operation with it"};
  if (volume::Status error = check_touch(needs(p, *scene.base), scene, "perforator")) return error;
  return check_body(ToolBody::ball(0.5 * p.inner), true, scene);
}

std::string effect(const Perforator&) { return "spin drag=0.05 chatter=0.1 frequency=25"; }

}  // namespace

const sim::Schema& Perforator::schema() {
  static constexpr sim::Field fields[] = {
      field<&Perforator::diameter>(
          "diameter",
          {.unit = "mm", .low = 4, .high = 20, .help = "of the outer drill", .label = "Outer diameter"}),
      field<&Perforator::inner>("inner", {.unit = "mm",
                                          .low = 2,
                                          .high = 12,
                                          .help = "of the inner drill, round at its end",
                                          .label = "Inner diameter"}),
      field<&Perforator::lead>("lead", {.unit = "mm",
                                        .low = 0.5,
                                        .high = 6,
                                        .help = "of the inner drill",
                                        .label = "Lead of the inner drill",
                                        .is_expert = true}),
      field<&Perforator::feed>("feed", {.unit = "mm/s/N",
                                        .low = 1e-3,
                                        .high = 10,
                                        .help = "for each newton of press",
                                        .label = "Feed per newton",
                                        .is_expert = true}),
      field<&Perforator::engages>("engages", {.unit = "N",
                                              .low = 0,
                                              .high = 20,
                                              .help = "press that the clutch needs to hold",
                                              .label = "Press that engages",
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
      field<&PerforatorStopped::depth>("depth", {.unit = "mm", .help = "of bone that it went through"})};
  static constexpr sim::Schema table{"perforator-stopped", 1, fields};
  return table;
}

const sim::InstrumentType& perforator_type() noexcept {
  return sim::instrument_type<step, check, body, needs, effect>();
}
sim::Instrument perforator(const Perforator& parameters) { return {perforator_type(), parameters}; }

}  // namespace trephine::drilling
