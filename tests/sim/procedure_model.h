// Interpreter of procedures, written from their documentation. It shares no code with the engine's
// procedures.
#pragma once

#include <map>
#include <set>
#include <sstream>

#include "tests/sim/procedure_bench.h"

namespace trephine::sim {

enum class PlantedFault {
  none,
  strict_limit,     ///< a value equal to a minimum does not meet the condition
  last_transition,  ///< the last possible transition is taken, not the first
  blind_to_hands,   ///< a step begins although it forbids an instrument in a hand
  old_events,       ///< events before the current step count
  kept_visits,      ///< undo, redo and branches keep the numbers of visits
  lax_star          ///< "*" also allows the commands that a step has to name
};

/// Returns the words of an entry of a list: a name and required values.
inline std::vector<std::string> split(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// Position that the interpreter predicts.
struct Position {
  int step = 0;
  std::uint64_t entered_tick = 0, first_event = 0;
  std::vector<std::uint32_t> visits;
};

/// Observed facts about a state that do not depend on the procedure.
struct Facts {
  const void* version = nullptr;
  std::int64_t marks = 0;
  double flooded = 0, removed = 0;
  bool is_found_stale = false;
  double found = 0;
};
inline Facts facts_of(const Engine& engine) {
  const ToyUndoable& toy = Toy::toy_undoable(engine.state());
  return {engine.version().get(),
          toy.marks,
          toy.flooded,
          engine.removed_mm3(),
          engine.state().is_result_stale<ToyFound>(),
          engine.state().result_of<ToyFound>()->number};
}

/// Interpreter of procedures. It stores a list of positions per branch, the instruments of the hands as
/// texts, and the events as names.
class Model {
 public:
  Model(const volume::SurgicalProcedure& procedure, std::size_t hands, PlantedFault fault)
      : procedure_(procedure), fault_(fault), hands_(hands), pressed_(hands, false) {
    now_.visits.assign(procedure.steps.size(), 0);
    now_.visits[0] = 1;
    branches_["main"] = {{now_}, 0};
  }

  const Position& now() const { return now_; }
  const volume::ProcedureStep& step() const { return procedure_.steps[static_cast<std::size_t>(now_.step)]; }
  const std::string& branch() const { return branch_; }

  /// Returns true if the list of a step allows an instrument, given as "name field=value field=value".
  bool allows_instrument(int step, const std::string& instrument) const {
    if (instrument.empty()) return true;
    const std::vector<std::string> has = split(instrument);
    for (const auto* list :
         {&procedure_.steps[static_cast<std::size_t>(step)].instruments, &procedure_.instruments})
      for (const std::string& entry : *list) {
        if (entry == "*") return true;
        bool fits = true;
        for (const std::string& word : split(entry))
          fits = fits && std::find(has.begin(), has.end(), word) != has.end();
        if (fits) return true;
      }
    return false;
  }
  bool allows_command(const std::string& name) const {
    static const std::set<std::string> always{"undo",       "redo",      "begin-branch",      "switch-branch",
                                              "note",       "adopt",     "remove-instrument", "release-body",
                                              "resume",     "adopt-job", "cancel-job",        "go-to-step",
                                              "free-pieces"};
    static const std::set<std::string> named{"set-effect",  "switch-item", "tool-geometry",
                                             "place-model", "place-body",  "discard-body"};
    if (always.contains(name)) return true;
    for (const auto* list : {&step().commands, &procedure_.commands})
      for (const std::string& entry : *list)
        if (entry == name || (entry == "*" && (fault_ == PlantedFault::lax_star || !named.contains(name))))
          return true;
    return false;
  }
  bool hands_allow(int step) const {
    if (fault_ == PlantedFault::blind_to_hands) return true;
    return std::all_of(hands_.begin(), hands_.end(),
                       [&](const std::string& hand) { return allows_instrument(step, hand); });
  }

  std::optional<double> value_of(const std::string& name, const Facts& facts) const {
    if (name == "removed_mm3") return facts.removed;
    if (name == "marks") return static_cast<double>(facts.marks);
    if (name == "changes")
      return static_cast<double>(branches_.at(branch_).second) + (is_changed_ && !in_stroke() ? 1 : 0);
    if (name == "step_seconds") return static_cast<double>(ticks_ - now_.entered_tick) * 1e-3;
    if (name == "found") return facts.is_found_stale ? std::nullopt : std::optional(facts.found);
    if (name.starts_with("visits "))
      for (std::size_t s = 0; s < procedure_.steps.size(); ++s)
        if ("visits " + procedure_.steps[s].name == name) return now_.visits[s];
    if (name.starts_with("events ")) {
      const std::size_t first = fault_ == PlantedFault::old_events ? 0 : now_.first_event;
      double count = 0;
      for (std::size_t i = first; i < events_.size(); ++i) count += "events " + events_[i] == name;
      return count;
    }
    return std::nullopt;
  }
  bool are_met(const volume::StepTransition& transition, const Facts& facts) const {
    for (const volume::StepCondition& condition : transition.conditions) {
      const std::optional<double> value = value_of(condition.measurement, facts);
      if (!value || (condition.minimum && *value < *condition.minimum) ||
          (condition.maximum && *value > *condition.maximum))
        return false;
      if (fault_ == PlantedFault::strict_limit && condition.minimum && *value == *condition.minimum)
        return false;
    }
    return true;
  }
  bool in_stroke() const { return std::find(pressed_.begin(), pressed_.end(), true) != pressed_.end(); }

  /// Returns false if the procedure must refuse a command. `gives`: the instrument that the command gives;
  /// may be empty.
  bool accepts(const Command& command, const std::string& gives, const Facts& facts) const {
    const std::string name(command.request.name());
    if (!gives.empty()) return allows_instrument(now_.step, gives);
    if (const auto* go = command.request.as<GoToStep>()) {
      for (const volume::StepTransition& transition : step().transitions)
        if (transition.on == "request" && transition.to == go->step && are_met(transition, facts) &&
            hands_allow(procedure_.find(go->step)))
          return true;
      return false;
    }
    const auto& [entries, at] = branches_.at(branch_);
    const Position* target = nullptr;
    if (name == "undo" && (is_changed_ || at > 0)) target = &entries[is_changed_ ? at : at - 1];
    if (name == "redo" && !is_changed_ && at + 1 < entries.size()) target = &entries[at + 1];
    if (const auto* other = command.request.as<SwitchBranch>()) {
      const auto& [others, position] = branches_.at(other->name);
      target = &others[position];
    }
    if (target && target->step != now_.step) return hands_allow(target->step);
    return allows_command(name);
  }

  void refuse(const std::string& request) { emit("refused " + request + " in " + step().name); }

  /// Applies a command that the engine accepted. `events`: names of the events that it caused, except those
  /// of the procedure.
  void command(const Command& command, const std::string& gives, const std::vector<std::string>& events,
               const Facts& before, const Facts& after) {
    const std::string name(command.request.name());
    const std::size_t first = events_.size();
    auto& [entries, at] = branches_.at(branch_);
    if (name == "undo") {
      end_stroke();
      if (at > 0) go_to(entries[--at]);
    } else if (name == "redo") {
      end_stroke();
      if (at + 1 < entries.size()) go_to(entries[++at]);
    } else if (const auto* begun = command.request.as<BeginBranch>()) {
      end_stroke();
      branches_[begun->name] = {{entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(at) + 1}, at};
      branch_ = begun->name;
    } else if (const auto* other = command.request.as<SwitchBranch>()) {
      end_stroke();
      branch_ = other->name;
      go_to(branches_.at(branch_).first[branches_.at(branch_).second]);
    } else if (const auto* go = command.request.as<GoToStep>()) {
      enter(procedure_.find(go->step));
    } else {
      if (name == "remove-instrument") {
        hands_[command.hand].clear(), pressed_[command.hand] = false;
        if (!in_stroke()) end_stroke();
      }
      if (!gives.empty() && name != "take-instrument") hands_[command.hand] = gives;
      is_changed_ = is_changed_ || before.version != after.version || before.marks != after.marks ||
                    before.flooded != after.flooded;
      events_.insert(events_.end(), events.begin(), events.end());
      if (name != "adopt-job" && name != "adopt")
        evaluate(name, first, after);
      else if (!events.empty() || (is_changed_ && !in_stroke()))
        evaluate("", first, after);
    }
    if (is_changed_ && !in_stroke()) end_stroke();
  }
  /// Applies the end of a job that gives an instrument.
  void give(int hand, const std::string& instrument) { hands_[static_cast<std::size_t>(hand)] = instrument; }

  void tick(std::size_t hand, std::uint64_t ticks, bool is_pressed, const std::vector<std::string>& events,
            const Facts& before, const Facts& after) {
    ticks_ = std::max(ticks_, ticks);
    const std::size_t first = events_.size();
    bool was_pressed = false;
    if (!hands_[hand].empty()) was_pressed = pressed_[hand], pressed_[hand] = is_pressed;
    is_changed_ = is_changed_ || before.version != after.version;
    events_.insert(events_.end(), events.begin(), events.end());
    const bool is_over = was_pressed && !in_stroke();
    if (is_over || !events.empty() || (is_changed_ && !in_stroke())) evaluate("", first, after);
    if (is_over || (is_changed_ && !in_stroke())) end_stroke();
  }

  std::vector<std::string> take_emitted() { return std::exchange(emitted_, {}); }
  std::vector<std::string> take_issued() { return std::exchange(issued_, {}); }

 private:
  void emit(const std::string& text) {
    emitted_.push_back(text);
    events_.push_back(text.starts_with("entered") ? "step-entered" : "step-refused");
  }
  void end_stroke() {
    pressed_.assign(pressed_.size(), false);
    if (!std::exchange(is_changed_, false)) return;
    auto& [entries, at] = branches_.at(branch_);
    entries.resize(at + 1);
    entries.push_back(now_);
    ++at;
  }
  void go_to(const Position& target) {
    const std::vector<std::uint32_t> visits = now_.visits;
    now_ = target;
    if (fault_ == PlantedFault::kept_visits) now_.visits = visits;
    now_.first_event = events_.size();
  }
  void enter(int next) {
    now_.step = next, now_.entered_tick = ticks_, now_.first_event = events_.size();
    ++now_.visits[static_cast<std::size_t>(next)];
    emit("entered " + step().name);
    is_changed_ = true;
    issued_ = step().on_entry;
  }
  void evaluate(const std::string& command, std::size_t first, const Facts& facts) {
    int taken = -1;
    std::string blocked;
    for (const volume::StepTransition& transition : step().transitions) {
      if (transition.on == "request") continue;
      bool is_caused = transition.on.empty() || transition.on == command;
      for (std::size_t i = first; i < events_.size(); ++i) is_caused |= events_[i] == transition.on;
      if (!is_caused || !are_met(transition, facts)) continue;
      const int next = procedure_.find(transition.to);
      if (!hands_allow(next)) {
        if (blocked.empty() && !transition.on.empty()) blocked = transition.to;
        continue;
      }
      if (taken < 0 || fault_ == PlantedFault::last_transition) taken = next;
    }
    if (taken >= 0)
      enter(taken);
    else if (!blocked.empty())
      refuse(blocked);
  }

  const volume::SurgicalProcedure& procedure_;
  PlantedFault fault_;
  Position now_;
  std::uint64_t ticks_ = 0;
  std::vector<std::string> hands_, events_, emitted_, issued_;
  std::vector<bool> pressed_;
  bool is_changed_ = false;
  std::string branch_ = "main";
  std::map<std::string, std::pair<std::vector<Position>, std::size_t>> branches_;
};

}  // namespace trephine::sim
