#include "modules/ventriculostomy/catheter.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "volume/base/axes.h"
#include "volume/scan/bone_labels.h"
#include "volume/scan/traversal.h"

namespace trephine::ventriculostomy {

using glm::dvec3;
using sim::field;

namespace {

// Forces are assumed; docs/ventriculostomy.md gives the reasons.
constexpr double k_lateral = 2, k_along = 1;  // N/mm, springs to the line and to the end of the track
constexpr double k_dura_puncture = 1.5, k_dura_drag = 0.1;  // N
constexpr double k_brain_drag = 0.05;                       // N
constexpr double k_brain_damping = 0.003;                   // N s/mm
constexpr double k_wall_puncture = 0.4;                     // N, of the ventricle
// A blocked catheter enters no layer before the hand is 200 mm ahead of its tip.
constexpr double k_blocked_puncture = 20, k_blocked_along = 0.1;  // N, N/mm
constexpr double k_max_force = 5;                                 // N
constexpr double k_hub_stiffness = 1;                             // N/mm

constexpr double k_near = 2;  // mm; the catheter enters when a layer is this near ahead of its tip
constexpr double k_obstructed_seconds = 0.2;  // least duration of an obstruction that is a refusal
constexpr double k_left = 3;     // mm; it has left when its tip is this far outside the outermost layer
constexpr double k_clear = 10;   // mm ahead of the tip that must be free of bone
constexpr double k_shaft = 15;   // mm of the shaft that must be free of bone
constexpr double k_press = 0.5;  // N, pressure on bone that is an attempt to enter
constexpr double k_slack = 0.3;  // mm, by which the rim of the catheter may overlap bone
constexpr double k_fine = 0.05;  // mm between positions at which labels are looked up
// The search for membranes ends this far behind the deepest position of the tip: the tip can be 0.05 mm
// inside a layer before the law of the track resists, so that such a layer may not have been passed.
constexpr double k_behind_tip = 0.2;  // mm

bool has_ventricle(const Layers& layers) { return layers.ventricle > 0; }

/// Returns the label at a point; 0 if a tool has removed the matter there.
int remaining_label(const sim::Work& work, const dvec3& p_world) noexcept {
  const volume::Version& remaining = work.remaining();
  const volume::Volume& scan = remaining.base();
  if (!remaining.is_uncut() && remaining.distance(scan.frame.volume_from_world(p_world)) <= 0) return 0;
  return label_at(scan, p_world);
}

/// Returns true in remaining matter that can be cut and is not labelled as soft tissue, such as bone.
bool is_bone(const sim::Work& work, const dvec3& p_world) {
  return work.is_matter(p_world) && !volume::has_soft_label(work.remaining().base(), p_world);
}

dvec3 ahead_of(const glm::dquat& hand) { return haptics::unit_of(hand) * dvec3(0, 0, -1); }

/// Returns the reason why a catheter with its tip at a point cannot go ahead; empty if it can.
std::string reason_not_to_enter(const Catheter& c, const CatheterState& state, const dvec3& tip,
                                const dvec3& ahead, const dvec3& layer, const sim::Work& work) {
  if (!c.has_stylet && remaining_label(work, layer) == state.dura)
    return "a catheter without its stylet does not pass the dura. Take the catheter with its stylet.";
  const auto [a, b] = volume::perpendicular_axes(ahead);
  constexpr double k_half = 0.70710678118654752;
  const std::array<dvec3, 8> around{a,  b,  k_half * (a + b),  k_half * (a - b),
                                    -a, -b, -k_half * (a + b), k_half * (b - a)};
  const double rim = 0.5 * c.diameter - k_slack;
  bool is_leaning = false;
  for (double along = -k_shaft; along <= k_clear; along += 0.5) {
    const dvec3 middle = tip + along * ahead;
    if (along >= 0 && is_bone(work, middle))
      return "there is bone within 10 mm ahead of the tip. Aim through the hole, or widen its inner end with a burr.";
    for (const dvec3& direction : around) is_leaning = is_leaning || is_bone(work, middle + rim * direction);
  }
  if (is_leaning)
    return "the catheter meets the edge of the hole. Turn it along the hole, or widen the hole.";
  return {};
}

void try_to_enter(const Catheter& c, CatheterState& state, const haptics::ServoRecord& tick,
                  sim::Work& work) {
  const volume::Volume& scan = work.remaining().base();
  if (!has_ventricle(state)) static_cast<Layers&>(state) = layers_of(scan);
  // A blocked catheter was held before the layer; the hand may have turned it since then.
  const double depth = state.is_blocked ? glm::dot(tick.proxy_world - state.start, state.ahead) : 0;
  if (state.is_blocked && depth < -k_left)
    state.is_blocked = state.is_refused = false, state.obstructed_at = -1;
  const dvec3 tip =
                  state.is_blocked ? state.start + std::min(depth, -k_fine) * state.ahead : tick.proxy_world,
              ahead = ahead_of(tick.pose.orientation);
  const bool is_pressed_again = tick.pose.is_pressed() && !state.was_pressed;
  state.was_pressed = tick.pose.is_pressed();
  if (is_pressed_again) state.is_refused = false, state.obstructed_at = -1;
  // A hand turns the catheter while it approaches: only an obstruction that lasts is a refusal.
  const auto refuse = [&](std::string reason) {
    if (state.obstructed_at < 0) state.obstructed_at = tick.t;
    if (state.is_refused || tick.t - state.obstructed_at < k_obstructed_seconds) return;
    work.raise_event(CatheterRefused{std::move(reason)}, tip);
    state.is_refused = true;
  };
  // A catheter enters only from outside the layers. After an undo, the tip of a catheter that has not entered
  // may be inside the brain.
  double nearest = -1;
  if (!state.is_layer(remaining_label(work, tip)))
    for (double along = 0; along <= k_near && nearest < 0; along += k_fine)
      if (state.is_layer(remaining_label(work, tip + along * ahead))) nearest = along;
  const bool is_stopped = tick.has_contact && glm::dot(tick.contact_force_world, -ahead) > k_press;
  if (is_stopped) return refuse("there is bone in the way. Drill a burr hole there first.");
  if (nearest < 0) {
    if (state.is_blocked) return;
    state.obstructed_at = -1;
    if (!tick.has_contact) state.is_refused = false;
    return;
  }
  // The catheter enters as soon as it was turned or moved enough.
  const dvec3 layer = tip + nearest * ahead;
  if (std::string reason = reason_not_to_enter(c, state, tip, ahead, layer, work); !reason.empty()) {
    if (!state.is_blocked) state.is_blocked = true, state.start = layer, state.ahead = ahead;
    return refuse(std::move(reason));
  }
  CatheterState entered;
  static_cast<Layers&>(entered) = state;
  entered.has_entered = true;
  entered.start = layer, entered.ahead = ahead;
  entered.depth = -nearest;
  state = entered;
  work.raise_event(CatheterEntered{ahead}, state.start);
}

/// Searches the track from the end of the last search to k_behind_tip before the deepest position of the tip.
/// Raises an event at the first position in the dura, and at the first position in a ventricle.
void find_pops(CatheterState& state, sim::Work& work) {
  const volume::Volume& scan = work.remaining().base();
  for (; state.searched + k_fine <= state.deepest - k_behind_tip; state.searched += k_fine) {
    const dvec3 at = state.start + state.searched * state.ahead;
    const int label = remaining_label(work, at);
    const auto pop = [&] {
      work.raise_event(CatheterPopped{name_of_label(scan, label), state.searched}, at);
    };
    if (label > 0 && label == state.dura && !state.has_passed_dura) {
      state.has_passed_dura = true;
      pop();
    } else if (label > 0 && (label == state.ventricle || label == state.other_ventricle) &&
               !state.has_reached_ventricle) {
      state.has_reached_ventricle = true, state.ventricle_wall = at;
      pop();
    }
  }
}

void step(const Catheter& c, CatheterState& state, const sim::InstrumentInput& input, sim::Work& work) {
  const haptics::ServoRecord& tick = input.tick;
  if (!state.has_entered) return try_to_enter(c, state, tick, work);
  // The servo starts to hold the tip on the line some ticks after the entry. Earlier ticks are ignored.
  const dvec3 offset = tick.proxy_world - state.start;
  const double depth = glm::dot(offset, state.ahead);
  constexpr double k_held = 1e-6;  // mm
  if (glm::length(offset - depth * state.ahead) > k_held) return;
  state.depth = depth;
  state.deepest = std::max(state.deepest, depth);
  find_pops(state, work);
  if (depth >= -k_left) return;
  work.raise_event(CatheterWithdrawn{state.deepest}, state.start + state.deepest * state.ahead);
  CatheterState left;
  static_cast<Layers&>(left) = state;
  state = left;
}

sim::HandForces forces(const Catheter& c, const CatheterState& state) {
  if (!state.has_entered && !state.is_blocked) return {};
  haptics::Insertion track;
  track.start_world = state.start, track.direction_world = state.ahead;
  track.lateral = k_lateral, track.along = state.is_blocked ? k_blocked_along : k_along;
  const auto add = [&](std::int64_t label, double puncture, double drag) {
    if (label > 0)
      track.layers[track.layer_count++] = {-1, static_cast<int>(label),
                                           state.is_blocked ? k_blocked_puncture : puncture, drag};
  };
  add(state.dura, k_dura_puncture, k_dura_drag);
  add(state.brain, k_brain_drag, k_brain_drag);
  add(state.ventricle, k_wall_puncture, 0);
  add(state.other_ventricle, k_wall_puncture, 0);
  sim::HandForces result;
  // Only the law of the track holds the tip. The hand passes through all shapes, because the edge of the hole
  // is blurred in the scan and would hold the catheter too.
  constexpr int k_shapes = 8;  // TouchScene::k_max_shapes; the shapes of the anatomy are the first items
  for (int item = 0; item < k_shapes; ++item) result.passable_items.set(item, true);
  result.effects[0] = haptics::Effect{track, k_max_force};
  constexpr double k_before_hub = 5;  // mm
  if (state.is_blocked)
    result.effects[1] =
        haptics::Effect{haptics::PlaneStop{state.start, -state.ahead, k_hub_stiffness}, k_max_force};
  else if (state.deepest > c.length - k_before_hub)
    result.effects[1] = haptics::Effect{
        haptics::PlaneStop{state.start + c.length * state.ahead, -state.ahead, k_hub_stiffness}, k_max_force};
  else if (state.has_passed_dura && !state.has_reached_ventricle)
    result.effects[1] = haptics::Effect{haptics::Viscosity{k_brain_damping}, k_max_force};
  return result;
}

Status check(const Catheter&, const haptics::TouchScene& scene) {
  if (has_ventricle(layers_of(*scene.base))) return std::nullopt;
  return Error{.what = "the scan has no label of a ventricle",
               .where = "catheter",
               .expected = "a label whose name starts with \"ventricle\"",
               .remedy = "import the scan with labels of a ventricle, the dura and the brain"};
}

}  // namespace

Layers layers_of(const volume::Volume& scan) {
  Layers layers;
  if (scan.labels.is_empty()) return layers;
  layers.dura = scan.label_value("dura"), layers.brain = scan.label_value("brain");
  for (std::size_t i = 1; i < scan.label_names.size(); ++i) {
    if (!scan.label_names[i].starts_with("ventricle")) continue;
    std::int64_t& place = layers.ventricle < 0 ? layers.ventricle : layers.other_ventricle;
    if (place < 0) place = static_cast<std::int64_t>(i);
  }
  return layers;
}

int label_at(const volume::Volume& scan, const dvec3& p_world) noexcept {
  if (scan.labels.is_empty()) return 0;
  const glm::ivec3 v = volume::voxel_of(scan.frame.volume_from_world(p_world));
  return scan.contains(v) ? scan.labels[scan.index(v.x, v.y, v.z)] : 0;
}

std::string name_of_label(const volume::Volume& scan, int label) {
  const auto index = static_cast<std::size_t>(label);
  return index < scan.label_names.size() ? scan.label_names[index] : "label " + std::to_string(label);
}

const sim::Schema& Catheter::schema() {
  static constexpr sim::Field fields[] = {
      field<&Catheter::diameter>("diameter",
                                 {.unit = "mm", .low = 1.5, .high = 5, .help = "diameter of the catheter"}),
      field<&Catheter::length>("length", {.unit = "mm",
                                          .low = 40,
                                          .high = 400,
                                          .help = "length from the tip to the hub",
                                          .is_expert = true}),
      field<&Catheter::has_stylet>(
          "stylet", {.help = "a stylet is in the catheter; without it the catheter does not pass the dura"})};
  static constexpr sim::Schema table{"catheter", 1, fields};
  return table;
}

const sim::Schema& CatheterState::schema() {
  static constexpr sim::Field fields[] = {
      field<&CatheterState::dura>("dura"),
      field<&CatheterState::brain>("brain"),
      field<&CatheterState::ventricle>("ventricle"),
      field<&CatheterState::other_ventricle>("other_ventricle"),
      field<&CatheterState::has_entered>("has_entered"),
      field<&CatheterState::is_refused>("is_refused"),
      field<&CatheterState::is_blocked>("is_blocked"),
      field<&CatheterState::was_pressed>("was_pressed"),
      field<&CatheterState::start>("start", {.unit = "mm"}),
      field<&CatheterState::ahead>("ahead"),
      field<&CatheterState::depth>("depth", {.unit = "mm"}),
      field<&CatheterState::deepest>("deepest", {.unit = "mm"}),
      field<&CatheterState::searched>("searched", {.unit = "mm"}),
      field<&CatheterState::has_passed_dura>("has_passed_dura"),
      field<&CatheterState::has_reached_ventricle>("has_reached_ventricle"),
      field<&CatheterState::ventricle_wall>("ventricle_wall", {.unit = "mm"}),
      field<&CatheterState::obstructed_at>("obstructed_at", {.unit = "s"})};
  static constexpr sim::Schema table{"catheter-state", 3, fields};
  return table;
}

const sim::Schema& CatheterEntered::schema() {
  static constexpr sim::Field fields[] = {
      field<&CatheterEntered::direction>("direction", {.help = "unit vector into the head"})};
  static constexpr sim::Schema table{"catheter-entered", 1, fields};
  return table;
}
const sim::Schema& CatheterPopped::schema() {
  static constexpr sim::Field fields[] = {
      field<&CatheterPopped::structure>("structure"),
      field<&CatheterPopped::depth>("depth", {.unit = "mm", .help = "depth from the outermost layer"})};
  static constexpr sim::Schema table{"catheter-popped", 1, fields};
  return table;
}
const sim::Schema& CatheterWithdrawn::schema() {
  static constexpr sim::Field fields[] = {field<&CatheterWithdrawn::depth>(
      "depth", {.unit = "mm", .help = "greatest depth from the outermost layer"})};
  static constexpr sim::Schema table{"catheter-withdrawn", 1, fields};
  return table;
}
const sim::Schema& CatheterRefused::schema() {
  static constexpr sim::Field fields[] = {field<&CatheterRefused::reason>("reason")};
  static constexpr sim::Schema table{"catheter-refused", 1, fields};
  return table;
}

const sim::InstrumentType& catheter_type() noexcept {
  return sim::instrument_type<step, check, nullptr, nullptr, forces>();
}
sim::Instrument catheter(const Catheter& parameters) { return {catheter_type(), parameters}; }

}  // namespace trephine::ventriculostomy
