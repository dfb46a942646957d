#include "modules/pedicle/probe.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/text.h"
#include "volume/fields/offset_field.h"
#include "volume/scan/traversal.h"

namespace trephine::pedicle {

using glm::dvec3;
using sim::field;

namespace {

constexpr double k_enter_share = 0.5;  // of the resistance: a track starts at this contact force
constexpr double k_upright = 0.5;      // cosine: the shaft stands within 60 degrees of the surface's normal
constexpr double k_search = 5;         // mm ahead of the contact in which there must be bone
constexpr double k_left = 0.2;         // mm above `begin` at which the probe has left its track
constexpr double k_min_track = 1;      // mm: shorter tracks are not reported
constexpr double k_step = 0.05;        // mm of track per removal
constexpr double k_shaft = 3;          // diameters above the entry, removed for the shaft (walls)
constexpr double k_search_step = 0.1;  // mm of track between searches for bone ahead
constexpr double k_ahead[] = {0.3, 0.8, 1.3};  // mm ahead of the tip at which bone is searched for
constexpr double k_fastest = 500;              // mm/s, growth of a track between walls

/// Returns the radius of the contact balls, mm. It is one step of the offset field smaller than that of the
/// track, because the field resolves the track only to a step.
double ball_radius(const Probe& p, const volume::Volume& anatomy) {
  const double radius = 0.5 * p.diameter, step = volume::OffsetField::step_for(radius, anatomy);
  return std::max(0.5 * radius, radius - step);
}

dvec3 shaft_of(const glm::dquat& hand) noexcept { return glm::normalize(hand) * dvec3(0, 0, 1); }

class ProbeTick {
 public:
  ProbeTick(const Probe& probe, ProbeState& state, const sim::InstrumentInput& input, sim::Work& work)
      : p_(probe), state_(state), input_(input), tick_(input.tick), work_(work) {
    press_ = glm::dot(tick_.contact_force_world, shaft_of(tick_.pose.orientation));
  }

  void run() {
    if ((tick_.raised & haptics::fault_not_finite) != 0) return;
    if (!state_.has_entered && !enter()) return;
    state_.depth = glm::dot(tip() - state_.start, state_.ahead);
    if (state_.depth < state_.begin - k_left && !is_hand_in_bone()) return leave();
    grow_to(p_.guide == Guide::line ? state_.depth : depth_between_walls());
  }

 private:
  /// Returns the tip. The proxy is the tip if a line guides the probe, and the centre of its lowest ball if
  /// the walls of the track guide it.
  dvec3 tip() const {
    return p_.guide == Guide::line
               ? tick_.proxy_world
               : tick_.proxy_world + ball_radius(p_, work_.remaining().base()) * state_.ahead;
  }
  dvec3 at(double depth) const { return state_.start + depth * state_.ahead; }

  /// Starts a track if the probe presses on bone. Returns false if it does not.
  bool enter() {
    const dvec3 shaft = shaft_of(tick_.pose.orientation);
    if (!tick_.has_contact || press_ < k_enter_share * p_.resistance ||
        glm::dot(tick_.normal_world, shaft) < k_upright)
      return false;
    state_ = ProbeState{};
    state_.ahead = -shaft;
    const dvec3 contact = tip();
    double down = -1;
    for (double t = 0; t <= k_search && down < 0; t += k_step)
      if (work_.is_matter(contact + t * state_.ahead)) down = t;
    if (down < 0) return false;
    state_.has_entered = true;
    state_.start = contact + down * state_.ahead;
    state_.begin = std::min(0.0, -down);
    state_.item = std::max(0, tick_.shape);
    state_.midline = side_of_midline(work_.remaining().base(), state_.start, state_.ahead);
    return true;
  }

