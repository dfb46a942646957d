#include "modules/drilling/craniotome.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "modules/drilling/burr_tick.h"
#include "volume/base/axes.h"
#include "volume/base/text.h"

namespace trephine::drilling {

using glm::dvec3;
using sim::field;
using volume::ToolBody;
using volume::ToolPose;

namespace {

constexpr double k_foot_thickness = 0.8;  // mm, below the bit
constexpr double k_reach = 12;            // mm, largest distance of bone from the bit at the start
constexpr double k_edge = 0.05;           // mm, rounding of the bit's end
constexpr double k_core = 0.2;            // radius of the bit's core that must be free of bone, in diameters
constexpr double k_forward = 0.5;         // cosine: a motion at a larger angle to the heading is not allowed

Burr bit_of(const Craniotome& c) {
  return {.diameter = c.diameter,
          .is_round = true,
          .shape = Shape::cylinder,
          .grade = Grade::router,
          .rpm = c.rpm,
          .length = c.length};
}
ToolBody body_of(const Craniotome& c) { return ToolBody::cylinder(0.5 * c.diameter, c.length, k_edge); }

/// Returns eight unit vectors across a shaft.
std::array<dvec3, 8> directions_across(const dvec3& shaft) {
  const auto [a, b] = volume::perpendicular_axes(shaft);
  constexpr double k_half = 0.70710678118654752;
  return {a, b, -a, -b, k_half * (a + b), k_half * (a - b), -k_half * (a + b), k_half * (b - a)};
}

/// Returns true if the foot is free of bone. Like the contact balls, the foot has a round edge, which may
/// lean on bone. A sharp edge would be caught by an inner table that is not exactly perpendicular to the
/// shaft.
bool is_foot_free(const Craniotome& c, const ToolPose& at, const sim::Work& work) {
  constexpr double k_slack = 0.2;  // mm
  const double round = 0.5 * c.diameter;
  for (const double depth : {0.1, k_foot_thickness}) {
    const dvec3 middle = at.at_world - depth * at.axis_world;
    if (work.is_matter(middle)) return false;
    const double below = std::max(0.0, round - depth),
                 edge = 0.5 * c.foot - round + std::sqrt(round * round - below * below) - k_slack;
    for (const dvec3& direction : directions_across(at.axis_world))
      if (work.is_matter(middle + edge * direction)) return false;
  }
  return true;
}
/// Returns true if the bit's core is free of bone. The outer part of the bit may overlap bone, because the
/// touching body is thinner than the bit and may lean on a wall.
bool is_bit_free(const Craniotome& c, const ToolPose& at, const sim::Work& work) {
  for (double along = 0.25; along < c.length; along += 0.5)
    for (const dvec3& direction : directions_across(at.axis_world))
      if (work.is_matter(at.at_world + along * at.axis_world + k_core * c.diameter * direction)) return false;
  return true;
}
/// Returns true if there is bone above the foot's rim.
bool is_under_bone(const Craniotome& c, const ToolPose& at, const sim::Work& work) {
  for (double along = 0.5; along < c.length; along += 0.5)
    for (const dvec3& direction : directions_across(at.axis_world))
      if (work.is_matter(at.at_world + along * at.axis_world + 0.5 * c.foot * direction)) return true;
  return false;
}
bool has_bone_around(const Craniotome& c, const ToolPose& at, const sim::Work& work) {
  for (double along = 0.5; along < c.length; along += 0.5)
    for (double distance = 1; distance <= k_reach; distance += 0.5)
      for (const dvec3& direction : directions_across(at.axis_world))
        if (work.is_matter(at.at_world + along * at.axis_world + distance * direction)) return true;
  return false;
}

/// Returns the reason why the craniotome cannot start at a pose; empty if it can.
std::string reason_not_to_start(const Craniotome& c, const ToolPose& at, const sim::Work& work) {
  if (!is_bit_free(c, at, work)) return "the bit is in bone. Start in a burr hole.";
  if (!is_foot_free(c, at, work))
    return "the foot has no room under the bone. Widen the hole to its inner side.";
  if (!has_bone_around(c, at, work))
    return "there is no bone near the bit. Move it to the edge of a burr hole.";
  return {};
}

dvec3 across(const dvec3& v, const dvec3& shaft) { return v - glm::dot(v, shaft) * shaft; }

/// Returns true if there is bone on both sides of the heading.
bool is_in_kerf(const Craniotome& c, const ToolPose& at, const dvec3& heading, const sim::Work& work) {
  constexpr double k_beyond = 0.35;  // mm beyond the side of the bit
  const dvec3 aside = glm::cross(at.axis_world, heading);
  bool is_left = false, is_right = false;
  for (double along = 0.5; along < c.length && !(is_left && is_right); along += 0.5) {
    const dvec3 middle = at.at_world + along * at.axis_world;
    is_left = is_left || work.is_matter(middle + (0.5 * c.diameter + k_beyond) * aside);
    is_right = is_right || work.is_matter(middle - (0.5 * c.diameter + k_beyond) * aside);
  }
  return is_left && is_right;
}

/// Moves the bit to a tool that is drawn back, without a cut. Clears the heading of a bit outside its kerf,
/// so that the bit may cut in any direction.
void follow_back(const Craniotome& c, CraniotomeState& state, const ToolPose& tool, const sim::Work& work) {
  // mm. Shorter motions are ignored, because the touching body is thinner than the bit and moves in the kerf.
  constexpr double k_far = 0.3;
  if (!state.has_centre || state.heading == dvec3(0)) return;
  const dvec3 to = tool.at_world - state.centre;
  if (glm::length(to) > k_far && glm::dot(to, state.heading) <= 0)
    state.centre = tool.at_world, state.shaft = tool.axis_world;
  if (!is_in_kerf(c, {state.centre, state.shaft}, state.heading, work)) state.heading = dvec3(0);
}

void step(const Craniotome& c, CraniotomeState& state, const sim::InstrumentInput& input, sim::Work& work) {
  const haptics::ServoRecord& tick = input.tick;
  if (input.is_fresh || !tick.pose.is_pressed()) {
    CraniotomeState next;
    next.rise = state.rise, next.hottest = state.hottest;
    state = next;
  }
  if (!tick.pose.is_pressed() || state.is_refused) return;
  const ToolPose tool{tick.proxy_world, turned(shaft_of(tick.pose.orientation), tick.turn_world)};
  if (!state.has_started) {
    if (std::string reason = reason_not_to_start(c, tool, work); !reason.empty()) {
      state.is_refused = true;
      work.raise_event(CraniotomeRefused{std::move(reason)}, tool.at_world);
      return;
    }
    state.has_started = true;
  }
  follow_back(c, state, tool, work);
  // The foot stays below bone and limits the curvature of the bit's path. The positions of hand and proxy are
  // therefore projected onto the plane through the bit that contains its heading and its shaft.
  haptics::ServoRecord guided = tick;
  const dvec3 from = state.has_centre ? state.centre : tool.at_world;
  const dvec3 request = across(tick.pose.position_world - from, tool.axis_world);
  const double request_length = glm::length(request);
  if (state.heading != dvec3(0) && request_length > 1e-9) {
    // A pull across the heading only presses the bit against the wall of its kerf.
    const auto onto_heading = [&](const dvec3& at) {
      return at + glm::dot(at - from, state.heading) * state.heading - across(at - from, tool.axis_world);
    };
    if (glm::dot(request, state.heading) > 0) {
      guided.pose.position_world = onto_heading(tick.pose.position_world);
      guided.proxy_world = onto_heading(tick.proxy_world);
    }
  }
  const auto is_allowed = [&](const ToolPose& a, const ToolPose& b) {
    if (!is_foot_free(c, b, work) || !is_under_bone(c, b, work)) return false;
    // The bit cuts nothing backward or sideways: the middle of the bit may move only within 60 degrees of the
    // heading.
    const auto middle = [&](const ToolPose& at) { return at.at_world + 0.5 * c.length * at.axis_world; };
    const dvec3 motion = across(middle(b) - middle(a), a.axis_world);
    return state.heading == dvec3(0) || glm::dot(motion, state.heading) >= k_forward * glm::length(motion);
  };
  // The reference avoids an allocation.
  const std::function<bool(const ToolPose&, const ToolPose&)> is_motion_allowed = std::cref(is_allowed);
  const sim::InstrumentInput guided_input{guided, input.dt, input.is_fresh};
  const Burr bit = bit_of(c);
  BurrTick cut(bit, body_of(c), state, guided_input, work);
  cut.is_motion_allowed = &is_motion_allowed;
  cut.drill();
  cut.update_heat_and_breakthrough();
  // Only a motion that removed bone sets or turns the heading.
  if (!state.has_centre || work.removed().removed_units == 0) return;
  const dvec3 motion = across(state.centre - from, tool.axis_world);
  const double travel = glm::length(motion);
  if (travel <= 1e-9) return;
  if (state.heading == dvec3(0)) {
    state.heading = motion / travel;
  } else if (request_length > 1e-9 && glm::dot(motion, state.heading) > 0) {
    // Turn toward the request by as much as the tightest curve allows over this travel.
    const dvec3 aside = across(request / request_length, state.heading);
    const double size = glm::length(aside), max_turn = travel / c.turning_radius;
    if (size > 1e-9) state.heading = glm::normalize(state.heading + std::min(1.0, max_turn / size) * aside);
  }
}

sim::ToolBall body(const Craniotome& c, const CraniotomeState& state, const sim::InstrumentInput& input) {
  // The foot slides between bone and dura and strips the dura; the bit above never reaches that far.
  const sim::ToolBall bit = ball_around(bit_of(c), body_of(c), state, input);
  const dvec3 shaft = turned(shaft_of(input.tick.pose.orientation), input.tick.turn_world),
              end = bit.centre - body_of(c).middle() * shaft;
  return {end - 0.5 * k_foot_thickness * shaft, 0.5 * k_foot_thickness, true};
}

sim::ToolNeeds needs(const Craniotome& c, const volume::Volume& anatomy) {
  Burr bit = bit_of(c);
  const double radius = touch_radius(bit, anatomy);
  std::vector<haptics::ToolShape::Ball> balls;
  constexpr int k_bit_balls = static_cast<int>(haptics::ToolShape::k_max_balls) - 4;
  for (int i = 0; i < k_bit_balls; ++i)
    balls.push_back({{0, 0, radius + (c.length - 2 * radius) * i / (k_bit_balls - 1)}, radius});
  const double offset = 0.5 * c.foot - radius;
  for (const dvec3& direction : {dvec3(1, 0, 0), dvec3(-1, 0, 0), dvec3(0, 1, 0), dvec3(0, -1, 0)})
    balls.push_back({offset * direction - dvec3(0, 0, radius), radius});
  return {c.diameter, std::make_shared<const haptics::ToolShape>(std::move(balls))};
}

Status check(const Craniotome& c, const haptics::TouchScene& scene) {
  if (!(c.foot > c.diameter))
    return Error{.what = "the foot is not wider than the bit",
                 .where = "craniotome foot",
                 .found = rounded_text(c.foot) + " mm",
                 .expected = "more than " + rounded_text(c.diameter) + " mm"};
  if (!scene.tool->is_six_dof())
    return Error{.what = "a craniotome needs contact balls along its bit",
                 .where = "craniotome",
                 .found = "no balls",
                 .expected = "a tool of several balls",
                 .remedy = "take the craniotome with take-instrument, or begin the operation with it"};
  if (Status error = check_touch(needs(c, *scene.base), scene, "craniotome")) return error;
  if (c.length < 2 * c.diameter)
    return Error{.what = "the bit is too short for its width",
                 .where = "craniotome length",
                 .found = rounded_text(c.length) + " mm",
                 .expected = "at least " + rounded_text(2 * c.diameter) + " mm"};
  return check_body(body_of(c), true, scene);
}

sim::HandForces forces(const Craniotome&, const CraniotomeState&) { return spin_forces({0.3, 0.1, 80}); }

}  // namespace

const sim::Schema& Craniotome::schema() {
  static constexpr sim::Field fields[] = {
      field<&Craniotome::diameter>(
          "diameter",
          {.unit = "mm", .low = 0.8, .high = 5, .help = "diameter of the bit", .label = "Bit diameter"}),
      field<&Craniotome::length>(
          "length", {.unit = "mm", .low = 4, .high = 30, .help = "length of the bit", .label = "Bit length"}),
      field<&Craniotome::foot>(
          "foot",
          {.unit = "mm", .low = 1, .high = 12, .help = "diameter of the foot", .label = "Foot diameter"}),
      field<&Craniotome::turning_radius>("turning_radius", {.unit = "mm",
                                                            .low = 0.5,
                                                            .high = 200,
                                                            .help = "radius of the tightest curve",
                                                            .label = "Tightest curve",
                                                            .is_expert = true}),
      field<&Craniotome::rpm>(
          "rpm",
          {.unit = "1/min", .low = 100, .high = 5e5, .help = "speed of the spindle", .label = "Speed"})};
  static constexpr sim::Schema table{"craniotome", 1, fields};
  return table;
}

const sim::Schema& CraniotomeState::schema() {
  static const std::vector<sim::Field> fields =
      joined(BurrState::schema().fields, {field<&CraniotomeState::has_started>("has_started"),
                                          field<&CraniotomeState::is_refused>("is_refused"),
                                          field<&CraniotomeState::heading>("heading")});
  static const sim::Schema table{"craniotome-state", 1, fields};
  return table;
}

const sim::Schema& CraniotomeRefused::schema() {
  static constexpr sim::Field fields[] = {field<&CraniotomeRefused::reason>("reason")};
  static constexpr sim::Schema table{"craniotome-refused", 1, fields};
  return table;
}

const sim::InstrumentType& craniotome_type() noexcept {
  return sim::instrument_type<step, check, body, needs, forces>();
}
sim::Instrument craniotome(const Craniotome& parameters) { return {craniotome_type(), parameters}; }

}  // namespace trephine::drilling
