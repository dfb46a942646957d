#include "sim/engine/step_rules.h"

#include <algorithm>

#include "sim/api/core_command.h"
#include "volume/base/text.h"

namespace trephine::sim {

using volume::ProcedureStep;
using volume::StepCondition;
using volume::StepTransition;
using volume::SurgicalProcedure;

namespace {

std::vector<std::string> joined_lists(std::vector<std::string> first, const std::vector<std::string>& more) {
  first.insert(first.end(), more.begin(), more.end());
  return first;
}

/// Returns the instrument's parameters whose values differ from those that an entry requires, such as
/// "kinematic=yes"; the entry's words if they are invalid. Empty: the entry allows the instrument.
std::string wrong_parameters(const Instrument& instrument, std::string_view required_words) {
  Value required = instrument.parameters;
  if (required.set(required_words)) return std::string(required_words);
  std::string wrong;
  for (const Field& field : required.schema().fields)
    if (const std::string found = to_words(field, instrument.parameters.data());
        found != to_words(field, required.data()))
      wrong.append(wrong.empty() ? "" : " ").append(field.name).append("=").append(found);
  return wrong;
}

/// Returns the steps that may follow, as a remedy.
std::string next_steps(const ProcedureStep& step) {
  std::string text;
  for (const StepTransition& transition : step.transitions) {
    std::string cause = transition.on.empty()                           ? std::string()
                        : transition.on == StepTransition::k_on_request ? "with go-to-step"
                                                                        : "after " + transition.on;
    for (const StepCondition& condition : transition.conditions)
      cause.append(cause.empty() ? "if " : ", if ").append(words_of(condition));
    text.append(text.empty() ? "" : "; ").append(transition.to).append(" ").append(cause);
  }
  return text.empty() ? "undo to return to an earlier step" : "go on to the next step: " + text;
}

Error not_allowed(const ProcedureStep& step, const char* what, std::string found, std::string expected) {
  return {.what = what,
          .where = "step " + step.name,
          .found = std::move(found),
          .expected = std::move(expected),
          .remedy = next_steps(step)};
}

}  // namespace

NamedWords split_name(std::string_view text) noexcept {
  constexpr std::string_view k_spaces = " \t\n";
  text.remove_prefix(std::min(text.size(), text.find_first_not_of(k_spaces)));
  const std::size_t end = std::min(text.size(), text.find_first_of(k_spaces));
  std::string_view words = text.substr(end);
  words.remove_prefix(std::min(words.size(), words.find_first_not_of(k_spaces)));
  return {text.substr(0, end), words};
}

Status check_instrument(const SurgicalProcedure& procedure, const ProcedureStep& step,
                        const Instrument& instrument) {
  if (instrument.type == nullptr) return std::nullopt;
  const std::vector<std::string> allowed = joined_lists(step.instruments, procedure.instruments);
  std::string wrong;
  for (const std::string& entry : allowed) {
    const auto [name, words] = split_name(entry);
    if (name == k_any) return std::nullopt;
    if (name != instrument.name()) continue;
    wrong = wrong_parameters(instrument, words);
    if (wrong.empty()) return std::nullopt;
  }
  return not_allowed(step, "the step does not allow the instrument",
                     std::string(instrument.name()) + (wrong.empty() ? "" : " ") + wrong,
                     joined_names(allowed, "no instrument"));
}

Status check_command(const SurgicalProcedure& procedure, const ProcedureStep& step, const ValueType& type) {
  const CoreCommand* core = find_core_command(type);
  const StepRule rule = core ? core->step_rule : StepRule::listed;
  if (rule == StepRule::every_step) return std::nullopt;
  const std::vector<std::string> allowed = joined_lists(step.commands, procedure.commands);
  const std::string name(type.schema->name);
  const auto lists = [&](const std::string& entry) {
    return std::find(allowed.begin(), allowed.end(), entry) != allowed.end();
  };
  if (lists(name) || (rule == StepRule::listed && lists(k_any))) return std::nullopt;
  return not_allowed(step, "the step does not allow the command", name,
                     joined_names(allowed, "the commands of every step, such as undo and note"));
}

Status check_has_request(const ProcedureStep& step, const std::string& name) {
  std::vector<std::string> known;
  for (const StepTransition& transition : step.transitions)
    if (transition.on == StepTransition::k_on_request) {
      if (transition.to == name) return std::nullopt;
      known.push_back(transition.to);
    }
  return not_allowed(step, "no transition leads to this step on request", name,
                     joined_names(known, "no step: this step has no transition on request"));
}

std::string request_name(const Command& command) {
  if (const auto* step = command.request.as<GoToStep>()) return step->step;
  if (const auto* take = command.request.as<TakeInstrument>()) return take->instrument;
  return std::string(command.request.name());
}

std::string words_of(const StepCondition& condition) {
  std::string text = condition.measurement;
  if (condition.minimum) text += " at least " + text_of(*condition.minimum);
  if (condition.maximum)
    text.append(condition.minimum ? " and" : "").append(" at most ").append(text_of(*condition.maximum));
  return text;
}

std::string joined_names(const std::vector<std::string>& names, const char* none) {
  std::string text;
  for (const std::string& name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text.empty() ? none : text;
}

}  // namespace trephine::sim
