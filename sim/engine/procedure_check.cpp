#include "sim/engine/procedure_check.h"

#include "sim/api/core_command.h"
#include "sim/engine/measurement.h"
#include "sim/engine/scene_description.h"
#include "sim/engine/step_rules.h"

namespace trephine::sim {

using volume::ProcedureStep;
using volume::StepCondition;
using volume::StepTransition;
using volume::SurgicalProcedure;

namespace {

Error at(const std::string& where, Error error) {
  error.where = where + (error.where.empty() ? "" : ": " + error.where);
  return error;
}

std::string place_of(const ProcedureStep& step) { return "step " + step.name; }

/// Returns false for the commands that cause no transitions: undo, redo, those of branches, resume and
/// go-to-step.
bool causes_transitions(const ValueType& type) {
  const CoreCommand* core = find_core_command(type);
  return core == nullptr || core->causes_transitions;
}

Status check_instruments(const std::vector<std::string>& entries, const Catalogue& catalogue) {
  for (const std::string& entry : entries) {
    const auto [name, words] = split_name(entry);
    if (entry == k_any) continue;
    HandSpec hand;
    hand.instrument = name, hand.parameters = words;
    if (hand.instrument.empty())
      return Error{.what = "an instrument has no name",
                   .found = entry,
                   .expected = "the name of an instrument",
                   .remedy = "write the name before the parameters"};
    if (const auto instrument = instrument_of(hand, catalogue); !instrument) return instrument.error();
  }
  return std::nullopt;
}

Status check_commands(const std::vector<std::string>& names, const Catalogue& catalogue) {
  for (const std::string& name : names) {
    if (name == k_any) continue;
    if (catalogue.find_instrument(name))
      return Error{.what = "an instrument is listed as a command",
                   .found = name,
                   .expected = "the name of a command",
                   .remedy = "list it under the instruments"};
    if (const auto command = catalogue.command(name, ""); !command) return command.error();
  }
  return std::nullopt;
}

Status check_cause(const std::string& cause, const Catalogue& catalogue) {
  if (cause.empty() || cause == StepTransition::k_on_request) return std::nullopt;
  const ValueType* type = catalogue.find(cause);
  const bool is_event = type && catalogue.is_event(*type);
  const bool is_own = type == &value_type<StepEntered>() || type == &value_type<StepRefused>();
  if (type && !is_own && (is_event || (catalogue.is_command(*type) && causes_transitions(*type))))
    return std::nullopt;
  return Error{.what = type ? "a transition cannot have this cause" : "unknown cause of a transition",
               .found = cause,
               .expected = "the name of a command or an event, or the word request",
               .remedy = type ? "name another command or event" : "list the names with trephine modules"};
}

/// Checks a command that a step issues when it begins.
Status check_on_entry(const SurgicalProcedure& procedure, const ProcedureStep& step, const std::string& words,
                      const Catalogue& catalogue) {
  const auto command = entry_command(words, catalogue);
  if (!command) return command.error();
  const Value& request = command.value().request;
  if (Status error = request.check()) return error;
  if (!causes_transitions(request.type()))
    return Error{.what = "a step cannot issue this command",
                 .found = words,
                 .expected = "a command other than undo, redo, branches and go-to-step",
                 .remedy = "remove it from on_entry"};
  HandSpec hand;
  if (const auto* take = request.as<TakeInstrument>())
    hand.instrument = take->instrument, hand.parameters = take->parameters;
  else if (catalogue.find_instrument(request.name()))
    hand.instrument = request.name(), hand.parameters = request.words();
  if (hand.instrument.empty()) return check_command(procedure, step, request.type());
  const auto instrument = instrument_of(hand, catalogue);
  return instrument ? check_instrument(procedure, step, instrument.value()) : instrument.error();
}

/// Checks the name of a measurement, without the parts that depend on an operation.
Status check_condition(const SurgicalProcedure& procedure, const StepCondition& condition,
                       const Catalogue& catalogue) {
  if (Status error = check_event_count(condition.measurement, catalogue)) return error;
  constexpr std::string_view k_visits = "visits ";
  if (!condition.measurement.starts_with(k_visits) ||
      procedure.find(condition.measurement.substr(k_visits.size())) >= 0)
    return std::nullopt;
  return Error{.what = "unknown step in a condition",
               .found = condition.measurement,
               .expected = "the name of a step of this procedure"};
}

Status check_step(const SurgicalProcedure& procedure, const ProcedureStep& step, const Catalogue& catalogue) {
  if (Status error = check_instruments(step.instruments, catalogue)) return error;
  if (Status error = check_commands(step.commands, catalogue)) return error;
  for (const std::string& words : step.on_entry)
    if (Status error = check_on_entry(procedure, step, words, catalogue)) return error;
  for (const StepTransition& transition : step.transitions) {
    if (Status error = check_cause(transition.on, catalogue)) return error;
    for (const StepCondition& condition : transition.conditions)
      if (Status error = check_condition(procedure, condition, catalogue)) return error;
  }
  return std::nullopt;
}

}  // namespace

Result<Command> entry_command(const std::string& words, const Catalogue& catalogue) {
  const NamedWords named = split_name(words);
  return catalogue.command(named.name, named.words);
}

Status check_procedure(const SurgicalProcedure& procedure, const Catalogue& catalogue) {
  if (Status error = volume::check(procedure)) return error;
  Status error = check_instruments(procedure.instruments, catalogue);
  if (!error) error = check_commands(procedure.commands, catalogue);
  if (error) return at("procedure " + procedure.name, std::move(*error));
  for (const ProcedureStep& step : procedure.steps)
    if (Status in_step = check_step(procedure, step, catalogue))
      return in_step->where == place_of(step) ? in_step : at(place_of(step), std::move(*in_step));
  return std::nullopt;
}

Status check_first_instrument(const SurgicalProcedure& procedure, const Instrument& instrument,
                              std::size_t hand) {
  if (procedure.is_empty()) return std::nullopt;
  Status error = check_instrument(procedure, procedure.steps[0], instrument);
  if (!error) return std::nullopt;
  error->what = "a hand begins with an instrument that the first step of the procedure does not allow";
  error->where = "hand " + std::to_string(hand + 1) + ", " + place_of(procedure.steps[0]);
  error->remedy = "begin with an empty hand, and take the instrument in a step that allows it";
  return error;
}

Status check_step_measurements(const SurgicalProcedure& procedure, const Engine& engine,
                               const Catalogue& catalogue) {
  for (const ProcedureStep& step : procedure.steps)
    for (const StepTransition& transition : step.transitions)
      for (const StepCondition& condition : transition.conditions) {
        if (!condition.measurement.starts_with("nearest_mm ")) continue;
        if (Status error = check_measurement(condition.measurement, engine, catalogue))
          return at(place_of(step) + ", transition to " + transition.to, std::move(*error));
      }
  return std::nullopt;
}

}  // namespace trephine::sim
