#include "apps/view/step_guide.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "apps/workbench/step_text.h"
#include "sim/engine/step_rules.h"

namespace trephine::view {

using volume::StepTransition;

void StepGuide::follow(sim::LiveSession& session, const sim::LiveState& state, double seconds) {
  if (state.step < 0) return;
  Signature newest{state.step_tick, state.step,     state.strokes, state.pending_jobs,
                   state.branch,    state.overlays, state.tool};
  if (revision_ == 0 || state.step_visits != visits_ || newest.step != known_.step ||
      newest.step_tick != known_.step_tick)
    enter(state);
  if (!(newest == known_)) known_ = std::move(newest), is_outdated_ = true;
  take_reasons();
  constexpr double k_time_interval = 1;  // s between requests if a condition depends on time
  const double elapsed = seconds - requested_at_;
  const bool is_due =
      (is_outdated_ && elapsed >= k_interval) || (depends_on_time() && elapsed >= k_time_interval);
  if (next_.empty() || reasons_.valid() || (requested_at_ >= 0 && !is_due)) return;
  requested_at_ = seconds;
  request_reasons(session);
}

void StepGuide::show(const sim::ProcedurePosition& position) {
  if (position.step < 0) return;
  const auto step = static_cast<std::size_t>(position.step);
  if (revision_ > 0 && step == index_ && position.visits == visits_) return;
  index_ = step, visits_ = position.visits;
  next_.clear();
  ++revision_;
}

/// Follows a change of the current step. At first, no next step counts as allowed.
void StepGuide::enter(const sim::LiveState& state) {
  index_ = static_cast<std::size_t>(state.step);
  visits_ = state.step_visits;
  next_.clear();
  for (const StepTransition& transition : step().transitions) {
    const bool is_listed =
        std::any_of(next_.begin(), next_.end(), [&](const Next& next) { return next.step == transition.to; });
    if (transition.on != StepTransition::k_on_request || is_listed) continue;
    const int to = procedure().find(transition.to);
    next_.push_back(
        {transition.to, title_of(procedure().steps[static_cast<std::size_t>(to)]), false, false, {}});
  }
  reasons_ = {};  // discards reasons for the next steps of the previous step
  requested_at_ = -1;
  ++revision_;
}

void StepGuide::request_reasons(sim::LiveSession& session) {
  std::vector<sim::Command> commands;
  for (const Next& next : next_) commands.emplace_back(sim::GoToStep{next.step});
  reasons_ = session.reasons_to_refuse(std::move(commands));
  is_outdated_ = false;
  ++request_count_;
}

/// Adopts the requested reasons if they are available. Does not wait.
void StepGuide::take_reasons() {
  if (!reasons_.valid() || reasons_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  const std::vector<Status> reasons = reasons_.get();
  std::vector<Next> answered = next_;
  for (std::size_t i = 0; i < answered.size() && i < reasons.size(); ++i) {
    answered[i].needs_empty_hand = reasons[i] && reasons[i]->found.starts_with("hand 1: ");
    answered[i].is_allowed = !reasons[i] || answered[i].needs_empty_hand;
    answered[i].reason = answered[i].is_allowed
                             ? std::string()
                             : workbench::describe_refusal(step(), answered[i].step, *reasons[i]);
  }
  if (answered == next_) return;
  next_ = std::move(answered);
  ++revision_;
}

bool StepGuide::needs_empty_hand(const std::string& step) const {
  return std::any_of(next_.begin(), next_.end(),
                     [&](const Next& next) { return next.step == step && next.needs_empty_hand; });
}

/// True if a condition of a next step can change without a command, an event or a cut.
bool StepGuide::depends_on_time() const {
  for (const StepTransition& transition : step().transitions)
    for (const volume::StepCondition& condition : transition.conditions)
      if (condition.measurement == "step_seconds" || condition.measurement.starts_with("nearest_mm "))
        return true;
  return false;
}

Result<sim::Value, std::string> StepGuide::allowed_parameters(const sim::InstrumentType& instrument) const {
  const sim::Value usual = sim::Value::of(*instrument.parameters);
  const auto check = [&](const sim::Value& parameters) {
    return sim::check_instrument(procedure(), step(), sim::Instrument(instrument, parameters));
  };
  const Status error = check(usual);
  if (!error) return usual;
  // An entry of the step or of the procedure may require other parameters.
  for (const std::vector<std::string>* entries : {&step().instruments, &procedure().instruments})
    for (const std::string& entry : *entries) {
      const auto [name, words] = sim::split_name(entry);
      sim::Value required = usual;
      if (name == instrument.name() && !required.set(words) && !check(required)) return required;
    }
  return workbench::describe_prohibition(step(), "instrument", *error);
}

std::vector<sim::TakeInstrument> StepGuide::instruments_ahead() const {
  std::vector<sim::TakeInstrument> ahead;
  const auto add = [&](const std::vector<std::string>& entries) {
    for (const std::string& entry : entries) {
      const auto [name, words] = sim::split_name(entry);
      sim::TakeInstrument one{std::string(name), std::string(words)};
      const bool is_known = std::any_of(ahead.begin(), ahead.end(), [&](const sim::TakeInstrument& other) {
        return other.instrument == one.instrument && other.parameters == one.parameters;
      });
      if (!is_known) ahead.push_back(std::move(one));
    }
  };
  for (std::size_t i = index_; i < procedure().steps.size(); ++i) add(procedure().steps[i].instruments);
  add(procedure().instruments);
  return ahead;
}

std::string StepGuide::reason_against(const sim::ValueType& command) const {
  const Status error = sim::check_command(procedure(), step(), command);
  return error ? workbench::describe_prohibition(step(), "command", *error) : std::string();
}

bool StepGuide::is_ever_allowed(const sim::ValueType& command) const {
  const auto& steps = procedure().steps;
  return std::any_of(steps.begin(), steps.end(), [&](const volume::ProcedureStep& one) {
    return !sim::check_command(procedure(), one, command);
  });
}

}  // namespace trephine::view
