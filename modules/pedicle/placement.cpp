#include "modules/pedicle/placement.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "sim/api/work.h"
#include "volume/base/located_error.h"
#include "volume/base/mix_hash.h"

namespace trephine::pedicle {

using glm::dvec3;

namespace {

struct PlacementResult final : sim::JobResult {
  std::vector<sim::NewBody> screws;
  Screw screw;
  std::int64_t track = 0;
  LocatedStatus error;
  std::string_view failure() const noexcept override { return reason_of(error); }
  std::uint64_t hash() const override {
    MixHash mix;
    if (error) sim::add_bytes(mix, error->reason);
    for (const sim::NewBody& body : screws) mix.add(body.piece->hash), mix.add(body.motion.seconds);
    for (const dvec3& p : {screw.entry_world, screw.tip_world}) mix.add(p.x), mix.add(p.y), mix.add(p.z);
    return mix.value();
  }
  std::span<const sim::NewBody> bodies() const noexcept override { return screws; }
};

/// Returns the least distance between the axes of two screws, mm, from samples 0.25 mm apart on the first.
double distance_between(const Screw& a, const Screw& b) {
  constexpr double k_step = 0.25;
  const dvec3 axis = b.ahead();
  const double length = b.length();
  double least = 1e300;
  for (double s = 0; s <= a.length(); s += k_step) {
    const dvec3 p = a.entry_world + s * a.ahead();
    const double along = std::clamp(glm::dot(p - b.entry_world, axis), 0.0, length);
    least = std::min(least, glm::length(p - b.entry_world - along * axis));
  }
  return least;
}

std::string rounded(double mm) { return std::to_string(std::lround(mm)); }

/// Returns the reason why a screw cannot be placed; empty if it can.
LocatedStatus check_place(const PlaceScrew& request, const Screw& screw, const PedicleState* state,
                          const volume::Field& bone) {
  constexpr double k_step = 0.25;  // mm
  const double length = screw.length();
  double last = -1;
  for (double s = 0; s <= length; s += k_step)
    if (bone.value(bone.volume().frame.volume_from_world(screw.entry_world + s * screw.ahead())) >= 0)
      last = s;
  if (last < 0) return LocatedError{"there is no bone along the screw", screw.entry_world};
  if (length - last > k_max_in_front && !request.is_forced)
    return LocatedError{
        "its tip would be " + rounded(length - last) + " mm in front of the bone: choose a shorter screw",
        screw.tip_world};
  for (std::size_t i = 0; state && i < state->screw_bodies.size(); ++i)
    if (distance_between(screw, state->screw(i)) <
        core_radius(screw.diameter) + core_radius(state->screw(i).diameter))
      return LocatedError{
          "it would cross the screw that is body " + std::to_string(state->screw_bodies[i].value),
          screw.entry_world};
  return std::nullopt;
}

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const PlaceScrew*>(parameters);
  const auto* state = input.state.undoable_of<PedicleState>();
  auto result = std::make_shared<PlacementResult>();
  Screw& screw = result->screw;
  screw.diameter = mm_of(request.diameter);
  dvec3 toward(0);
  if (!request.entry.empty()) {
    screw.entry_world = request.entry.front(), toward = request.target.front();
  } else {
    const std::size_t count = state ? state->track_entries.size() : 0;
    const auto number = request.track == 0 ? count : static_cast<std::size_t>(request.track);
    if (number == 0 || number > count) {
      result->error = LocatedError{"its track no longer exists", {}};
      return result;
    }
    result->track = static_cast<std::int64_t>(number);
    screw.entry_world = state->track_entries[number - 1], toward = state->track_ends[number - 1];
  }
  const double length = mm_of(request.length);
  screw.tip_world = screw.entry_world + length * glm::normalize(toward - screw.entry_world);
  const volume::Field& bone = input.anatomy.items[static_cast<std::size_t>(request.item)].field;
  if ((result->error = check_place(request, screw, state, bone))) return result;
  sim::NewBody body;
  body.piece = screw_piece(screw.diameter, length);
  body.placement = placement_of(screw);
  // The screw is turned in from the point where its tip meets the bone; the thread sets the number of turns.
  body.motion.from = body.placement;
  body.motion.from.position_world -= length * screw.ahead();
  body.motion.seconds = request.seconds;
  body.motion.turns = length / pitch_of(screw.diameter);
  result->screws.push_back(std::move(body));
  return result;
}

Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  const auto item = static_cast<const PlaceScrew*>(parameters)->item;
  if (item >= 0 && static_cast<std::size_t>(item) < anatomy.items.size() &&
      !anatomy.items[static_cast<std::size_t>(item)].is_mesh())
    return std::nullopt;
  return Error{.what = "unknown shape",
               .where = "place-screw item",
               .found = std::to_string(item),
               .expected = "a shape of the anatomy",
               .remedy = "pass the number of a touchable shape, 0 for the first"};
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& output = static_cast<const PlacementResult&>(result);
  if (output.error) {
    work.raise_event(ScrewFailed{output.error->reason}, output.error->position_world);
    return;
  }
  PedicleState& state = work.change_undoable<PedicleState>();
  state.screw_bodies.push_back({});
  state.screw_entries.push_back(output.screw.entry_world);
  state.screw_tips.push_back(output.screw.tip_world);
  state.screw_diameters.push_back(output.screw.diameter);
  state.screw_tracks.push_back(static_cast<double>(output.track));
}

}  // namespace