  /// Returns the new depth of a track whose end is a wall. The end moves so far that the spring of the
  /// contact again exerts the resistance. Because contact fields follow cuts some ticks later, the end does
  /// not move farther ahead of the tip than a slack.
  double depth_between_walls() const {
    if (state_.is_out && !(press_ > p_.resistance)) return std::max(state_.end, state_.depth);
    // The slack covers the resolution of the contact field (0.25 mm) and the motion of the hand until the
    // field follows a cut. It is larger for a faster hand, which leads the tip by a larger distance.
    constexpr double k_slack = 0.35, k_share = 0.3;  // mm; of the hand's lead
    const double pressed = glm::dot(tick_.pose.position_world - tick_.proxy_world, state_.ahead);
    if (!(press_ > p_.resistance) || pressed <= 0) return state_.end;
    const double lead = pressed * (1 - p_.resistance / press_), slack = k_slack + k_share * lead;
    return std::max(state_.end,
                    std::min(state_.end + std::min(lead, k_fastest * input_.dt), state_.depth + slack));
  }

  /// Extends the track to a depth in short steps, because a tip jumps ahead when the resistance is lost. Then
  /// removes the bone of the new part.
  void grow_to(double depth) {
    const double last = std::min(depth, p_.length);
    while (state_.end < last) grow_by(std::min(k_search_step, last - state_.end));
    // Outside bone, the rim of an oblique exit is removed where it holds the tip.
    const bool is_held = p_.guide == Guide::walls && press_ > p_.resistance;
    if ((state_.is_out && !is_held) || state_.end - state_.carved < k_step) return;
    carve();
  }
  void grow_by(double growth) {
    state_.end += growth;
    const dvec3 end = at(state_.end);
    if (state_.end >= k_min_track && !state_.is_reported) {
      state_.is_reported = true;
      work_.raise_event(ProbeEntered{state_.ahead}, state_.start);
    }
    if (state_.is_out) {
      state_.outside += growth;
      if (!work_.is_matter(end + k_ahead[0] * state_.ahead)) return;
      state_.is_out = state_.is_carving = false;
      state_.carved = state_.end;
      work_.raise_event(ProbeIn{state_.end}, end);
    } else if (state_.end >= k_min_track) {
      for (const double ahead : k_ahead)
        if (work_.is_matter(end + ahead * state_.ahead)) return;
      carve();
      if (p_.guide == Guide::walls) break_through();
      state_.is_out = true;
      work_.raise_event(
          ProbeOut{state_.end, label_behind(end), wall_at(work_, end, state_.ahead, state_.midline)}, end);
    }
  }

  /// Removes the bone of the new part of the track. The removed part has a round end, at the end of the
  /// track.
  void carve() {
    const double radius = 0.5 * p_.diameter;
    if (!(state_.end > state_.carved)) return;
    // At an oblique entry, the shaft passes bone that lies above the point at which the tip entered.
    const bool is_first = p_.guide == Guide::walls && state_.carved <= 0;
    const double from = is_first ? state_.carved - k_shaft * p_.diameter : state_.carved - radius;
    work_.remove(volume::Sweep{at(from), at(state_.end - radius), radius, state_.is_carving});
    state_.carved = state_.end, state_.is_carving = true;
  }

  /// Moves the round end of the track ahead by its radius, so that balls of the full width pass.
  void break_through() {
    const double radius = 0.5 * p_.diameter;
    work_.remove(volume::Sweep{at(state_.end - radius), at(state_.end), radius, true});
  }

  /// Returns true if the hand of a probe on a line is in bone. The track then must not end: bone would block
  /// the hand again and bury it.
  bool is_hand_in_bone() const {
    return p_.guide == Guide::line && work_.is_matter(tick_.pose.position_world);
  }

  void leave() {
    if (!state_.is_out) carve();
    if (state_.is_reported)
      work_.raise_event(TrackMade{state_.start, at(state_.end), state_.end, state_.outside}, state_.start);
    state_ = ProbeState{};
  }

