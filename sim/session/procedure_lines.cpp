#include "sim/session/procedure_lines.h"

#include <charconv>

#include "volume/base/text.h"

namespace trephine::sim {

using trephine::text_of;
using volume::ProcedureStep;
using volume::ScoreLimit;
using volume::StepCondition;
using volume::StepTransition;
using volume::SurgicalProcedure;

namespace {

constexpr std::size_t k_max_list = 256;  ///< most entries of a list

/// Returns a text as one line: line ends are written \n and \r, and a backslash twice.
std::string one_line(const std::string& text) {
  std::string line;
  for (const char c : text) {
    if (c == '\n')
      line += "\\n";
    else if (c == '\r')
      line += "\\r";
    else
      line.append(c == '\\' ? 2 : 1, c);
  }
  return line;
}

/// Reverts one_line(). Returns false if a backslash is followed by another character.
bool read_text(std::string_view line, std::string& text) {
  text.clear();
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] != '\\') {
      text += line[i];
      continue;
    }
    if (++i == line.size()) return false;
    if (line[i] != 'n' && line[i] != 'r' && line[i] != '\\') return false;
    text += line[i] == 'n' ? '\n' : line[i] == 'r' ? '\r' : '\\';
  }
  return true;
}

bool read_number(std::string_view text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

void add_text_line(std::string& out, std::string_view key, const std::string& text) {
  out.append(key).append("=").append(one_line(text)).append("\n");
}
void add_text(std::string& out, std::string_view key, const std::string& text) {
  if (!text.empty()) add_text_line(out, key, text);
}
void add_number(std::string& out, std::string_view key, const std::optional<double>& number) {
  if (number) add_text_line(out, key, text_of(*number));
}
void add_list(std::string& out, std::string_view key, const std::vector<std::string>& list) {
  for (const std::string& text : list) add_text_line(out, key, text);
}

void add_step(std::string& out, const ProcedureStep& step) {
  add_text_line(out, "step", step.name);
  add_text(out, "step_title", step.title);
  add_text(out, "step_hint", step.hint);
  add_text(out, "step_note", step.note);
  add_list(out, "step_instrument", step.instruments);
  add_list(out, "step_command", step.commands);
  add_list(out, "step_on_entry", step.on_entry);
  if (step.is_end) add_text_line(out, "step_end", "1");
  for (const StepTransition& transition : step.transitions) {
    add_text_line(out, "transition", transition.to);
    add_text(out, "transition_on", transition.on);
    for (const StepCondition& condition : transition.conditions) {
      add_text_line(out, "condition", condition.measurement);
      add_number(out, "condition_minimum", condition.minimum);
      add_number(out, "condition_maximum", condition.maximum);
    }
  }
}

/// Adds an object to a list, and reads its name. Returns false if the list is full or the name is invalid.
template <class T>
bool begin(std::vector<T>& list, std::size_t limit, std::string T::*name, std::string_view value) {
  return list.size() < limit && read_text(value, list.emplace_back().*name);
}
bool add_to(std::vector<std::string>& list, std::string_view value) {
  return list.size() < k_max_list && read_text(value, list.emplace_back());
}

std::optional<bool> read_step_line(std::string_view key, std::string_view value, ProcedureStep& step) {
  if (key == "step_title") return read_text(value, step.title);
  if (key == "step_hint") return read_text(value, step.hint);
  if (key == "step_note") return read_text(value, step.note);
  if (key == "step_instrument") return add_to(step.instruments, value);
  if (key == "step_command") return add_to(step.commands, value);
  if (key == "step_on_entry") return add_to(step.on_entry, value);
  if (key == "step_end") {
    step.is_end = value == "1";
    return step.is_end || value == "0";
  }
  if (key == "transition") return begin(step.transitions, volume::k_max_steps, &StepTransition::to, value);
  if (!key.starts_with("transition_") && !key.starts_with("condition")) return std::nullopt;
  if (step.transitions.empty()) return false;
  StepTransition& transition = step.transitions.back();
  if (key == "transition_on") return read_text(value, transition.on);
  if (key == "condition") return begin(transition.conditions, k_max_list, &StepCondition::measurement, value);
  if (transition.conditions.empty()) return false;
  StepCondition& condition = transition.conditions.back();
  if (key == "condition_minimum") return read_number(value, condition.minimum.emplace());
  if (key == "condition_maximum") return read_number(value, condition.maximum.emplace());
  return std::nullopt;
}

/// Prefixes of the lines with score limits: those of the case, and those of its procedure.
constexpr std::string_view k_score = "score", k_procedure_score = "procedure_score";

void add_score(std::string& out, std::string_view prefix, const std::vector<ScoreLimit>& score) {
  const std::string key(prefix);
  for (const ScoreLimit& limit : score) {
    add_text_line(out, key, limit.finding);
    add_text_line(out, key + "_full_at", text_of(limit.full_at));
    add_text_line(out, key + "_zero_at", text_of(limit.zero_at));
    if (limit.weight != ScoreLimit().weight) add_text_line(out, key + "_weight", text_of(limit.weight));
  }
}

std::optional<bool> read_score_line(std::string_view key, std::string_view value, std::string_view prefix,
                                    std::vector<ScoreLimit>& score) {
  if (!key.starts_with(prefix)) return std::nullopt;
  key.remove_prefix(prefix.size());
  if (key.empty()) return begin(score, volume::k_max_planned, &ScoreLimit::finding, value);
  if (key[0] != '_') return std::nullopt;
  if (score.empty()) return false;
  if (key == "_full_at") return read_number(value, score.back().full_at);
  if (key == "_zero_at") return read_number(value, score.back().zero_at);
  if (key == "_weight") return read_number(value, score.back().weight);
  return std::nullopt;
}

}  // namespace

void add_procedure_lines(std::string& out, const volume::SurgicalPlan& plan) {
  if (const SurgicalProcedure& procedure = plan.procedure; procedure != SurgicalProcedure()) {
    add_text_line(out, "procedure", procedure.name);
    add_text(out, "procedure_title", procedure.title);
    add_list(out, "procedure_instrument", procedure.instruments);
    add_list(out, "procedure_command", procedure.commands);
    for (const ProcedureStep& step : procedure.steps) add_step(out, step);
    add_score(out, k_procedure_score, procedure.score);
  }
  add_score(out, k_score, plan.score);
}

std::optional<bool> read_procedure_line(std::string_view key, std::string_view value,
                                        volume::SurgicalPlan& plan) {
  SurgicalProcedure& procedure = plan.procedure;
  if (key == "procedure") return procedure == SurgicalProcedure() && read_text(value, procedure.name);
  if (key == "procedure_title") return read_text(value, procedure.title);
  if (key == "procedure_instrument") return add_to(procedure.instruments, value);
  if (key == "procedure_command") return add_to(procedure.commands, value);
  if (key == "step") return begin(procedure.steps, volume::k_max_steps, &ProcedureStep::name, value);
  if (const auto is_read = read_score_line(key, value, k_score, plan.score)) return is_read;
  if (const auto is_read = read_score_line(key, value, k_procedure_score, procedure.score)) return is_read;
  ProcedureStep none;
  const bool has_step = !procedure.steps.empty();
  const auto is_read = read_step_line(key, value, has_step ? procedure.steps.back() : none);
  return is_read && !has_step ? std::optional(false) : is_read;
}

}  // namespace trephine::sim