std::optional<std::size_t> PedicleState::find_screw(sim::Id body) const noexcept {
  if (body.value == 0) return screw_bodies.empty() ? std::optional<std::size_t>() : screw_bodies.size() - 1;
  const auto found = std::find(screw_bodies.begin(), screw_bodies.end(), body);
  if (found == screw_bodies.end()) return std::nullopt;
  return static_cast<std::size_t>(found - screw_bodies.begin());
}

void PedicleState::remove_screw(std::size_t index) {
  const auto at = static_cast<std::ptrdiff_t>(index);
  screw_bodies.erase(screw_bodies.begin() + at);
  screw_entries.erase(screw_entries.begin() + at);
  screw_tips.erase(screw_tips.begin() + at);
  screw_diameters.erase(screw_diameters.begin() + at);
  screw_tracks.erase(screw_tracks.begin() + at);
}

const sim::JobType& placement_job() noexcept {
  static const sim::JobType job{&sim::value_type<PlaceScrew>(), run, nullptr, adopt, check};
  return job;
}

Status check_placement(const sim::Command& command, const sim::OperationState& operation) {
  const auto* state = operation.undoable_of<PedicleState>();
  if (const auto* remove = command.request.as<RemoveScrew>()) {
    if (state && state->find_screw(remove->body)) return std::nullopt;
    return Error{.what = "unknown screw",
                 .where = "remove-screw body",
                 .found = "body " + std::to_string(remove->body.value),
                 .expected = "a placed screw",
                 .remedy = "pass the body of a screw, 0 for the last"};
  }
  const auto* place = command.request.as<PlaceScrew>();
  if (place == nullptr) return std::nullopt;
  if (place->entry.size() != place->target.size() || place->entry.size() > 1)
    return Error{.what = "a screw has one entry and one target",
                 .where = "place-screw",
                 .found = std::to_string(place->entry.size()) + " entries, " +
                          std::to_string(place->target.size()) + " targets",
                 .expected = "one of each, or a track",
                 .remedy = "set both positions"};
  if (place->entry.size() == 1) {
    if (glm::length(place->target.front() - place->entry.front()) >= 1) return std::nullopt;
    return Error{.what = "the target of the screw is at its entry",
                 .where = "place-screw target",
                 .expected = "at least 1 mm between them"};
  }
  const std::size_t count = state ? state->track_entries.size() : 0;
  if (count == 0)
    return Error{.what = "no track for the screw",
                 .where = "place-screw track",
                 .expected = "a track",
                 .remedy = "make one with the probe, or set entry and target"};
  if (place->track < 0 || static_cast<std::size_t>(place->track) > count)
    return Error{.what = "unknown track",
                 .where = "place-screw track",
                 .found = std::to_string(place->track),
                 .expected = "1 to " + std::to_string(count) + ", or 0 for the last"};
  return std::nullopt;
}

}  // namespace trephine::pedicle