  /// Returns the label of the bone that the tip left.
  std::string label_behind(const dvec3& tip) const {
    constexpr double k_behind = 12, k_fine = 0.25;  // mm: a tip may leave along a wall
    const volume::Volume& scan = work_.remaining().base();
    if (scan.labels.is_empty()) return {};
    for (double t = 0; t <= k_behind; t += k_fine) {
      const glm::ivec3 v = volume::voxel_of(scan.frame.volume_from_world(tip - t * state_.ahead));
      if (!scan.contains(v)) continue;
      const std::size_t label = scan.labels[scan.index(v.x, v.y, v.z)];
      if (label > 0 && label < scan.label_names.size()) return scan.label_names[label];
    }
    return {};
  }

  const Probe& p_;
  ProbeState& state_;
  const sim::InstrumentInput& input_;
  const haptics::ServoRecord& tick_;
  sim::Work& work_;
  double press_ = 0;  // N, of the bone on the probe along its shaft
};

void step(const Probe& p, ProbeState& state, const sim::InstrumentInput& input, sim::Work& work) {
  if (input.is_fresh) state = ProbeState{};
  ProbeTick(p, state, input, work).run();
}

/// Returns the ball at the end of the probe.
sim::ToolBall body(const Probe& p, const ProbeState& state, const sim::InstrumentInput& input) {
  const double radius = 0.5 * p.diameter;
  const dvec3 ahead = state.has_entered ? state.ahead : -shaft_of(input.tick.pose.orientation);
  const dvec3 tip =
      state.has_entered ? state.start + std::min(state.depth, state.end) * ahead : input.tick.proxy_world;
  return {tip - radius * ahead, radius, true};
}

sim::ToolNeeds needs(const Probe& p, const volume::Volume& anatomy) {
  if (p.guide == Guide::line) return {p.diameter};
  // Balls along the shaft, at most a diameter apart, as far as their number allows.
  const double radius = ball_radius(p, anatomy);
  const int gaps = std::clamp(static_cast<int>(std::ceil(p.length / p.diameter)), 1,
                              static_cast<int>(haptics::ToolShape::k_max_balls) - 1);
  std::vector<haptics::ToolShape::Ball> balls;
  for (int i = 0; i <= gaps; ++i) balls.push_back({{0, 0, p.length * i / gaps}, radius});
  return {p.diameter, std::make_shared<const haptics::ToolShape>(std::move(balls))};
}

std::string text_of(const haptics::ToolShape& tool) {
  return "balls: " + std::to_string(tool.balls().size()) + ", radius: " + rounded_text(tool.radius()) + " mm";
}

Status check(const Probe& p, const haptics::TouchScene& scene) {
  if (p.guide == Guide::walls) {
    constexpr double k_tolerance = 1e-6;  // mm
    const haptics::SharedTool needed_tool = needs(p, *scene.base).tool;
    const haptics::ToolShape &needed = *needed_tool, &tool = *scene.tool;
    if (std::abs(tool.radius() - needed.radius()) > k_tolerance ||
        tool.balls().size() != needed.balls().size())
      return Error{.what = "the contact balls of the hand differ from those of the probe",
                   .where = "probe guide",
                   .found = text_of(tool),
                   .expected = text_of(needed),
                   .remedy = "begin the operation with this probe, or take it with take-instrument"};
  } else if (scene.tool->is_six_dof()) {
    return Error{.what = "a probe on a line touches with its tip",
                 .where = "probe guide",
                 .found = scene.tool->balls().empty()
                              ? "the surface of a whole tool"
                              : "a rigid set of balls: " + std::to_string(scene.tool->balls().size()),
                 .expected = "a point, or a ball centred on the tip",
                 .remedy = "take the probe with take-instrument"};
  }
  if (p.diameter >= scene.smallest_burr) return std::nullopt;
  return Error{.what = "the probe is thinner than the smallest burr of the session",
               .where = "probe diameter",
               .found = rounded_text(p.diameter) + " mm",
               .expected = rounded_text(scene.smallest_burr) + " mm or more",
               .remedy = "choose a thicker probe, or start the session with a smaller smallest burr"};
}

sim::HandForces forces(const Probe& p, const ProbeState& state) {
  if (!state.has_entered || p.guide == Guide::walls) return {};
  haptics::Insertion track;
  track.start_world = state.start + state.begin * state.ahead;
  track.direction_world = state.ahead;
  track.layers[0] = {static_cast<int>(state.item), -1, p.resistance, p.resistance};
  track.layer_count = 1;
  sim::HandForces result;
  result.effects[0] = haptics::Effect{track, std::max(8.0, 2 * p.resistance)};
  result.passable_items.set(static_cast<int>(state.item), true);
  return result;
}

bool is_working(const Probe&, const ProbeState& state) { return state.has_entered; }

}  // namespace

const sim::Schema& Probe::schema() {
  static constexpr std::string_view guides[] = {"line", "walls"};
  static constexpr sim::Field fields[] = {
      field<&Probe::diameter>("diameter",
                              {.unit = "mm", .low = 2, .high = 5, .help = "diameter of the track"}),
      field<&Probe::length>("length", {.unit = "mm", .low = 10, .high = 80, .help = "longest track"}),
      field<&Probe::resistance>(
          "resistance",
          {.unit = "N", .low = 0.2, .high = 8, .help = "force along the shaft that extends the track"}),
      field<&Probe::guide>("guide", {.choices = guides,
                                     .help = "a force that holds the probe on a line, or the track's walls",
                                     .is_expert = true})};
  static constexpr sim::Schema table{"probe", 1, fields};
  return table;
}

const sim::Schema& ProbeState::schema() {
  static constexpr sim::Field fields[] = {field<&ProbeState::has_entered>("entered"),
                                          field<&ProbeState::start>("start", {.unit = "mm"}),
                                          field<&ProbeState::ahead>("ahead"),
                                          field<&ProbeState::item>("item"),
                                          field<&ProbeState::begin>("begin", {.unit = "mm"}),
                                          field<&ProbeState::depth>("depth", {.unit = "mm"}),
                                          field<&ProbeState::end>("end", {.unit = "mm"}),
                                          field<&ProbeState::carved>("carved", {.unit = "mm"}),
                                          field<&ProbeState::is_carving>("carving"),
                                          field<&ProbeState::is_reported>("reported"),
                                          field<&ProbeState::is_out>("out"),
                                          field<&ProbeState::outside>("outside", {.unit = "mm"}),
                                          field<&ProbeState::midline>("midline")};
  static constexpr sim::Schema table{"probe-state", 1, fields};
  return table;
}

const sim::Schema& ProbeEntered::schema() {
  static constexpr sim::Field fields[] = {field<&ProbeEntered::direction>("direction")};
  static constexpr sim::Schema table{"probe-entered", 1, fields};
  return table;
}

const sim::Schema& ProbeOut::schema() {
  static constexpr sim::Field fields[] = {
      field<&ProbeOut::depth>("depth", {.unit = "mm"}),
      field<&ProbeOut::label>("label", {.help = "bone that the tip left"}),
      field<&ProbeOut::wall>("wall", {.choices = k_wall_names, .help = "side of the bone"})};
  static constexpr sim::Schema table{"probe-out", 1, fields};
  return table;
}

const sim::Schema& ProbeIn::schema() {
  static constexpr sim::Field fields[] = {field<&ProbeIn::depth>("depth", {.unit = "mm"})};
  static constexpr sim::Schema table{"probe-in", 1, fields};
  return table;
}

const sim::Schema& TrackMade::schema() {
  static constexpr sim::Field fields[] = {
      field<&TrackMade::entry>("entry", {.unit = "mm"}), field<&TrackMade::end>("end", {.unit = "mm"}),
      field<&TrackMade::depth>("depth", {.unit = "mm"}),
      field<&TrackMade::outside>("outside", {.unit = "mm", .help = "part of the track beyond the bone"})};
  static constexpr sim::Schema table{"track-made", 1, fields};
  return table;
}

const sim::InstrumentType& probe_type() noexcept {
  return sim::instrument_type<step, check, body, needs, forces, is_working>();
}
sim::Instrument probe(const Probe& parameters) { return {probe_type(), parameters}; }

}  // namespace trephine::pedicle
