// Findings of pedicle screws and tracks. docs/scores.md has the limits and their sources.
#include <algorithm>
#include <map>

#include "modules/pedicle/pedicle.h"
#include "modules/pedicle/screw_judge.h"

namespace trephine::pedicle {

namespace {

using sim::Finding;

/// Returns `name`, with a number if another screw already has this name: "L4 left", "L4 left 2".
std::string unique_name(const std::string& name, std::map<std::string, int>& used) {
  const int number = ++used[name];
  return number == 1 ? name : name + " " + std::to_string(number);
}

/// Adds the breaches of a judged screw; without a judgement, the reason.
void add_breaches(const std::string& name, const ScrewJudged* judged, const std::string& reason,
                  std::vector<Finding>& findings) {
  Finding breach{
      .name = name + ": breach", .unit = "mm", .reason = reason, .full_at = 0, .zero_at = 4, .weight = 4};
  Finding grade{.name = name + ": grade", .unit = std::string(Finding::k_letter), .reason = reason};
  Finding front{.name = name + ": body breach",
                .unit = "mm",
                .reason = reason,
                .full_at = 0,
                .zero_at = 4,
                .weight = 2};
  if (judged) {
    breach.value = std::max(0.0, judged->breach), grade.value = static_cast<double>(judged->grade);
    front.value = std::max(0.0, judged->front);
    breach.position_world = grade.position_world = judged->breach_at;
    if (*front.value > 0) front.position_world = judged->front_at;
    if (*breach.value > 0)
      breach.reason = "Wall: " + std::string(k_wall_names[static_cast<std::size_t>(judged->wall)]) + ".";
    if (judged->is_uncertain) grade.reason = "The voxels of the scan do not decide this grade.";
  }
  findings.push_back(std::move(breach)), findings.push_back(std::move(grade));
  findings.push_back(std::move(front));
}

/// Adds the distances to the plan, the difference between the length of the screw and the depth of its track,
/// and the intensity in its core.
void add_plan(const std::string& name, const JudgedScrew& screw, const ScrewJudged& judged,
              std::vector<Finding>& findings) {
  Finding entry{.name = name + ": entry to plan", .unit = "mm", .full_at = 2, .zero_at = 10, .weight = 2};
  Finding target = entry;
  target.name = name + ": tip to plan";
  Finding angle{.name = name + ": angle to plan", .unit = "degrees"};
  Finding depth{.name = name + ": length to track", .unit = "mm", .full_at = 2, .zero_at = 10, .weight = 2};
  if (judged.planned.empty()) {
    entry.reason = target.reason = angle.reason =
        "The plan has no trajectory for this vertebra and side; add one.";
  } else {
    entry.value = judged.entry_error, target.value = judged.target_error, angle.value = judged.angle_error;
    entry.reason = "Compared with " + judged.planned + ".";
  }
  if (screw.track_depth)
    depth.value = std::abs(screw.screw.length() - *screw.track_depth);
  else
    depth.reason = "The screw was placed without a track; make one with the probe.";
  entry.position_world = screw.screw.entry_world, target.position_world = screw.screw.tip_world;
  for (Finding* one : {&entry, &target, &angle, &depth}) findings.push_back(std::move(*one));
  if (judged.has_intensity)
    findings.push_back({.name = name + ": intensity in the core", .value = judged.core_hu, .unit = "HU"});
}

std::optional<std::uint64_t> tick_of(sim::Id body, const sim::Chronicle& chronicle) {
  for (std::size_t i = chronicle.size(); i-- > 0;)
    if (const auto* placed = chronicle[i].value.as<ScrewPlaced>(); placed && placed->body == body)
      return chronicle[i].tick;
  return std::nullopt;
}

void add_screw(const PedicleState& state, std::size_t index, const sim::JobInput& input, ScrewJudge& judge,
               std::map<std::string, int>& used, std::vector<Finding>& findings) {
  const JudgedScrew screw = judged_screw(state, index);
  auto result = judge.judge(screw);
  std::string name = "screw " + std::to_string(index + 1), reason;
  ScrewJudged judged;
  if (result) {
    judged = std::move(result).value();
    name = judged.vertebra + " " + std::string(k_side_names[static_cast<std::size_t>(judged.side)]);
  } else {
    reason = "It was not judged: " + result.error().reason + ".";
    if (input.state.plan) compare_with_plan(screw, *input.state.plan, {}, false, judged);
  }
  name = unique_name(name, used);
  const std::size_t first = findings.size();
  add_breaches(name, reason.empty() ? &judged : nullptr, reason, findings);
  add_plan(name, screw, judged, findings);
  for (std::size_t i = first; i < findings.size(); ++i)
    findings[i].tick = tick_of(screw.body, input.state.chronicle);
}

}  // namespace

std::vector<Finding> Pedicle::findings(const sim::JobInput& input) const {
  const auto* state = input.state.undoable_of<PedicleState>();
  if (state == nullptr || input.anatomy.items.empty() || input.anatomy.items[0].is_mesh()) return {};
  std::vector<Finding> findings;
  ScrewJudge judge(input, 0, {});
  std::map<std::string, int> used;
  for (std::size_t i = 0; i < state->screw_bodies.size(); ++i)
    if (state->screw_bodies[i].value != 0) add_screw(*state, i, input, judge, used, findings);
  if (state->track_outside.empty()) return findings;
  const auto worst = std::max_element(state->track_outside.begin(), state->track_outside.end());
  Finding tracks{
      .name = "tracks: beyond bone", .value = *worst, .unit = "mm", .full_at = 0, .zero_at = 4, .weight = 2};
  if (*worst > 0)
    tracks.position_world = state->track_ends[static_cast<std::size_t>(worst - state->track_outside.begin())];
  findings.push_back(std::move(tracks));
  return findings;
}

}  // namespace trephine::pedicle
