#include "apps/workbench/step_text.h"

#include <charconv>
#include <optional>
#include <string_view>

#include "apps/workbench/text.h"
#include "volume/base/text.h"

namespace trephine::workbench {

using volume::ProcedureStep;
using volume::StepCondition;
using volume::StepTransition;

namespace {

/// Returns a name as words: "add-anchor" becomes "add anchor".
std::string plain_words(std::string name) {
  std::replace(name.begin(), name.end(), '-', ' ');
  return words_of(std::move(name));
}

std::string capitalized(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

/// Returns "at least 3", "at most 5" or "at least 3 and at most 5", with a unit.
std::string limits_text(const StepCondition& condition, const std::string& unit) {
  std::string text;
  if (condition.minimum) text = "at least " + text_of(*condition.minimum) + unit;
  if (condition.maximum)
    text.append(text.empty() ? "at most " : " and at most ").append(text_of(*condition.maximum) + unit);
  return text;
}

/// Returns a number with at most two decimals.
std::string number_text(double number) {
  std::string text = format_text("%.2f", number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

bool is_one(const std::optional<double>& limit) { return limit && *limit == 1; }

/// Returns the sentence about a number of countable objects, such as "changes".
std::string count_sentence(const StepCondition& condition, const std::string& plural,
                           const std::string& singular, const std::optional<double>& value) {
  const bool is_single = condition.maximum ? is_one(condition.maximum) : is_one(condition.minimum);
  const std::string limits = capitalized(limits_text(condition, ""));
  std::string text = limits + " " + (is_single ? singular + " is " : plural + " are ");
  text += condition.minimum ? "needed; " : "allowed; ";
  return text + (!value ? std::string("the number is unknown.")
                        : (is_one(value) ? "there is " : "there are ") + number_text(*value) + ".");
}

/// Returns the sentence about a measured quantity: `subject` must be within the limits.
std::string quantity_sentence(const StepCondition& condition, const std::string& subject,
                              const std::string& unit, const std::optional<double>& value) {
  return subject + " must be " + limits_text(condition, unit) + "; it is " +
         (value ? number_text(*value) + unit + "." : "unknown, or outdated by a later change.");
}

/// Returns the part of a name after `prefix`, as words; nullopt if the name does not begin with `prefix`.
std::optional<std::string> rest_after(const std::string& name, std::string_view prefix) {
  if (!name.starts_with(prefix)) return std::nullopt;
  return plain_words(name.substr(prefix.size()));
}

/// True for one word in the plural, such as the measures "flaps" and "tracks".
bool is_plural_noun(const std::string& name) {
  return name.size() > 2 && name.find(' ') == std::string::npos && name.ends_with('s') &&
         !name.ends_with("ss");
}

/// Returns the value of a measurement in a list such as "anchors 2, flaps unknown; hand 1: burr", as text;
/// nullopt if the measurement is not in the list.
std::optional<std::string> value_in(const std::string& list, const std::string& measurement) {
  const std::string head = measurement + " ";
  for (std::size_t at = list.find(head); at != std::string::npos; at = list.find(head, at + 1)) {
    if (at > 0 && !list.substr(0, at).ends_with(", ")) continue;
    at += head.size();
    return list.substr(at, std::min(list.size(), list.find_first_of(",;", at)) - at);
  }
  return std::nullopt;
}

/// Returns the number in a text; nullopt if the text is not a number, such as "unknown".
std::optional<double> number_in(const std::string& text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() ? std::optional(number) : std::nullopt;
}

/// Returns the action that raises an event, or makes the first of some things that are counted, in words:
/// "measure"; empty if it has no words.
std::string action_of(std::string_view measurement) {
  constexpr std::pair<std::string_view, const char*> k_actions[] = {
      {"events measured", "measure"},
      {"events flap cut", "cut the flap"},
      {"events flap judged", "judge the flap"},
      {"events laminectomy judged", "judge the laminectomy"},
      {"events perforator stopped", "drill with the perforator until its clutch releases"},
      {"events catheter popped", "pass the catheter into a ventricle"},
      {"events track made", "make a track with the probe"},
      {"events screw placed", "place a screw"},
      {"events xray taken", "take an X-ray"},
      {"tracks", "make a track with the probe, and draw the probe out"},
      {"screws judged", "judge the screws"},
      {"previews", "preview the flap"},
      {"bodies", "free a piece of bone"},
      {"catheter passages", "pass the catheter into the brain"}};
  for (const auto& [name, action] : k_actions)
    if (measurement == name) return action;
  return {};
}

bool is_met(const StepCondition& condition, const std::optional<double>& value) {
  return value && *value >= condition.minimum.value_or(*value) &&
         *value <= condition.maximum.value_or(*value);
}

}  // namespace

std::string describe_unmet(const StepCondition& condition, const std::optional<double>& value) {
  const std::string& name = condition.measurement;
  const auto event = rest_after(name, "events ");
  if (value == 0.0 && condition.minimum == 1.0) {
    std::string action = action_of(plain_words(name));
    if (action.empty() && event) action = "\"" + *event + "\"";
    if (!action.empty()) return "Still to do in this step: " + action + ".";
  }
  if (name == "removed_mm3") return quantity_sentence(condition, "The removed volume", " mm³", value);
  if (name == "step_seconds") return quantity_sentence(condition, "The time in this step", " s", value);
  if (name == "bodies") return count_sentence(condition, "detached pieces", "detached piece", value);
  if (const auto structure = rest_after(name, "nearest_mm "))
    return quantity_sentence(condition, "The distance from " + *structure, " mm", value);
  if (event)
    return quantity_sentence(condition, "The number of events \"" + *event + "\" in this step", "", value);
  if (const auto step = rest_after(name, "visits "))
    return quantity_sentence(condition, "The number of visits of the step \"" + *step + "\"", "", value);
  if (is_plural_noun(name)) return count_sentence(condition, name, name.substr(0, name.size() - 1), value);
  return quantity_sentence(condition, capitalized(plain_words(name)), "", value);
}

std::string describe_refusal(const ProcedureStep& current, const std::string& next, const Error& error) {
  std::string text;
  const auto add = [&](const std::string& sentence) {
    text.append(text.empty() ? "" : " ").append(sentence);
  };
  for (const StepTransition& transition : current.transitions) {
    if (transition.on != StepTransition::k_on_request || transition.to != next || !text.empty()) continue;
    for (const StepCondition& condition : transition.conditions)
      if (const auto listed = value_in(error.found, condition.measurement))
        if (const std::optional<double> value = number_in(*listed); !is_met(condition, value))
          add(describe_unmet(condition, value));
  }
  if (const std::size_t hand = error.found.find("hand "); text.empty() && hand != std::string::npos) {
    const std::size_t colon = error.found.find(": ", hand);
    if (colon != std::string::npos)
      add(capitalized(error.found.substr(hand, colon - hand)) + " holds the " +
          plain_words(error.found.substr(colon + 2)) +
          ", which the next step does not allow. Choose another tool, or no tool.");
  }
  if (text.empty())
    add(capitalized(error.what) + (error.found.empty() ? "" : ": " + plain_words(error.found)) + ".");
  return text;
}

std::string describe_prohibition(const ProcedureStep& step, const char* subject, const Error& error) {
  return format_text("The step \"%s\" does not allow this %s. It allows: %s.",
                     (step.title.empty() ? plain_words(step.name) : step.title).c_str(), subject,
                     plain_words(error.expected).c_str());
}

}  // namespace trephine::workbench
