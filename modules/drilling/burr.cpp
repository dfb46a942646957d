#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "modules/drilling/burr_tick.h"
#include "modules/drilling/craniotome.h"
#include "modules/drilling/perforator.h"
#include "volume/base/text.h"
#include "volume/fields/offset_field.h"

namespace trephine::drilling {

using glm::dvec3;
using volume::ToolBody;
using volume::ToolPose;

namespace {
// Longest path of the HIP without contact, in voxel diagonals, after which the contact still continues.
constexpr double k_memory_voxels = 1.5;
constexpr double k_credit_seconds = 0.02;  // largest saved removal budget, in seconds of removal
constexpr double k_pi = 3.14159265358979323846;
constexpr double k_engaged_mm = 0.02;     // path over which the engaged cross-section is measured
constexpr double k_step_mm = 0.05;        // largest bite; each bite is charged to the budget
constexpr double k_turn_cosine = 0.7071;  // a normal at a larger angle to the axis of approach turns it
constexpr double k_turn_seconds = 0.25;   // time constant of this turn if the HIP is a radius deep
constexpr double k_thrust_seconds = 0.1;  // time constant of the smoothed thrust
constexpr double k_pore_mm = 2;           // a shallower plunge that ends in contact was a pore
constexpr double k_bored_mm = 0.5;        // least depth of cut bone for a breakthrough
constexpr double k_retreat_mm = 0.5;      // return of the hand that ends a plunge; least reported plunge
constexpr double k_plunge_seconds = 1;    // longest plunge

/// Returns the vector from a body's origin (`along` 0) to its farthest point in the direction -`out`; for a
/// drum, to the centre of its end face.
dvec3 lowest_point(const ToolBody& body, const dvec3& shaft, const dvec3& out) noexcept {
  if (body.is_ball()) return -body.radius * out;
  // The lowest point of a drum would jump from rim to rim at the slightest tilt. Its origin is the centre of
  // its end face.
  if (body.form == ToolBody::Form::drum) return dvec3(0);
  const double rise = -glm::dot(out, shaft);
  const ToolBody::Support support = body.support(rise);
  const dvec3 across = -out - rise * shaft;
  const double length = glm::length(across);
  return support.along * shaft + (length > 1e-9 ? support.off / length : 0) * across;
}

}  // namespace

dvec3 shaft_of(const glm::dquat& hand) noexcept {
  return glm::normalize(glm::normalize(hand) * dvec3(0, 0, 1));
}

dvec3 turned(const dvec3& shaft, const dvec3& turn) noexcept {
  const dvec3 half = 0.5 * turn;
  const double square = std::min(1.0, glm::dot(half, half));
  const dvec3 twice = 2.0 * glm::cross(half, shaft);
  return glm::normalize(shaft + std::sqrt(1 - square) * twice + glm::cross(half, twice));
}

BurrTick::BurrTick(const Burr& burr, const ToolBody& body, BurrState& state,
                   const sim::InstrumentInput& input, sim::Work& work)
    : burr_(burr),
      body_(body),
      state_(state),
      tick_(input.tick),
      dt_(input.dt),
      work_(work),
      hand_shaft_(shaft_of(tick_.pose.orientation)) {}

double BurrTick::press() const noexcept {
  if (!tick_.has_contact) return 0;
  // A tool of several balls has no single contact normal: the magnitude of the contact force is used. For
  // other tools, the component of the force along the normal is used.
  return glm::dot(tick_.normal_world, tick_.normal_world) > 0
             ? std::max(0.0, glm::dot(tick_.contact_force_world, tick_.normal_world))
             : glm::length(tick_.contact_force_world);
}

Cutting BurrTick::cutting() const noexcept {
  return {burr_.grade, burr_.radius(), burr_.rpm, press(), state_.engaged, !burr_.is_dry};
}

/// Moves the body to `pose`. Returns the removed volume, mm^3; under force control, the volume of reference
/// bone whose removal takes the same energy.
double BurrTick::sweep_to(const ToolPose& pose) {
  const ToolPose from = state_.has_centre ? ToolPose{state_.centre, state_.shaft} : pose;
  const volume::RemovalReport report =
      body_.is_ball()
          ? work_.remove(volume::Sweep{from.at_world, pose.at_world, body_.radius, state_.has_centre})
          : work_.remove(volume::ToolSweep{body_, from, pose, state_.has_centre});
  const double mm3 = work_.remaining().mm3_of(report.removed_units);
  // Engaged cross-section: the removed volume divided by its path, of at least k_engaged_mm. The result is at
  // most the cross-section of the body.
  state_.bite_mm3 += mm3;
  state_.bite_mm += travel_between(from, pose);
  if (!state_.has_centre) state_.bite_mm3 = state_.bite_mm = state_.engaged = 0;
  if (state_.bite_mm >= k_engaged_mm) {
    const double r = body_.radius, side = 2 * r * (body_.high() - body_.low());
    state_.engaged = std::min(state_.bite_mm3 / state_.bite_mm, std::max(k_pi * r * r, side));
    state_.bite_mm3 = state_.bite_mm = 0;
  }
  state_.centre = pose.at_world;
  state_.shaft = pose.axis_world;
  state_.has_centre = true;
  return is_force_controlled() ? mm3 * relative_energy(report, work_.remaining().base()) : mm3;
}

void BurrTick::turn_axis() noexcept {
  // The axis of approach starts as the normal of the first contact. If the current normal differs from the
  // axis by more than 45 degrees, a new contact replaces the axis by the normal, and a continued contact
  // turns the axis toward the normal.
  const dvec3& normal = tick_.normal_world;
  const double cosine = glm::dot(state_.axis, normal);
  if (cosine >= k_turn_cosine) return;
  if (!state_.has_centre) {
    state_.axis = normal;
  } else if (cosine > -0.99) {
    const double depth = glm::dot(tick_.proxy_world - tick_.pose.position_world, normal) / burr_.radius();
    state_.axis = glm::normalize(state_.axis + dt_ / k_turn_seconds * std::clamp(depth, 0.0, 1.0) * normal);
  }
}

/// Returns the pose of the body on the surface on which the proxy rests.
ToolPose BurrTick::pose_at_proxy() const noexcept {
  if (burr_.is_round) return {tick_.proxy_world, turned(hand_shaft_, tick_.turn_world)};
  return {tick_.proxy_world - lowest_point(body_, hand_shaft_, state_.axis), hand_shaft_};
}
/// Returns the pose of the body with its lowest point on the HIP.
ToolPose BurrTick::pose_at_hand() const noexcept {
  const dvec3& hip = tick_.pose.position_world;
  return {burr_.is_round ? hip : hip - lowest_point(body_, hand_shaft_, state_.axis), hand_shaft_};
}

/// Returns the travel of the body, mm: the larger of the path of its origin and the path of its farther end
/// by the rotation alone.
double BurrTick::travel_between(const ToolPose& from, const ToolPose& to) const noexcept {
  const double travel = glm::length(to.at_world - from.at_world);
  if (body_.is_ball()) return travel;
  return std::max(travel, std::max(std::abs(body_.low()), std::abs(body_.high())) *
                              glm::length(to.axis_world - from.axis_world));
}

/// Moves the body toward `to` in bites while the budget lasts, by at most `limit` mm. Reduces `limit` by the
/// planned travel, even if the budget ends the motion earlier.
void BurrTick::advance_to(const ToolPose& to, double& limit) {
  const ToolPose from{state_.centre, state_.shaft};
  const double travel = travel_between(from, to), length = std::min(travel, limit);
  if (length <= 1e-9) return;
  limit -= length;
  const int bites = std::max(1, static_cast<int>(std::ceil(length / k_step_mm)));
  for (int i = 1; i <= bites && state_.removal_budget_mm3 > 0; ++i) {
    const ToolPose next = volume::between(from, to, length / travel * i / bites);
    if (is_motion_allowed && !(*is_motion_allowed)({state_.centre, state_.shaft}, next)) return;
    state_.removal_budget_mm3 -= sweep_to(next);
  }
}

/// Moves the body along the segment from the proxy to the hand, as far as the budget lasts. If the proxy slid
/// along the surface, the body is off this segment and first moves to the nearest point of it. If it is
/// farther than a diameter from the segment, it starts again at the proxy in the next tick.
void BurrTick::follow(double limit) {
  const ToolPose proxy = pose_at_proxy(), hand = pose_at_hand();
  const dvec3 segment = hand.at_world - proxy.at_world;
  const double square = glm::dot(segment, segment);
  const double share =
      square > 0 ? std::clamp(glm::dot(state_.centre - proxy.at_world, segment) / square, 0.0, 1.0) : 0;
  const ToolPose nearest = volume::between(proxy, hand, share);
  const double offset = glm::length(nearest.at_world - state_.centre);
  if (offset > burr_.diameter) {
    state_.has_centre = false;
    return;
  }
  double travel = limit * dt_;
  if (offset > k_step_mm) advance_to(nearest, travel);
  if (offset <= k_step_mm || glm::length(nearest.at_world - state_.centre) <= k_step_mm)
    advance_to(hand, travel);
}

void BurrTick::drill() {
  const dvec3& hip = tick_.pose.position_world;
  if (burr_.is_kinematic) {
    sweep_to({hip, hand_shaft_});
    return;
  }
  // The burr removes the voxels in front of the HIP, and the touchable walls of the cut may be wrong by up to
  // a voxel. Contact is therefore intermittent. The burr counts as in contact while it cuts, and over a short
  // path of the HIP afterwards.
  state_.free_mm = tick_.has_contact ? 0 : state_.free_mm + glm::length(hip - state_.hip);
  state_.hip = hip;
  if (state_.free_mm > k_memory_voxels * work_.remaining().base().frame.diagonal_mm())
    state_.has_centre = false;
  if (!tick_.has_contact && !state_.has_centre) return;
  const Cutting conditions = cutting();
  const double rate = is_force_controlled() ? drilling::removal_rate(conditions) : burr_.removal_rate;
  state_.removal_budget_mm3 =
      std::min(state_.removal_budget_mm3 + rate * dt_, rate * (k_credit_seconds + dt_));
  if (tick_.has_contact) {
    if (!burr_.is_round) turn_axis();  // the axis of a round burr stays 0
    // The contact ball is slightly smaller than the cutting body, so that a touching burr overlaps bone.
    const ToolPose proxy = pose_at_proxy();
    // A body with restricted motion starts at the proxy without a cut: it removes bone only by allowed
    // motions.
    if (!state_.has_centre && is_motion_allowed)
      state_.centre = proxy.at_world, state_.shaft = proxy.axis_world, state_.has_centre = true;
    else if (!state_.has_centre && (!is_force_controlled() || state_.removal_budget_mm3 > 0))
      state_.removal_budget_mm3 -= sweep_to(proxy);
  }
  if (state_.has_centre && is_force_controlled() && tick_.has_contact) {
    follow(std::min(burr_.feed_limit, drilling::feed_limit(conditions)));
  } else if (state_.has_centre) {
    double travel = burr_.feed_limit * dt_;
    advance_to(pose_at_hand(), travel);
  }
  if (work_.removed().removed_units > 0) state_.free_mm = 0;
}

void BurrTick::update_heat_and_breakthrough() {
  const bool is_working = tick_.pose.is_pressed() && !burr_.is_kinematic;
  Cutting conditions = cutting();
  if (!is_working) conditions.press = 0;
  const Warming warm = warming(conditions);
  state_.rise += (warm.rise - state_.rise) * std::min(1.0, dt_ / warm.seconds);
  state_.hottest = std::max(state_.hottest, state_.rise);

  const double beyond = glm::dot(state_.held_at - tick_.pose.position_world, state_.held_normal);
  if (state_.is_through) {
    state_.seconds += dt_;
    if (beyond > state_.deepest) state_.deepest = beyond, state_.deepest_at = state_.seconds;
    const bool is_pore = tick_.has_contact && state_.deepest < k_pore_mm;
    if (!is_pore && is_working && !tick_.has_contact && state_.seconds < k_plunge_seconds &&
        beyond > state_.deepest - k_retreat_mm)
      return;
    if (!is_pore && state_.deepest > k_retreat_mm)
      work_.raise_event(Breakthrough{state_.thrust, state_.deepest, state_.deepest_at}, state_.held_at);
    state_.is_through = false;
    state_.held_normal = dvec3(0);
    return;
  }
  if (!is_working) {
    state_.held_normal = dvec3(0);
    state_.thrust = 0;
  } else if (tick_.has_contact) {
    state_.thrust += (conditions.press - state_.thrust) * std::min(1.0, dt_ / k_thrust_seconds);
    if (work_.removed().removed_units > 0) {
      if (state_.held_normal == dvec3(0)) state_.begun_at = tick_.proxy_world;
      state_.held_at = tick_.proxy_world, state_.held_normal = tick_.normal_world;
    }
  } else if (state_.held_normal != dvec3(0) && !state_.has_centre) {
    // The contact ended. This is a breakthrough if the HIP is beyond the last cut and the bore is deeper than
    // k_bored_mm. Otherwise the burr left a rim, for example.
    const double bored = glm::dot(state_.begun_at - state_.held_at, state_.held_normal);
    if (beyond > 0 && bored > k_bored_mm) {
      state_.is_through = true;
      state_.deepest = beyond, state_.seconds = state_.deepest_at = 0;
    } else {
      state_.held_normal = dvec3(0);
    }
  }
}

/// Without contact, the direction to the lowest point of the body is unknown. For a burr that is not round,
/// the result is then a ball of radius 0 at the proxy.
sim::ToolBall ball_around(const Burr& burr, const ToolBody& body, const BurrState& state,
                          const sim::InstrumentInput& input) {
  const haptics::ServoRecord& tick = input.tick;
  const auto ball_at = [&](const dvec3& at, const dvec3& shaft) {
    return sim::ToolBall{at + (body.is_ball() ? 0 : body.middle()) * shaft, body.reach()};
  };
  const dvec3 shaft = shaft_of(tick.pose.orientation);
  // Under force control and in contact, the body is at the proxy or follows the proxy.
  const bool follows_proxy = burr.removal_rate == 0 && tick.has_contact;
  if (state.has_centre && !follows_proxy) return ball_at(state.centre, state.shaft);
  if (burr.is_kinematic) return ball_at(tick.pose.position_world, shaft);
  // The contact ball is smaller than the body. A body that rests on the surface therefore has its centre
  // above the proxy by the difference of the radii.
  const bool is_smaller = body.is_ball() && tick.has_contact && input.contact_radius > 0;
  const double above = is_smaller ? std::max(0.0, body.radius - input.contact_radius) : 0;
  if (burr.is_round)
    return ball_at(tick.proxy_world + above * tick.normal_world, turned(shaft, tick.turn_world));
  if (!tick.has_contact) return {tick.proxy_world, 0};
  return ball_at(tick.proxy_world - lowest_point(body, shaft, tick.normal_world), shaft);
}

namespace {
Status check_width(double width, const haptics::TouchScene& scene);
}

/// Checks the size of a body and the contact geometry of the hand. A body smaller than the smallest burr of
/// the session would leave no hole in the lattice. A contact ball must fit into the cut of a round burr.
Status check_body(const ToolBody& body, bool is_round, const haptics::TouchScene& scene) {
  if (Status error = volume::check(body)) return error;
  if (scene.tool->is_six_dof() && !is_round)
    return Error{.what = "a burr that touches as a point cannot use this tool",
                 .where = "burr",
                 .found = scene.tool->balls().empty() ? "a whole tool, such as a model"
                                                      : std::to_string(scene.tool->balls().size()) + " balls",
                 .expected = "a round burr, a tool of one ball, or a point"};
  if (is_round && !(scene.tool->radius() > 0))
    return Error{.what = "a round burr needs a ball to touch with",
                 .where = "burr round",
                 .found = "a point",
                 .expected = "a tool with a radius",
                 .remedy = "take the burr with take-instrument, or begin the operation with it"};
  const double width = 2 * body.min_radius();
  if (is_round && width < 2 * scene.tool->radius())
    return Error{.what = "the burr is smaller than its contact ball",
                 .where = "burr diameter",
                 .found = rounded_text(width) + " mm",
                 .expected = rounded_text(2 * scene.tool->radius()) + " mm or more",
                 .remedy = "choose a larger burr, or take this one with take-instrument"};
  return check_width(width, scene);
}

namespace {
/// Checks that a cut of this width (mm) leaves a hole in the lattice of the session.
Status check_width(double width, const haptics::TouchScene& scene) {
  if (width >= scene.smallest_burr) return std::nullopt;
  return Error{.what = "the burr is smaller than the smallest burr of the session",
               .where = "burr diameter",
               .found = rounded_text(width) + " mm",
               .expected = rounded_text(scene.smallest_burr) + " mm or more",
               .remedy = "choose a larger burr, or start the session with a smaller smallest burr"};
}
}  // namespace

Status check_touch(const sim::ToolNeeds& needs, const haptics::TouchScene& scene, const char* tool) {
  constexpr double k_tolerance = 0.05;  // mm
  if (std::abs(scene.tool->radius() - needs.tool->radius()) < k_tolerance &&
      scene.tool->balls().size() == needs.tool->balls().size())
    return std::nullopt;
  const auto describe = [](const haptics::ToolShape& shape) {
    return "balls: " + std::to_string(std::max<std::size_t>(1, shape.balls().size())) +
           ", radius: " + rounded_text(shape.radius()) + " mm";
  };
  return Error{.what = "the contact balls of the hand differ from those of the tool",
               .where = tool,
               .found = describe(*scene.tool),
               .expected = describe(*needs.tool),
               .remedy = "take the tool with take-instrument, or begin the operation with it"};
}

std::vector<sim::Field> joined(std::span<const sim::Field> first, std::initializer_list<sim::Field> more) {
  std::vector<sim::Field> all(first.begin(), first.end());
  all.insert(all.end(), more);
  return all;
}

namespace {

void step(const Burr& burr, BurrState& state, const sim::InstrumentInput& input, sim::Work& work) {
  if (!input.is_fresh && !input.tick.pose.is_pressed() &&
      state.is_through)  // releasing the button ends the plunge
    BurrTick(burr, burr.body(), state, input, work).update_heat_and_breakthrough();
  if (input.is_fresh || !input.tick.pose.is_pressed()) {
    BurrState next;
    next.rise = state.rise, next.hottest = state.hottest;
    state = next;
  }
  BurrTick tick(burr, burr.body(), state, input, work);
  if (input.tick.pose.is_pressed()) tick.drill();
  tick.update_heat_and_breakthrough();
}

sim::ToolBall body(const Burr& burr, const BurrState& state, const sim::InstrumentInput& input) {
  return ball_around(burr, burr.body(), state, input);
}

Status check(const Burr& burr, const haptics::TouchScene& scene) {
  if (burr.is_round && burr.is_kinematic)
    return Error{.what = "round touch requires that bone stops the burr",
                 .where = "burr round",
                 .found = "kinematic",
                 .expected = "round or kinematic, not both"};
  const ToolBody body = burr.body();
  if (burr.shaft > 0 && !burr.is_round)
    return Error{.what = "only a round burr touches with its shaft",
                 .where = "burr shaft",
                 .found = rounded_text(burr.shaft) + " mm",
                 .expected = "0, or a round burr"};
  // Contact balls along the burr, at most 1.25 radii apart.
  const double min_radius = body.min_radius();
  const double longest = 1.25 * min_radius * (haptics::ToolShape::k_max_balls - 1);
  if (burr.is_round && burr.shaft == 0 && body.high() - body.low() > longest + 2 * min_radius)
    return Error{.what = "the burr is too long for its width",
                 .where = "burr length",
                 .found = rounded_text(body.high() - body.low()) + " mm",
                 .expected = "at most " + rounded_text(longest + 2 * min_radius) + " mm",
                 .remedy = "use a shorter burr"};
  if (burr.shaft > 0) {
    if (scene.tool->kind() != haptics::ToolShape::Kind::shell)
      return Error{.what = "a burr with a shaft needs the surface of the whole tool to touch with",
                   .where = "burr shaft",
                   .found = "a tool without a surface",
                   .expected = "the surface of the burr and its shaft",
                   .remedy = "take the burr with take-instrument, or begin the operation with it"};
    if (Status error = volume::check(body)) return error;
    return check_width(2 * min_radius, scene);
  }
  return check_body(body, burr.is_round, scene);
}

/// Returns the finest cut, and for a round burr the contact surface or balls.
sim::ToolNeeds needs(const Burr& burr, const volume::Volume& anatomy) {
  const ToolBody body = burr.body();
  const double finest_cut = 2 * body.min_radius();
  if (!burr.is_round) return {finest_cut};
  const double radius = touch_radius(burr, anatomy);
  if (burr.shaft > 0)
    return {finest_cut, std::make_shared<const haptics::ToolShape>(whole_profile(burr, anatomy))};
  if (body.is_ball()) return {finest_cut, std::make_shared<const haptics::ToolShape>(radius)};
  // Balls inside the body, from its tip to its end: at most one radius apart, as far as their number allows.
  const double first = body.low() + radius, last = std::max(first, body.high() - radius);
  const int gaps = std::clamp(static_cast<int>(std::ceil((last - first) / radius)), 0,
                              static_cast<int>(haptics::ToolShape::k_max_balls) - 1);
  std::vector<haptics::ToolShape::Ball> balls;
  for (int i = 0; i <= gaps; ++i)
    balls.push_back({{0, 0, gaps == 0 ? first : first + (last - first) * i / gaps}, radius});
  return {finest_cut, std::make_shared<const haptics::ToolShape>(std::move(balls))};
}

/// Returns the forces of the rotating burr on the hand: lateral drag and chatter. A kinematic burr has no
/// forces, because bone does not stop it. A burr with a fixed rate has none either, because its rate does not
/// depend on the contact force.
sim::HandForces forces(const Burr& burr, const BurrState&) {
  if (burr.is_kinematic || burr.removal_rate > 0) return {};
  return spin_forces(burr.grade == Grade::diamond ? haptics::Spin{0.3, 0.03, 160}
                                                  : haptics::Spin{0.3, 0.1, 80});
}

}  // namespace

ToolBody Burr::body() const noexcept {
  const double r = radius();
  switch (shape) {
    case Shape::cylinder:
      return ToolBody::cylinder(r, length > 0 ? length : 3 * r, 0.1 * r);
    case Shape::barrel:
      return ToolBody::barrel(r, 0.75 * r, length > 0 ? length : 2.4 * r, 0.1 * r);
    case Shape::match_head:
      return ToolBody::cone(r, 0.6 * r, (length > 0 ? length : 3 * r) - 1.6 * r);
    case Shape::sphere:
      break;
  }
  return ToolBody::ball(r);
}

double touch_radius(const Burr& burr, const volume::Volume& volume) noexcept {
  const double radius = burr.body().min_radius();
  const double step = volume::OffsetField::step_for(radius, volume);
  return std::max(0.5 * radius, radius - step);
}

sim::Instrument burr(const Burr& parameters) {
  return {sim::instrument_type<step, check, body, needs, forces>(), parameters};
}

std::span<const sim::InstrumentType* const> Drilling::instruments() const {
  static const std::array all{&sim::instrument_type<step, check, body, needs, forces>(), &perforator_type(),
                              &craniotome_type()};
  return all;
}

std::span<const sim::ValueType* const> Drilling::events() const {
  static const std::array all{&sim::value_type<Breakthrough>(), &sim::value_type<PerforatorStopped>(),
                              &sim::value_type<CraniotomeRefused>()};
  return all;
}

double hottest_bone(const sim::OperationState& operation) noexcept {
  double hottest = 0;
  for (const sim::Instrument& hand : operation.settings.hands) {
    if (const auto* state = hand.state.as<BurrState>()) hottest = std::max(hottest, state->hottest);
    if (const auto* state = hand.state.as<CraniotomeState>()) hottest = std::max(hottest, state->hottest);
  }
  return hottest;
}

std::vector<sim::Measure> Drilling::measures(const sim::OperationState& operation) const {
  const double hottest = hottest_bone(operation);
  double plunge = 0, breakthroughs = 0;
  for (std::size_t i = 0; i < operation.chronicle.size(); ++i)
    if (const auto* through = operation.chronicle[i].value.as<Breakthrough>())
      ++breakthroughs, plunge = std::max(plunge, through->plunge);
  std::vector<sim::Measure> result;
  if (hottest > 0) result.push_back({"warmest bone, above body temperature", hottest, "K"});
  if (breakthroughs > 0) {
    result.push_back({"breakthroughs", breakthroughs, ""});
    result.push_back({"deepest plunge", plunge, "mm"});
  }
  return result;
}

}  // namespace trephine::drilling
