#include "modules/pedicle/pedicle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "sim/api/work.h"

namespace trephine::pedicle {

using glm::dvec3;

namespace {

/// Returns the index of the earlier track that a new track extends. The new track begins within 2 mm of the
/// end of the earlier track and deviates from its direction by less than 20 degrees. Empty if there is no
/// such track.
std::optional<std::size_t> extended_track(const PedicleState& state, const TrackMade& track) {
  constexpr double k_near = 2, k_straight = 0.94;  // mm; cosine of 20 degrees
  for (std::size_t i = 0; i < state.track_entries.size(); ++i) {
    const dvec3 earlier = state.track_ends[i] - state.track_entries[i], later = track.end - track.entry;
    const bool is_straight =
        glm::dot(earlier, later) > k_straight * glm::length(earlier) * glm::length(later);
    if (glm::length(state.track_ends[i] - track.entry) < k_near && is_straight) return i;
  }
  return std::nullopt;
}

void add_track(PedicleState& state, const TrackMade& track) {
  if (const auto index = extended_track(state, track)) {
    state.track_ends[*index] = track.end;
    state.track_depths[*index] = glm::length(track.end - state.track_entries[*index]);
    state.track_outside[*index] += track.outside;
    return;
  }
  state.track_entries.push_back(track.entry), state.track_ends.push_back(track.end);
  state.track_depths.push_back(track.depth), state.track_outside.push_back(track.outside);
}

/// Returns the text of a length with one decimal: "21.5 mm".
std::string length_text(double mm) {
  const long tenths = std::lround(10 * mm);
  return std::to_string(tenths / 10) + "." + std::to_string(std::abs(tenths % 10)) + " mm";
}

}  // namespace

std::span<const sim::InstrumentType* const> Pedicle::instruments() const {
  static const std::array all{&probe_type()};
  return all;
}
std::span<const sim::ValueType* const> Pedicle::commands() const {
  static const std::array<const sim::ValueType*, 1> all{&sim::value_type<RemoveScrew>()};
  return all;
}
std::span<const sim::JobType* const> Pedicle::jobs() const {
  static const std::array<const sim::JobType*, 2> all{&placement_job(), &judge_job()};
  return all;
}
std::span<const sim::ValueType* const> Pedicle::events() const {
  static const std::array<const sim::ValueType*, 8> all{
      &sim::value_type<ProbeEntered>(), &sim::value_type<ProbeOut>(),      &sim::value_type<ProbeIn>(),
      &sim::value_type<TrackMade>(),    &sim::value_type<ScrewPlaced>(),   &sim::value_type<ScrewFailed>(),
      &sim::value_type<ScrewJudged>(),  &sim::value_type<ScrewNotJudged>()};
  return all;
}

Status Pedicle::allows(const sim::Command& command, const sim::OperationState& operation) const {
  if (Status error = check_placement(command, operation)) return error;
  return check_judging(command, operation);
}

void Pedicle::apply(const sim::Command& command, sim::ModuleWork& work) const {
  const auto* remove = command.request.as<RemoveScrew>();
  PedicleState& state = work.change_undoable<PedicleState>();
  const std::size_t index = *state.find_screw(remove->body);
  work.remove_body(state.screw_bodies[index]);
  state.remove_screw(index);
}

void Pedicle::react(const sim::Event& event, const sim::OperationState&,
                    sim::ModuleReaction& reaction) const {
  if (const auto* track = event.value.as<TrackMade>()) {
    add_track(reaction.change_undoable<PedicleState>(), *track);
  } else if (const auto* added = event.value.as<sim::BodyAdded>()) {
    const PedicleState& state = reaction.undoable<PedicleState>();
    if (state.screw_bodies.empty() || state.screw_bodies.back().value != 0) return;
    reaction.change_undoable<PedicleState>().screw_bodies.back() = added->body;
    const PedicleState& now = reaction.undoable<PedicleState>();
    const Screw screw = now.screw(now.screw_bodies.size() - 1);
    const auto number = static_cast<std::size_t>(now.screw_tracks.back());
    reaction.raise_event(ScrewPlaced{added->body, screw.diameter, screw.length(), screw.tip_world,
                                     static_cast<std::int64_t>(number),
                                     number > 0 ? screw.length() - now.track_depths[number - 1] : 0},
                         screw.entry_world);
  }
}

void Pedicle::react_to_command(const sim::Command& command, const sim::OperationState&,
                               sim::ModuleReaction& reaction) const {
  const auto* discard = command.request.as<sim::DiscardBody>();
  if (discard == nullptr || discard->body.value == 0) return;
  if (const auto index = reaction.undoable<PedicleState>().find_screw(discard->body))
    reaction.change_undoable<PedicleState>().remove_screw(*index);
}

std::vector<sim::Measure> Pedicle::measures(const sim::OperationState& operation) const {
  const auto* state = operation.undoable_of<PedicleState>();
  if (state == nullptr) return {};
  // Only judgements of screws that still exist count: the others were removed or undone.
  const auto* judged = operation.result_of<ScrewJudgements>();
  double worst = 0, worst_grade = 0, least_score = 100, count = 0, scored = 0;
  std::vector<sim::Measure> each;
  std::size_t from = 0;
  for (std::size_t i = 0; judged && i < judged->bodies.size(); ++i) {
    const std::size_t to = judged->names.find('\n', from);
    const std::string name = judged->names.substr(from, to - from);
    from = to + 1;
    if (!state->find_screw(judged->bodies[i])) continue;
    ++count;
    worst = std::max(worst, judged->breaches[i]), worst_grade = std::max(worst_grade, judged->grades[i]);
    each.push_back({name + ": breach", judged->breaches[i], "mm"});
    each.push_back({name + ": grade", judged->grades[i], ""});
    each.push_back({name + ": body breach", judged->fronts[i], "mm"});
    if (judged->scores[i] < 0) continue;
    ++scored;
    least_score = std::min(least_score, judged->scores[i]);
    each.push_back({name + ": score", judged->scores[i], ""});
  }
  const bool has_track = !state->track_depths.empty();
  std::vector<sim::Measure> all{{"tracks", static_cast<double>(state->track_entries.size()), ""},
                                {"last track", has_track ? state->track_depths.back() : 0, "mm"},
                                {"last track beyond bone", has_track ? state->track_outside.back() : 0, "mm"},
                                {"screws", static_cast<double>(state->screw_bodies.size()), ""},
                                {"screws judged", count, ""},
                                {"worst screw breach", worst, "mm"},
                                {"worst screw grade", worst_grade, ""},
                                {"least screw score", scored > 0 ? least_score : 0, ""}};
  all.insert(all.end(), each.begin(), each.end());
  return all;
}

bool Pedicle::is_moving(const sim::OperationState& operation) const {
  return std::any_of(operation.settings.hands.begin(), operation.settings.hands.end(), [](const auto& hand) {
    const auto* state = hand.state.template as<ProbeState>();
    return state && state->has_entered;
  });
}

sim::Overlays Pedicle::overlays(const sim::OperationState& operation) const {
  sim::Overlays result;
  constexpr double k_above = 6;  // mm from the entry to a label
  const auto* state = operation.undoable_of<PedicleState>();
  for (std::size_t i = 0; state && i < state->track_entries.size(); ++i) {
    // A screw in the track hides its line.
    if (std::find(state->screw_tracks.begin(), state->screw_tracks.end(), static_cast<double>(i + 1)) !=
        state->screw_tracks.end())
      continue;
    sim::Overlay& track = result.emplace_back();
    track.name = "track " + std::to_string(i + 1);
    const dvec3 entry = state->track_entries[i], end = state->track_ends[i];
    track.lines.push_back({entry, end});
    track.labels.push_back(
        {entry + k_above * glm::normalize(entry - end), length_text(state->track_depths[i]) + " deep"});
  }
  for (const sim::Instrument& hand : operation.settings.hands) {
    const auto* probe = hand.state.as<ProbeState>();
    if (probe == nullptr || !probe->has_entered) continue;
    sim::Overlay& ruler = result.emplace_back();
    ruler.kind = probe->is_out ? sim::Overlay::Kind::warning : sim::Overlay::Kind::measure;
    ruler.name = "probe";
    ruler.labels.push_back({probe->start - k_above * probe->ahead, length_text(probe->end) + " deep"});
  }
  return result;
}

}  // namespace trephine::pedicle
