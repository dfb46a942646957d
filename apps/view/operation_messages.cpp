// Messages of OperationController: faults, structures that the tool entered, jobs, events.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "apps/view/operation_controller.h"
#include "apps/view/tool_appearance.h"
#include "apps/workbench/event_text.h"
#include "apps/workbench/step_text.h"
#include "apps/workbench/text.h"
#include "haptics/servo/servo_record.h"

namespace trephine::view {

using workbench::EventLevel;

namespace {

/// True if events report the refusal, which then needs no further message.
bool is_refusal_in(const std::vector<sim::Event>& events, const Error& refusal) {
  return std::any_of(events.begin(), events.end(), [&](const sim::Event& event) {
    const auto* refused = event.value.as<sim::StepRefused>();
    return refused != nullptr && refused->reason.starts_with(refusal.what);
  });
}

}  // namespace

std::uint32_t OperationController::latched_faults() const noexcept {
  std::uint32_t faults = live_.servo_faults();
  for (const haptics::ServoRecord& hand : state_.hands) faults |= hand.faults;
  return faults & haptics::k_latched_faults;
}

std::string OperationController::fault_text() const {
  const std::uint32_t faults = latched_faults();
  if (faults == 0) {
    const std::optional<EnteredStructure> entered = entered_structure();
    if (!entered || entered->is_pushed) return {};
    const bool is_of_mouse = entered->hand == 0 && !options_.device;
    const char* remedy = !is_of_mouse          ? ". Lift it."
                         : line_.is_holding()  ? ". Click away from the entry to withdraw it."
                         : guide_.is_holding() ? ". Move the cursor away to withdraw it."
                         : is_pressed_         ? ". Release the button to lift it."
                                               : ". Move the cursor away to lift it.";
    if (entered->is_touched)
      return workbench::format_text("The running tool touches the %s, %.1f mm deep; it tears at %.1f mm",
                                    entered->name.c_str(), entered->depth, sim::k_tear_depth) +
             remedy;
    return workbench::format_text("The tool is in the %s, %.1f mm deep", entered->name.c_str(),
                                  entered->depth) +
           remedy;
  }
  if (!has_haptic_device() && faults == haptics::fault_stale_scene) return {};
  return "The force is off: " + workbench::fault_reasons(faults) +
         (has_haptic_device() ? ". Press F to turn it on again." : ". It returns automatically.");
}

/// Returns a text with the distance of a pushed probe or catheter to its planned target or, without a plan,
/// with its depth along the line; empty for other tools. This depth may differ from the depth in matter,
/// which a label of the tool's module shows.
std::string OperationController::depth_text() const {
  constexpr double k_least = 0.5;  // mm
  if (!is_pressed_ || line_.inserted_depth() < k_least || appearance_of(state_.tool).is_drill) return "";
  if (!(line_.planned_length() > 0)) return workbench::format_text("Depth %.0f mm", line_.inserted_depth());
  const double rest = line_.planned_length() - line_.inserted_depth();
  return workbench::format_text("%.0f mm %s the planned target", std::abs(rest), rest >= 0 ? "to" : "beyond");
}

std::string OperationController::notice_text() const {
  const std::string fault = fault_text(), shown = notices_.shown(seconds());
  std::string text = fault;
  const bool is_late = !has_haptic_device() && latched_faults() == haptics::fault_stale_scene;
  const std::string late = is_late ? "The computer is too busy: the tool is stopped." : "";
  for (const std::string& line : {late, push_text(), job_text(), depth_text(), shown})
    text += (text.empty() || line.empty() ? "" : "\n") + line;
  return text;
}

std::string OperationController::job_text() const {
  constexpr double k_short = 0.3;  // s
  const double elapsed = seconds() - job_started_;
  if (job_.empty() || elapsed < k_short) return "";
  std::string words = job_ == "take-instrument" ? "preparing the tool" : job_;
  std::replace(words.begin(), words.end(), '-', ' ');
  words[0] = static_cast<char>(std::toupper(words[0]));
  return workbench::format_text("%s: %.0f s so far ...", words.c_str(), std::ceil(elapsed));
}

EventLevel OperationController::notice_level() const {
  return fault_text().empty() ? notices_.shown_level(seconds()) : EventLevel::danger;
}

void OperationController::collect_notices() {
  const double now = seconds();
  const auto session_time = [&](std::uint64_t tick) { return static_cast<double>(tick) / options_.rate_hz; };
  for (const sim::Event& event : state_.events) {
    workbench::EventText text =
        steps_ ? workbench::describe_event(event, steps_->procedure()) : workbench::describe_event(event);
    if (const auto* fault = event.value.as<sim::FaultEvent>()) {
      report_.force_faults += !fault->is_cleared;
      if (!has_haptic_device()) text.level = EventLevel::record;  // a mouse has no force
    }
    notices_.add({now, session_time(event.tick), text.level, std::move(text.text)});
  }
  if (state_.refused && !is_refusal_in(state_.events, *state_.refused))
    notices_.add({now, session_time(state_.newest.tick), EventLevel::refusal,
                  "The command was refused: " + refusal_text(*state_.refused)});
}

/// Returns the text of an error, with the titles of steps.
std::string OperationController::refusal_text(const Error& error) const {
  const std::string text = workbench::sentences_of(error);
  return steps_ ? workbench::with_step_titles(text, steps_->procedure()) : text;
}

void OperationController::add_notice(const char* text, EventLevel level) {
  notices_.add({seconds(), static_cast<double>(state_.newest.tick) / options_.rate_hz, level, text});
}

/// Returns the structure that the tool entered last; of several entered in the same tick, the least deep one.
std::optional<OperationController::EnteredStructure> OperationController::entered_structure() const {
  const sim::ForbiddenWatch* last = nullptr;
  for (const sim::ForbiddenWatch& watch : state_.watches)
    if (watch.is_inside && (last == nullptr || watch.entered_tick > last->entered_tick ||
                            (watch.entered_tick == last->entered_tick && watch.depth < last->depth)))
      last = &watch;
  if (last == nullptr) return std::nullopt;
  const auto& structures = live_.engine().forbidden();
  const auto index = static_cast<std::size_t>(last - state_.watches.data());
  const sim::Forbidden& structure = *structures[index % structures.size()];
  const bool is_intact = structure.is_membrane() && !last->is_torn;
  return EnteredStructure{workbench::words_of(structure.name()), last->depth, index / structures.size(),
                          is_intact && !last->is_working, is_intact && last->is_working};
}

/// Returns a text if a blunt tool pushes the dura aside; otherwise an empty one.
std::string OperationController::push_text() const {
  const std::optional<EnteredStructure> entered = entered_structure();
  if (!entered || !entered->is_pushed) return "";
  return workbench::format_text("The tool pushes the %s aside by %.1f mm.", entered->name.c_str(),
                                entered->depth);
}

}  // namespace trephine::view
