#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "modules/drilling/burr_tick.h"
#include "modules/drilling/craniotome.h"
#include "modules/drilling/perforator.h"
#include "volume/offset_field.h"

namespace trephine::drilling {

using glm::dvec3;
using volume::ToolBody;
using volume::ToolPlace;

namespace {
constexpr double k_memory_voxels =
    1.5;  // contact lost over a way of fewer voxel diagonals is the same contact
constexpr double k_credit_seconds = 0.02;  // removal that may be saved up while the burr closes in
constexpr double k_pi = 3.14159265358979323846;
constexpr double k_engaged_mm = 0.02;     // of the way over which is measured what is in the bone
constexpr double k_step_mm = 0.05;        // the burr moves in bites of at most this, each paid for
constexpr double k_turn_cosine = 0.7071;  // a wall farther than this from the axis turns it ...
constexpr double k_turn_seconds = 0.25;   // ... over about this, when pressed by a radius
constexpr double k_thrust_seconds = 0.1;  // over which thrust is smoothed
constexpr double k_pore_mm = 2;           // resistance that is back after less was lost in a pore
constexpr double k_bored_mm = 0.5;        // of bone, at least, to break through
constexpr double k_retreat_mm = 0.5;      // a hand that comes back so far has stopped
constexpr double k_plunge_seconds = 1;    // no plunge takes longer

/// From a body's `along` 0 to its farthest point against `out`.
dvec3 lowest_point(const ToolBody& body, const dvec3& shaft, const dvec3& out) noexcept {
  if (body.is_ball()) return -body.radius * out;
  // A drum's would jump from rim to rim with the least tilt: its end face stands there instead.
  if (body.form == ToolBody::Form::drum) return dvec3(0);
  const double rise = -glm::dot(out, shaft);
  const ToolBody::Support support = body.support(rise);
  const dvec3 beside = -out - rise * shaft;
  const double length = glm::length(beside);
  return support.along * shaft + (length > 1e-9 ? support.off / length : 0) * beside;
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
  // For a tool of several balls the surfaces' force as a whole; else its part across the surface.
  return glm::dot(tick_.normal_world, tick_.normal_world) > 0
             ? std::max(0.0, glm::dot(tick_.press_world, tick_.normal_world))
             : glm::length(tick_.press_world);
}

Cutting BurrTick::cutting() const noexcept {
  return {burr_.grade, burr_.radius(), burr_.rpm, press(), state_.engaged, !burr_.is_dry};
}

/// Returns what that took away: mm^3, or as many of the reference bone as take the same energy.
double BurrTick::sweep_to(const ToolPlace& place) {
  const ToolPlace from = state_.has_centre ? ToolPlace{state_.centre, state_.shaft} : place;
  const volume::RemovalReport one =
      body_.is_ball()
          ? work_.remove(volume::Sweep{from.at_world, place.at_world, body_.radius, state_.has_centre})
          : work_.remove(volume::ToolSweep{body_, from, place, state_.has_centre});
  const double mm3 = work_.left().mm3_of(one.removed_units);
  // Engaged length: the volume over the way, of at least k_engaged_mm, and never more than the body has.
  state_.bite_mm3 += mm3;
  state_.bite_mm += way_between(from, place);
  if (!state_.has_centre) state_.bite_mm3 = state_.bite_mm = state_.engaged = 0;
  if (state_.bite_mm >= k_engaged_mm) {
    const double r = body_.radius, side = 2 * r * (body_.high() - body_.low());
    state_.engaged = std::min(state_.bite_mm3 / state_.bite_mm, std::max(k_pi * r * r, side));
    state_.bite_mm3 = state_.bite_mm = 0;
  }
  state_.centre = place.at_world;
  state_.shaft = place.axis_world;
  state_.has_centre = true;
  return is_by_press() ? mm3 * relative_energy(one, work_.left().base()) : mm3;
}

void BurrTick::turn_axis() noexcept {
  // The axis of approach is the first normal. A wall that stands steeply to it, and is pressed, turns it; a
  // new touch on such a wall starts again.
  const dvec3& normal = tick_.normal_world;
  const double cosine = glm::dot(state_.axis, normal);
  if (cosine >= k_turn_cosine) return;
  if (!state_.has_centre) {
    state_.axis = normal;
  } else if (cosine > -0.99) {
    const double press = glm::dot(tick_.proxy_world - tick_.pose.position_world, normal) / burr_.radius();
    state_.axis = glm::normalize(state_.axis + dt_ / k_turn_seconds * std::clamp(press, 0.0, 1.0) * normal);
  }
}

/// Place of the body on the surface on which the proxy rests.
ToolPlace BurrTick::place_at_proxy() const noexcept {
  if (burr_.is_round) return {tick_.proxy_world, turned(hand_shaft_, tick_.turn_world)};
  return {tick_.proxy_world - lowest_point(body_, hand_shaft_, state_.axis), hand_shaft_};
}
/// Place of the body with its lowest point on the HIP.
ToolPlace BurrTick::place_at_hand() const noexcept {
  const dvec3& hip = tick_.pose.position_world;
  return {burr_.is_round ? hip : hip - lowest_point(body_, hand_shaft_, state_.axis), hand_shaft_};
}

/// mm, of the body's farthest end where it turns.
double BurrTick::way_between(const ToolPlace& from, const ToolPlace& to) const noexcept {
  const double way = glm::length(to.at_world - from.at_world);
  if (body_.is_ball()) return way;
  return std::max(way, std::max(std::abs(body_.low()), std::abs(body_.high())) *
                           glm::length(to.axis_world - from.axis_world));
}

/// By bites that time has paid for, no farther than `limit` mm, which is then less by what it went.
void BurrTick::go_to(const ToolPlace& to, double& limit) {
  const ToolPlace from{state_.centre, state_.shaft};
  const double way = way_between(from, to), length = std::min(way, limit);
  if (length <= 1e-9) return;
  limit -= length;
  const int bites = std::max(1, static_cast<int>(std::ceil(length / k_step_mm)));
  for (int i = 1; i <= bites && state_.owed_mm3 > 0; ++i) {
    const ToolPlace next = volume::between(from, to, length / way * i / bites);
    if (may_go && !(*may_go)({state_.centre, state_.shaft}, next)) return;
    state_.owed_mm3 -= sweep_to(next);
  }
}

/// On the way from the proxy to the hand, as far as time has paid for. Where the proxy slid aside the body
/// comes after it first; one that is left behind starts again there.
void BurrTick::follow(double limit) {
  const ToolPlace proxy = place_at_proxy(), hand = place_at_hand();
  const dvec3 way = hand.at_world - proxy.at_world;
  const double square = glm::dot(way, way);
  const double share =
      square > 0 ? std::clamp(glm::dot(state_.centre - proxy.at_world, way) / square, 0.0, 1.0) : 0;
  const ToolPlace nearest = volume::between(proxy, hand, share);
  const double aside = glm::length(nearest.at_world - state_.centre);
  if (aside > burr_.diameter) {
    state_.has_centre = false;
    return;
  }
  double left = limit * dt_;
  if (aside > k_step_mm) go_to(nearest, left);
  if (aside <= k_step_mm || glm::length(nearest.at_world - state_.centre) <= k_step_mm) go_to(hand, left);
}

void BurrTick::drill() {
  const dvec3& hip = tick_.pose.position_world;
  if (burr_.is_kinematic) {
    sweep_to({hip, hand_shaft_});
    return;
  }
  // The burr clears the voxels in front of the HIP, and their walls stand up to a voxel off the cut, so
  // contact comes and goes while the burr works: while it cuts, and for a short way after, it is still in
  // contact.
  state_.free_mm = tick_.has_contact ? 0 : state_.free_mm + glm::length(hip - state_.hip);
  state_.hip = hip;
  if (state_.free_mm > k_memory_voxels * work_.left().base().frame.diagonal_mm()) state_.has_centre = false;
  if (!tick_.has_contact && !state_.has_centre) return;
  const Cutting now = cutting();
  const double rate = is_by_press() ? drilling::removal_rate(now) : burr_.removal_rate;
  state_.owed_mm3 = std::min(state_.owed_mm3 + rate * dt_, rate * (k_credit_seconds + dt_));
  if (tick_.has_contact) {
    if (!burr_.is_round) turn_axis();  // else the axis stays 0
    // The touching body is a little smaller than the cutting one, so where it stands there is bone to pay
    // for.
    const ToolPlace proxy = place_at_proxy();
    if (!state_.has_centre && may_go)  // what may not go anywhere takes that on its way
      state_.centre = proxy.at_world, state_.shaft = proxy.axis_world, state_.has_centre = true;
    else if (!state_.has_centre && (!is_by_press() || state_.owed_mm3 > 0))
      state_.owed_mm3 -= sweep_to(proxy);
  }
  if (state_.has_centre && is_by_press() && tick_.has_contact) {
    follow(std::min(burr_.feed_limit, drilling::feed_limit(now)));
  } else if (state_.has_centre) {
    double left = burr_.feed_limit * dt_;
    go_to(place_at_hand(), left);
  }
  if (work_.removed().removed_units > 0) state_.free_mm = 0;
}

void BurrTick::cool_and_watch() {
  const bool is_working = tick_.pose.is_pressed() && !burr_.is_kinematic;
  Cutting now = cutting();
  if (!is_working) now.press = 0;
  const Warming warm = warming(now);
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
    state_.thrust += (now.press - state_.thrust) * std::min(1.0, dt_ / k_thrust_seconds);
    if (work_.removed().removed_units > 0) {
      if (state_.held_normal == dvec3(0)) state_.begun_at = tick_.proxy_world;
      state_.held_at = tick_.proxy_world, state_.held_normal = tick_.normal_world;
    }
  } else if (state_.held_normal != dvec3(0) && !state_.has_centre) {
    // The contact is over: on which side is the hand? A rim that was only brushed is no way through.
    const double bored = glm::dot(state_.begun_at - state_.held_at, state_.held_normal);
    if (beyond > 0 && bored > k_bored_mm) {
      state_.is_through = true;
      state_.deepest = beyond, state_.seconds = state_.deepest_at = 0;
    } else {
      state_.held_normal = dvec3(0);
    }
  }
}

/// In the air the side of its lowest point is unknown, so there it is that point.
sim::ToolBall ball_around(const Burr& burr, const ToolBody& body, const BurrState& state,
                          const sim::InstrumentInput& input) {
  const haptics::ServoRecord& tick = input.tick;
  const auto around = [&](const dvec3& at, const dvec3& shaft) {
    return sim::ToolBall{at + (body.is_ball() ? 0 : body.middle()) * shaft, body.reach()};
  };
  const dvec3 shaft = shaft_of(tick.pose.orientation);
  // One that goes by the press cuts where it stands, or comes after it.
  const bool is_behind = burr.removal_rate == 0 && tick.has_contact;
  if (state.has_centre && !is_behind) return around(state.centre, state.shaft);
  if (burr.is_kinematic) return around(tick.pose.position_world, shaft);
  if (burr.is_round) return around(tick.proxy_world, turned(shaft, tick.turn_world));
  if (!tick.has_contact) return {tick.proxy_world, 0};
  return around(tick.proxy_world - lowest_point(body, shaft, tick.normal_world), shaft);
}

/// A smaller one would leave no hole in the session's lattice, and a ball must have room in what it cuts.
volume::Status check_body(const ToolBody& body, bool is_round, const haptics::TouchScene& scene) {
  if (volume::Status error = volume::check(body)) return error;
  if (!scene.tool_balls.empty() && !is_round)
    return volume::Error{"a burr that is one point cannot touch with balls", "burr",
                         std::to_string(scene.tool_balls.size()) + " balls",
                         "a round burr, a tool of one ball, or a point", ""};
  if (is_round && !(scene.tool_radius > 0))
    return volume::Error{"a round burr needs a ball to touch with", "burr round", "a point",
                         "a tool with a radius", "begin the operation with it"};
  const double narrow = 2 * body.least_radius();
  if (is_round && narrow < 2 * scene.tool_radius)
    return volume::Error{"the burr is smaller than the ball that touches for it", "burr diameter",
                         std::to_string(narrow) + " mm",
                         std::to_string(2 * scene.tool_radius) + " mm or more", ""};
  if (narrow >= scene.smallest_burr) return std::nullopt;
  return volume::Error{"the burr is smaller than the session was made ready for", "burr diameter",
                       std::to_string(narrow) + " mm", std::to_string(scene.smallest_burr) + " mm or more",
                       "name the smallest burr when the session begins"};
}

volume::Status check_touch(const sim::ToolNeeds& needs, const haptics::TouchScene& scene, const char* tool) {
  constexpr double k_off = 0.05;  // mm
  if (std::abs(scene.tool_radius - needs.touch_radius) < k_off &&
      scene.tool_balls.size() == needs.balls.size())
    return std::nullopt;
  const auto words = [](double radius, std::size_t balls) {
    return std::to_string(std::max<std::size_t>(1, balls)) + " of " + std::to_string(radius) + " mm";
  };
  return volume::Error{"the hand touches with other balls than this tool has", tool,
                       words(scene.tool_radius, scene.tool_balls.size()),
                       words(needs.touch_radius, needs.balls.size()),
                       "give the hand that geometry first, or begin the operation with the tool"};
}

std::vector<sim::Field> joined(std::span<const sim::Field> first, std::initializer_list<sim::Field> more) {
  std::vector<sim::Field> all(first.begin(), first.end());
  all.insert(all.end(), more);
  return all;
}

namespace {

void step(const Burr& burr, BurrState& state, const sim::InstrumentInput& input, sim::Work& work) {
  if (!input.is_fresh && !input.tick.pose.is_pressed() &&
      state.is_through)  // the plunge ends with the button
    BurrTick(burr, burr.body(), state, input, work).cool_and_watch();
  if (input.is_fresh || !input.tick.pose.is_pressed()) {
    BurrState next;
    next.rise = state.rise, next.hottest = state.hottest;
    state = next;
  }
  BurrTick tick(burr, burr.body(), state, input, work);
  if (input.tick.pose.is_pressed()) tick.drill();
  tick.cool_and_watch();
}

sim::ToolBall body(const Burr& burr, const BurrState& state, const sim::InstrumentInput& input) {
  return ball_around(burr, burr.body(), state, input);
}

volume::Status check(const Burr& burr, const haptics::TouchScene& scene) {
  if (burr.is_round && burr.is_kinematic)
    return volume::Error{"a burr that is not held by the bone has no round touch", "burr round", "kinematic",
                         "one of the two", ""};
  const ToolBody body = burr.body();
  if (burr.shaft > 0 && !burr.is_round)
    return volume::Error{"only a round burr touches with its shaft", "burr shaft",
                         std::to_string(burr.shaft) + " mm", "0, or a round burr", ""};
  // Balls along it, one and a quarter radii apart at most.
  const double narrow = body.least_radius();
  const double longest = 1.25 * narrow * (haptics::TouchScene::k_most_balls - 1);
  if (burr.is_round && body.high() - body.low() + burr.shaft > longest + 2 * narrow)
    return volume::Error{"the burr and its shaft are too long to touch for their width", "burr shaft",
                         std::to_string(body.high() - body.low() + burr.shaft) + " mm",
                         "at most " + std::to_string(longest + 2 * narrow) + " mm in all",
                         "take a shorter shaft"};
  return check_body(body, burr.is_round, scene);
}

/// A round one cuts no finer than it is, as long as the session lasts: its touch was made for its balls.
sim::ToolNeeds needs(const Burr& burr, const volume::Volume& anatomy) {
  const ToolBody body = burr.body();
  sim::ToolNeeds needs{2 * body.least_radius(), 0, {}};
  if (!burr.is_round) return needs;
  const double radius = needs.touch_radius = touch_radius(burr, anatomy);
  if (body.is_ball() && burr.shaft == 0) return needs;
  // Balls inside of the body from its tip on, and on along the shaft, no farther apart than half of their
  // width: what lies between two of them is nearer than an eighth of it.
  const double first = body.low() + radius, last = std::max(first, body.high() - radius + burr.shaft);
  const int gaps = std::clamp(static_cast<int>(std::ceil((last - first) / radius)), 0,
                              static_cast<int>(haptics::TouchScene::k_most_balls) - 1);
  for (int i = 0; i <= gaps; ++i)
    needs.balls.push_back({0, 0, gaps == 0 ? first : first + (last - first) * i / gaps});
  return needs;
}

/// Forces of the turning burr on the hand: dragged aside, and shaken. One that is not held by bone is only
/// moved; one of a fixed rate has no press to go by.
std::string effect(const Burr& burr) {
  if (burr.is_kinematic || burr.removal_rate > 0) return {};
  return burr.grade == Grade::diamond ? "spin drag=0.3 chatter=0.03 frequency=160"
                                      : "spin drag=0.3 chatter=0.1 frequency=80";
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
  const double radius = burr.body().least_radius();
  const double step = volume::OffsetField::step_for(radius, volume);
  return std::max(0.5 * radius, radius - step);
}

sim::Instrument burr(const Burr& parameters) {
  return {sim::instrument_type<step, check, body, needs, effect>(), parameters};
}

std::span<const sim::InstrumentType* const> Drilling::instruments() const {
  static const std::array all{&sim::instrument_type<step, check, body, needs, effect>(), &perforator_type(),
                              &craniotome_type()};
  return all;
}

std::span<const sim::ValueType* const> Drilling::events() const {
  static const std::array all{&sim::value_type<Breakthrough>(), &sim::value_type<PerforatorStopped>(),
                              &sim::value_type<CraniotomeRefused>()};
  return all;
}

std::vector<sim::Measure> Drilling::measures(const sim::OperationState& now) const {
  double hottest = 0, plunge = 0, breakthroughs = 0;
  for (const sim::Instrument& hand : now.settings.hands) {
    if (const auto* state = hand.state.as<BurrState>()) hottest = std::max(hottest, state->hottest);
    if (const auto* state = hand.state.as<CraniotomeState>()) hottest = std::max(hottest, state->hottest);
  }
  for (std::size_t i = 0; i < now.chronicle.size(); ++i)
    if (const auto* through = now.chronicle[i].what.as<Breakthrough>())
      ++breakthroughs, plunge = std::max(plunge, through->plunge);
  std::vector<sim::Measure> all;
  if (hottest > 0) all.push_back({"warmest bone, above body temperature", hottest, "K"});
  if (breakthroughs > 0) {
    all.push_back({"breakthroughs", breakthroughs, ""});
    all.push_back({"deepest plunge", plunge, "mm"});
  }
  return all;
}

}  // namespace trephine::drilling
