#include "modules/ventriculostomy/ventriculostomy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/axes.h"

namespace trephine::ventriculostomy {

using glm::dvec3;

namespace {

/// Returns the index of a hand's newest passage; one past the end if there is no such passage.
std::size_t newest_of(const CatheterPassages& passages, std::uint8_t hand) {
  for (std::size_t i = passages.hands.size(); i-- > 0;)
    if (passages.hands[i] == static_cast<double>(hand)) return i;
  return passages.hands.size();
}

void begin_passage(CatheterPassages& passages, const dvec3& start, const dvec3& direction,
                   std::uint8_t hand) {
  if (passages.starts.size() == CatheterPassages::k_max) {
    for (std::vector<dvec3>* list : {&passages.starts, &passages.directions, &passages.tips})
      list->erase(list->begin());
    passages.hands.erase(passages.hands.begin());
  }
  ++passages.count;
  passages.starts.push_back(start), passages.directions.push_back(direction), passages.tips.push_back(start);
  passages.hands.push_back(hand);
}

/// Returns depth marks on a catheter, one per centimetre from its tip, with a number at every fifth mark.
sim::Overlay marks_of(const Catheter& catheter, const CatheterState& state) {
  constexpr double k_between = 10, k_visible = 40;  // mm: mark spacing; marked length outside the head
  constexpr int k_numbered = 5;
  sim::Overlay overlay;
  overlay.kind = sim::Overlay::Kind::measure;
  const dvec3 back = -state.ahead, tip = state.tip();
  const auto [right, up] = volume::perpendicular_axes(back);
  const double radius = 0.5 * catheter.diameter;
  for (int i = 1; i * k_between <= catheter.length; ++i) {
    if (i * k_between > state.depth + k_visible) break;
    const dvec3 middle = tip + i * k_between * back;
    overlay.lines.push_back({middle - radius * right, middle + radius * right});
    overlay.lines.push_back({middle - radius * up, middle + radius * up});
    if (i % k_numbered == 0) overlay.labels.push_back({middle, std::to_string(i) + " cm"});
  }
  overlay.lines.push_back(
      {tip, tip + std::min(catheter.length, std::max(0.0, state.depth) + k_visible) * back});
  return overlay;
}

}  // namespace

std::span<const sim::InstrumentType* const> Ventriculostomy::instruments() const {
  static const std::array all{&catheter_type()};
  return all;
}
std::span<const sim::JobType* const> Ventriculostomy::jobs() const {
  static const std::array<const sim::JobType*, 2> all{&judge_job(), &leave_job()};
  return all;
}
std::span<const sim::ValueType* const> Ventriculostomy::events() const {
  static const std::array all{&sim::value_type<CatheterEntered>(),   &sim::value_type<CatheterPopped>(),
                              &sim::value_type<CatheterWithdrawn>(), &sim::value_type<CatheterRefused>(),
                              &sim::value_type<CatheterJudged>(),    &sim::value_type<CatheterCrossed>(),
                              &sim::value_type<CatheterClearance>(), &sim::value_type<CatheterLeftInPlace>(),
                              &sim::value_type<CatheterNotLeft>()};
  return all;
}

Status Ventriculostomy::allows(const sim::Command& command, const sim::OperationState& operation) const {
  if (const auto* request = command.request.as<JudgeCatheter>()) return check_judging(*request, operation);
  if (command.request.as<LeaveCatheter>()) return check_leaving(operation);
  const bool replaces = command.request.as<sim::TakeInstrument>() || command.request.as<Catheter>() ||
                        command.request.as<sim::RemoveInstrument>();
  if (!replaces || !inserted_catheter(operation, command.hand)) return std::nullopt;
  return Error{.what = "the catheter is in the head",
               .where = std::string(command.request.name()),
               .expected = "a catheter outside the head",
               .remedy = "draw it out first, or leave it in place"};
}

void Ventriculostomy::react(const sim::Event& event, const sim::OperationState&,
                            sim::ModuleReaction& reaction) const {
  if (const auto* entered = event.value.as<CatheterEntered>()) {
    begin_passage(reaction.change_settings<CatheterPassages>(), event.position_world, entered->direction,
                  event.hand);
    return;
  }
  if (const auto* added = event.value.as<sim::BodyAdded>()) {
    if (const auto& bodies = reaction.undoable<CathetersInPlace>().bodies;
        bodies.empty() || bodies.back().value != 0)
      return;
    CathetersInPlace& left = reaction.change_undoable<CathetersInPlace>();
    left.bodies.back() = added->body;
    const dvec3 tip = left.tips.back();
    reaction.raise_event(CatheterLeftInPlace{added->body, glm::distance(left.starts.back(), tip)}, tip);
    return;
  }
  if (!event.value.as<CatheterPopped>() && !event.value.as<CatheterWithdrawn>()) return;
  auto& passages = reaction.change_settings<CatheterPassages>();
  if (const std::size_t i = newest_of(passages, event.hand); i < passages.tips.size())
    passages.tips[i] = event.position_world;
}

void Ventriculostomy::react_to_command(const sim::Command& command, const sim::OperationState&,
                                       sim::ModuleReaction& reaction) const {
  const auto* discard = command.request.as<sim::DiscardBody>();
  if (discard == nullptr || discard->body.value == 0) return;
  const std::vector<sim::Id>& left = reaction.undoable<CathetersInPlace>().bodies;
  if (std::find(left.begin(), left.end(), discard->body) != left.end())
    reaction.change_undoable<CathetersInPlace>().remove(discard->body);
}

std::vector<sim::Measure> Ventriculostomy::measures(const sim::OperationState& operation) const {
  const auto* passages = operation.persistent_of<CatheterPassages>();
  const auto* left = operation.undoable_of<CathetersInPlace>();
  const auto* j = operation.result_of<CatheterJudged>();
  if (passages == nullptr || left == nullptr || j == nullptr) return {};
  const bool is_stale = operation.is_result_stale<CatheterJudged>();
  const auto flag = [](bool is_true) { return is_true ? 1.0 : 0.0; };
  return {{"catheter passages", static_cast<double>(passages->count), "", false},
          {"catheters left in place", static_cast<double>(left->bodies.size()), "", false},
          {"catheter judged", flag(j->has_value), "", is_stale},
          {"catheter compared with plan", flag(j->has_plan), "", is_stale},
          {"catheter entry error", j->entry_error, "mm", is_stale},
          {"catheter target error", j->target_error, "mm", is_stale},
          {"catheter direction error", j->direction_error, "degrees", is_stale},
          {"catheter depth from outer table", j->depth_from_table, "mm", is_stale},
          {"catheter depth from dura", j->depth_from_dura, "mm", is_stale},
          {"catheter angle to surface", j->angle_to_surface, "degrees", is_stale},
          {"catheter in ventricle", j->in_ventricle, "mm", is_stale},
          {"catheter tip in ventricle", flag(!j->ventricle.empty()), "", is_stale},
          {"catheter clearance", j->clearance, "mm", is_stale}};
}

bool Ventriculostomy::is_moving(const sim::OperationState& operation) const {
  for (std::size_t hand = 0; hand < operation.settings.hands.size(); ++hand)
    if (inserted_catheter(operation, hand)) return true;
  return false;
}

sim::Overlays Ventriculostomy::overlays(const sim::OperationState& operation) const {
  sim::Overlays all;
  for (std::size_t hand = 0; hand < operation.settings.hands.size(); ++hand) {
    const CatheterState* state = inserted_catheter(operation, hand);
    if (state == nullptr) continue;
    sim::Overlay overlay = marks_of(*operation.settings.hands[hand].parameters.as<Catheter>(), *state);
    if (state->has_reached_ventricle) overlay.labels.push_back({state->ventricle_wall, "CSF"});
    all.push_back(std::move(overlay));
  }
  return all;
}

}  // namespace trephine::ventriculostomy
