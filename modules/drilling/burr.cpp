#include "modules/drilling/burr.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/offset_field.h"

namespace trephine::drilling {

using glm::dvec3;
using sim::field;

namespace {
constexpr double k_memory_voxels =
    1.5;  // contact lost over a way of fewer voxel diagonals is the same contact
constexpr double k_credit_seconds = 0.02;  // removal that may be saved up while the ball closes in
constexpr double k_step_mm = 0.05;         // the ball moves in bites of at most this, each paid for
constexpr double k_turn_cosine = 0.7071;   // a wall farther than this from the axis turns it ...
constexpr double k_turn_seconds = 0.25;    // ... over about this, when pressed by a radius

/// One tick of a burr.
class BurrTick {
 public:
  BurrTick(const Burr& burr, BurrState& state, const sim::InstrumentInput& input, sim::Work& work)
      : burr_(burr), state_(state), tick_(input.tick), dt_(input.dt), work_(work) {}
  void drill();

 private:
  /// mm^3 that so many seconds of contact can take away.
  double budget(double seconds) const noexcept { return burr_.removal_rate * seconds; }
  double sweep_to(const dvec3& centre);
  void turn_axis() noexcept;

  const Burr& burr_;
  BurrState& state_;
  const haptics::ServoRecord& tick_;
  double dt_;
  sim::Work& work_;
};

/// Gives what that took away, mm^3.
double BurrTick::sweep_to(const dvec3& centre) {
  const volume::RemovalReport one =
      work_.remove({state_.has_centre ? state_.centre : centre, centre, burr_.radius(), state_.has_centre});
  state_.centre = centre;
  state_.has_centre = true;
  return work_.left().mm3_of(one.removed_units);
}

void BurrTick::turn_axis() noexcept {
  // The axis of approach is the first normal. A wall that stands steeply to it, and is pressed, turns it; a
  // new touch on such a wall starts anew.
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

void BurrTick::drill() {
  if (burr_.is_kinematic) {
    sweep_to(tick_.pose.position_world);
    return;
  }
  // The ball clears the voxels in front of the HIP, and their walls stand up to a voxel off the cut, so
  // contact comes and goes while the ball works: while it cuts, and for a short way after, it is still in
  // contact.
  const double radius = burr_.radius();
  const dvec3& hip = tick_.pose.position_world;
  state_.free_mm = tick_.has_contact ? 0 : state_.free_mm + glm::length(hip - state_.hip);
  state_.hip = hip;
  if (state_.free_mm > k_memory_voxels * work_.left().base().frame.diagonal_mm()) state_.has_centre = false;
  if (!tick_.has_contact && !state_.has_centre) return;
  state_.owed_mm3 = std::min(state_.owed_mm3 + budget(dt_), budget(k_credit_seconds + dt_));
  if (tick_.has_contact) {
    if (!burr_.is_round) turn_axis();  // else the axis stays 0
    if (!state_.has_centre) state_.owed_mm3 -= sweep_to(tick_.proxy_world + radius * state_.axis);
  }

  // Toward the place where the lowest point is on the HIP, by bites that time has paid for.
  const dvec3 way = hip + radius * state_.axis - state_.centre;
  const double length = std::min(glm::length(way), burr_.feed_limit * dt_);
  if (length <= 1e-9) return;
  const dvec3 start = state_.centre, direction = way / glm::length(way);
  const int bites = std::max(1, static_cast<int>(std::ceil(length / k_step_mm)));
  for (int i = 1; i <= bites && state_.owed_mm3 > 0; ++i)
    state_.owed_mm3 -= sweep_to(start + (length * i / bites) * direction);
  if (work_.removed().removed_units > 0) state_.free_mm = 0;
}

void step(const Burr& burr, BurrState& state, const sim::InstrumentInput& input, sim::Work& work) {
  if (input.is_fresh || !input.tick.pose.is_pressed()) state = BurrState{};
  if (input.tick.pose.is_pressed()) BurrTick(burr, state, input, work).drill();
}

/// The ball while it cuts, and on the surface on which it stands; in the air nobody knows on which side of
/// its lowest point the ball is, so there it is that point.
sim::ToolBall body(const Burr& burr, const BurrState& state, const sim::InstrumentInput& input) {
  const haptics::ServoRecord& tick = input.tick;
  if (state.has_centre) return {state.centre, burr.radius()};
  if (burr.is_kinematic) return {tick.pose.position_world, burr.radius()};
  if (burr.is_round) return {tick.proxy_world, burr.radius()};
  if (!tick.has_contact) return {tick.proxy_world, 0};
  return {tick.proxy_world + burr.radius() * tick.normal_world, burr.radius()};
}

/// A smaller one would leave no hole in the session's lattice, and a ball must have room in what it cuts.
volume::Status check(const Burr& burr, const haptics::TouchScene& scene) {
  if (!scene.tool_balls.empty())
    return volume::Error{"a burr is one ball", "burr", std::to_string(scene.tool_balls.size()) + " balls",
                         "a tool of one ball, or a point", ""};
  if (burr.is_round && !(scene.tool_radius > 0))
    return volume::Error{"a round burr needs a ball to touch with", "burr round", "a point",
                         "a tool with a radius", "begin the operation with it"};
  if (burr.is_round && burr.radius() < scene.tool_radius)
    return volume::Error{"the burr is smaller than the ball that touches for it", "burr diameter",
                         std::to_string(burr.diameter) + " mm",
                         std::to_string(2 * scene.tool_radius) + " mm or more", ""};
  if (burr.diameter >= scene.smallest_burr) return std::nullopt;
  return volume::Error{"the burr is smaller than the session was made ready for", "burr diameter",
                       std::to_string(burr.diameter) + " mm",
                       std::to_string(scene.smallest_burr) + " mm or more",
                       "name the smallest burr when the session begins"};
}

/// A round one cuts no finer than it is, as long as the session lasts: its touch was made for its ball.
sim::ToolNeeds needs(const Burr& burr, const volume::Volume& anatomy) {
  return {burr.diameter, burr.is_round ? touch_radius(burr, anatomy) : 0};
}

}  // namespace

const sim::Schema& Burr::schema() {
  constexpr double k_above_0 = 1e-9;
  static constexpr sim::Field fields[] = {
      field<&Burr::diameter>("diameter", {.unit = "mm", .low = k_above_0, .high = 30, .help = "of the ball"}),
      field<&Burr::removal_rate>(
          "removal_rate", {.unit = "mm3/s", .low = k_above_0, .high = 1e5, .help = "at most, in contact"}),
      field<&Burr::feed_limit>(
          "feed_limit", {.unit = "mm/s", .low = k_above_0, .high = 1e4, .help = "through matter, at most"}),
      field<&Burr::is_kinematic>("kinematic", {.help = "takes all that it sweeps, touched or not"}),
      field<&Burr::is_round>("round", {.help = "touches with all of its ball"})};
  static constexpr sim::Schema table{"burr", 1, fields};
  return table;
}

const sim::Schema& BurrState::schema() {
  static constexpr sim::Field fields[] = {field<&BurrState::has_centre>("has_centre"),
                                          field<&BurrState::centre>("centre", {.unit = "mm"}),
                                          field<&BurrState::axis>("axis"),
                                          field<&BurrState::hip>("hip", {.unit = "mm"}),
                                          field<&BurrState::free_mm>("free", {.unit = "mm"}),
                                          field<&BurrState::owed_mm3>("owed", {.unit = "mm3"})};
  static constexpr sim::Schema table{"burr-state", 1, fields};
  return table;
}

double touch_radius(const Burr& burr, const volume::Volume& volume) noexcept {
  const double step = volume::OffsetField::step_for(burr.radius(), volume);
  return std::max(0.5 * burr.radius(), burr.radius() - step);
}

sim::Instrument burr(const Burr& parameters) {
  return {sim::instrument_type<step, check, body, needs>(), parameters};
}

std::span<const sim::InstrumentType* const> Drilling::instruments() const {
  static const std::array all{&sim::instrument_type<step, check, body, needs>()};
  return all;
}

}  // namespace trephine::drilling
