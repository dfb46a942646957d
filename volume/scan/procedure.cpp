#include "volume/scan/procedure.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace trephine::volume {

namespace {

Error invalid(std::string what, const std::string& step, std::string found, std::string expected,
              std::string remedy = {}) {
  return {.what = std::move(what),
          .where = step.empty() ? "procedure" : "step " + step,
          .found = std::move(found),
          .expected = std::move(expected),
          .remedy = std::move(remedy)};
}

/// Names are used in commands and files: letters, digits, '-' and '_'.
bool is_step_name(const std::string& name) {
  return !name.empty() && name.size() <= 40 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

/// Returns true if the text has control characters other than line ends and tabs.
bool has_control_characters(const std::string& text) {
  return std::any_of(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f;
  });
}

Status check_transitions(const SurgicalProcedure& procedure, const ProcedureStep& step) {
  if (step.transitions.size() > k_max_steps)
    return invalid("a step has too many transitions", step.name, std::to_string(step.transitions.size()),
                   "at most " + std::to_string(k_max_steps), "divide the step into several steps");
  if (step.is_end && !step.transitions.empty())
    return invalid("a last step has transitions", step.name, step.transitions[0].to,
                   "no transitions in a step with end = true", "set end = false, or remove the transitions");
  for (const StepTransition& transition : step.transitions) {
    if (procedure.find(transition.to) < 0)
      return invalid("a transition leads to an unknown step", step.name, transition.to,
                     "the name of a step of this procedure", "correct the name, or add the step");
    if (transition.on.empty() && transition.conditions.empty())
      return invalid("a transition has no cause", step.name, transition.to,
                     "a command, an event, \"request\" or conditions", "set the cause, or add a condition");
    for (const StepCondition& condition : transition.conditions) {
      const auto is_number = [](const std::optional<double>& limit) {
        return !limit || std::isfinite(*limit);
      };
      if (condition.measurement.empty() || !is_number(condition.minimum) || !is_number(condition.maximum) ||
          !(condition.minimum || condition.maximum))
        return invalid("a condition is not complete", step.name, condition.measurement,
                       "a measurement with a minimum, a maximum or both", "add the missing values");
      if (condition.minimum && condition.maximum && *condition.minimum > *condition.maximum)
        return invalid("a condition cannot be met", step.name, condition.measurement, "minimum <= maximum",
                       "swap the two values");
    }
  }
  return std::nullopt;
}

/// Returns for each step whether it can be reached from a step in `begin` (`is_forward`), or whether a step
/// in `begin` can be reached from it.
std::vector<bool> reachable(const SurgicalProcedure& procedure, std::vector<bool> begin, bool is_forward) {
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    for (std::size_t s = 0; s < procedure.steps.size(); ++s)
      for (const StepTransition& transition : procedure.steps[s].transitions) {
        const auto next = static_cast<std::size_t>(procedure.find(transition.to));
        const std::size_t from = is_forward ? s : next, to = is_forward ? next : s;
        if (begin[from] && !begin[to]) begin[to] = has_changed = true;
      }
  }
  return begin;
}

}  // namespace

int SurgicalProcedure::find(const std::string& step) const noexcept {
  for (std::size_t s = 0; s < steps.size(); ++s)
    if (steps[s].name == step) return static_cast<int>(s);
  return -1;
}

Status check(const SurgicalProcedure& procedure) {
  if (procedure.is_empty()) return std::nullopt;
  if (!is_step_name(procedure.name))
    return invalid("the procedure has an invalid name", "", procedure.name,
                   "1 to 40 letters, digits, '-' or '_'", "rename the procedure");
  if (procedure.steps.size() > k_max_steps)
    return invalid("the procedure has too many steps", "", std::to_string(procedure.steps.size()),
                   "at most " + std::to_string(k_max_steps), "combine steps");
  std::set<std::string> names;
  for (const ProcedureStep& step : procedure.steps) {
    if (!is_step_name(step.name))
      return invalid("a step has an invalid name", "", step.name, "1 to 40 letters, digits, '-' or '_'",
                     "rename the step");
    for (const std::string* text : {&step.title, &step.hint, &step.note})
      if (has_control_characters(*text))
        return invalid("a text has control characters", step.name, "",
                       "printable characters, tabs and line ends", "remove them from title, hint and note");
    if (!names.insert(step.name).second)
      return invalid("two steps have the same name", step.name, step.name, "a different name for each step",
                     "rename one of them");
  }
  std::vector<bool> ends(procedure.steps.size());
  for (std::size_t s = 0; s < procedure.steps.size(); ++s) {
    if (Status error = check_transitions(procedure, procedure.steps[s])) return error;
    ends[s] = procedure.steps[s].is_end;
  }
  std::vector<bool> first(procedure.steps.size());
  first[0] = true;
  const std::vector<bool> is_reached = reachable(procedure, first, true),
                          has_end = reachable(procedure, ends, false);
  for (std::size_t s = 0; s < procedure.steps.size(); ++s) {
    const std::string& name = procedure.steps[s].name;
    if (!is_reached[s])
      return invalid("the step cannot be reached", name, name,
                     "a transition to it from a step that can be reached",
                     "add a transition, or remove the step");
    if (!has_end[s])
      return invalid("no end can be reached from the step", name, name,
                     "transitions that lead to a step with end = true",
                     "add a transition, or set end = true");
  }
  return std::nullopt;
}

}  // namespace trephine::volume
