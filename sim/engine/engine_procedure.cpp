// Engine: the procedure of the plan (permissions of a step, and transitions between steps).
#include <algorithm>
#include <array>

#include "sim/engine/core_commands.h"
#include "sim/engine/measurement.h"
#include "sim/engine/procedure_check.h"
#include "sim/engine/step_rules.h"
#include "volume/base/text.h"

namespace trephine::sim {

using volume::ProcedureStep;
using volume::StepCondition;
using volume::StepTransition;

namespace {

/// Returns the reason of a refusal in one line.
std::string reason_of(const Error& error) {
  return error.found.empty() ? error.what : error.what + ": " + error.found;
}

/// Returns the measurements that conditions read.
Measurements measure_step(const Engine& engine) {
  return {engine, {.first_event = engine.state().undoable.procedure.first_event, .accepts_stale = false}};
}

bool are_met(const StepTransition& transition, Measurements& values) {
  return std::all_of(transition.conditions.begin(), transition.conditions.end(),
                     [&](const StepCondition& condition) { return values.meets(condition); });
}

/// Adds each unmet condition with its value and its limits.
void add_unmet(const StepTransition& transition, Measurements& values, Error& error) {
  for (const StepCondition& condition : transition.conditions) {
    if (values.meets(condition)) continue;
    const std::optional<double> value = values.value_of(condition.measurement);
    error.found.append(error.found.empty() ? "" : ", ")
        .append(condition.measurement)
        .append(" ")
        .append(value ? text_of(*value) : "unknown");
    error.expected.append(error.expected.empty() ? "" : ", ").append(words_of(condition));
  }
}

}  // namespace

struct ProcedureCommands {
  static Status check_request(const Engine& engine, const GoToStep& request, std::uint8_t) {
    if (!engine.has_procedure())
      return Error{.what = "the operation has no procedure",
                   .where = "go-to-step",
                   .found = request.step,
                   .expected = "a plan with a procedure"};
    if (engine.procedure().find(request.step) >= 0) return std::nullopt;
    std::vector<std::string> known;
    for (const ProcedureStep& step : engine.procedure().steps) known.push_back(step.name);
    return Error{.what = "unknown step",
                 .where = "go-to-step step",
                 .found = request.step,
                 .expected = joined_names(known, ""),
                 .remedy = "choose one of these"};
  }
  static void go_to_step(Engine& engine, const GoToStep& request, std::uint8_t hand, Outcome& outcome) {
    engine.enter_step(engine.procedure().find(request.step), {engine.state_.next_tick, hand}, outcome);
  }
};

std::span<const CoreCommand> procedure_commands() noexcept {
  using Group = ProcedureCommands;
  static const std::array all{core_command<GoToStep, &Group::go_to_step, &Group::check_request>(
      {.step_rule = StepRule::every_step, .causes_transitions = false})};
  return all;
}

void Engine::begin_procedure() {
  ProcedurePosition& position = state_.undoable.procedure;
  position.step = 0;
  position.visits.assign(procedure().steps.size(), 0);
  position.visits[0] = 1;
  are_initial_commands_due_ = true;
}

std::vector<Command> Engine::take_initial_commands() {
  return std::exchange(are_initial_commands_due_, false) ? commands_on_entry() : std::vector<Command>();
}

/// Returns the commands that the current step issues when it begins. check_procedure() has checked them.
std::vector<Command> Engine::commands_on_entry() const {
  std::vector<Command> commands;
  for (const std::string& words : step().on_entry)
    if (auto command = entry_command(words, catalogue_)) commands.push_back(std::move(command).value());
  return commands;
}

/// Returns an error if the procedure does not allow a command that is valid otherwise.
Status Engine::check_step(const Command& command, const CoreCommand* core) const {
  if (!has_procedure() || (core && !core->is_guarded)) return std::nullopt;
  if (const auto* request = command.request.as<GoToStep>()) return check_request(*request);
  if (const HistoryEntry* target = target_of(command)) {
    const Result<EntryState> state = target->state();
    if (!state || state.value().undoable.procedure.step == state_.undoable.procedure.step)
      return std::nullopt;
    return check_held(procedure().steps[static_cast<std::size_t>(state.value().undoable.procedure.step)]);
  }
  if (const auto* take = command.request.as<TakeInstrument>())
    return check_instrument(procedure(), step(), named_instrument(*take).value());
  if (core == nullptr)
    if (const InstrumentType* instrument = instrument_of(command))
      return check_instrument(procedure(), step(), Instrument(*instrument, command.request));
  return check_command(procedure(), step(), command.request.type());
}

/// Returns an error if a hand holds an instrument that a step does not allow.
Status Engine::check_held(const ProcedureStep& next) const {
  for (std::size_t h = 0; h < hand_count(); ++h) {
    Status error = check_instrument(procedure(), next, state_.settings.hands[h]);
    if (!error) continue;
    error->what = "a hand holds an instrument that the step " + next.name + " does not allow";
    error->found = "hand " + std::to_string(h + 1) + ": " + error->found;
    error->remedy = "remove the instrument first, with remove-instrument";
    return error;
  }
  return std::nullopt;
}

/// Returns an error unless a transition on request leads to the requested step, the conditions of that
/// transition are met, and the requested step allows the instruments of the hands.
Status Engine::check_request(const GoToStep& request) const {
  if (Status error = check_has_request(step(), request.step)) return error;
  Measurements values = measure_step(*this);
  Error unmet{.what = "the conditions of the next step are not met",
              .where = "step " + step().name,
              .remedy = "continue the step until each value is within its limits"};
  bool is_met = false;
  for (const StepTransition& transition : step().transitions) {
    if (transition.on != StepTransition::k_on_request || transition.to != request.step) continue;
    is_met = is_met || are_met(transition, values);
    if (!is_met && unmet.found.empty()) add_unmet(transition, values, unmet);
  }
  const Status held = check_held(procedure().steps[static_cast<std::size_t>(procedure().find(request.step))]);
  if (is_met) return held;
  if (held) {
    unmet.found += "; " + held->found;
    unmet.expected += "; " + held->expected;
    unmet.remedy += ", and remove the instrument";
  }
  return unmet;
}

/// Emits an event for a refused command. The session records both the command and the event.
void Engine::record_refusal(const Command& command, Outcome& outcome) {
  pending_events_.push_back({state_.next_tick, command.hand, glm::dvec3(0),
                             StepRefused{step().name, request_name(command), reason_of(*outcome.refused)}});
  outcome.is_refusal_recorded = true;
  handle_events(outcome, {state_.next_tick, command.hand, {}, StepCause::When::never});
}

/// Returns the number of steps that began in a tick.
std::size_t Engine::steps_begun_in(std::uint64_t tick) const noexcept {
  std::size_t count = 0;
  for (std::size_t i = state_.chronicle.size(); i-- > 0 && state_.chronicle[i].tick == tick;)
    count += state_.chronicle[i].value.as<StepEntered>() != nullptr;
  return count;
}

/// Takes the first transition of the current step whose cause has occurred, whose conditions are met, and
/// whose next step allows the instruments of all hands. If no transition is taken, emits a refusal for the
/// first transition that has a cause and fails only because of an instrument. `first_event`: index of the
/// first event that may be a cause.
void Engine::take_transition(const StepCause& cause, std::size_t first_event, Outcome& outcome) {
  const auto is_caused = [&](const StepTransition& transition) {
    if (transition.on.empty() || transition.on == cause.command) return true;
    for (std::size_t i = first_event; i < state_.chronicle.size(); ++i)
      if (state_.chronicle[i].value.name() == transition.on) return true;
    return false;
  };
  Measurements values = measure_step(*this);
  std::optional<StepRefused> refusal;
  for (const StepTransition& transition : step().transitions) {
    if (transition.on == StepTransition::k_on_request || !is_caused(transition) ||
        !are_met(transition, values))
      continue;
    const int next = procedure().find(transition.to);
    const Status held = check_held(procedure().steps[static_cast<std::size_t>(next)]);
    if (!held) return enter_step(next, cause, outcome);
    if (!refusal && !transition.on.empty())
      refusal = StepRefused{step().name, transition.to, reason_of(*held)};
  }
  if (refusal) pending_events_.push_back({cause.tick, cause.hand, glm::dvec3(0), std::move(*refusal)});
}

/// Enters a step. If k_max_steps_per_tick steps began in the same tick, emits a refusal instead: the commands
/// on entry of these steps form a cycle.
void Engine::enter_step(int next, const StepCause& cause, Outcome& outcome) {
  const std::string& name = procedure().steps[static_cast<std::size_t>(next)].name;
  if (steps_begun_in(cause.tick) >= k_max_steps_per_tick) {
    pending_events_.push_back(
        {cause.tick, cause.hand, glm::dvec3(0),
         StepRefused{step().name, name,
                     std::to_string(k_max_steps_per_tick) +
                         " steps began at the same time: their commands on entry form a cycle"}});
    return;
  }
  ProcedurePosition& position = state_.undoable.procedure;
  position.step = next;
  position.entered_tick = state_.next_tick;
  position.first_event = state_.chronicle.size();
  ++position.visits[static_cast<std::size_t>(next)];
  pending_events_.push_back({cause.tick, cause.hand, glm::dvec3(0), StepEntered{step().name}});
  is_stroke_changed_ = outcome.is_edit = true;
  outcome.next_commands = commands_on_entry();
}

}  // namespace trephine::sim
