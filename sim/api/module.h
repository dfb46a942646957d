// Module: an extension of an operation with commands, jobs, instruments, state, events and measures. A module
// is constant; its state belongs to the operation.
#pragma once

#include <span>

#include "sim/api/command.h"
#include "sim/api/finding.h"
#include "sim/api/forbidden.h"
#include "sim/api/operation_state.h"
#include "sim/api/overlay.h"

namespace trephine::sim {

/// State of one module in an operation.
class ModuleState {
 public:
  /// `edits`: OperationState::edits of the anatomy that new results describe.
  ModuleState(std::shared_ptr<const Value>& undoable, std::shared_ptr<const Value>& settings,
              ModuleResult& result, std::uint64_t edits)
      : undoable_(&undoable), settings_(&settings), result_(&result), edits_(edits) {}

  template <HasSchema T>
  const T& undoable() const noexcept {
    return *(*undoable_)->as<T>();
  }
  template <HasSchema T>
  const T& settings() const noexcept {
    return *(*settings_)->as<T>();
  }
  /// Undoable state, for writing.
  template <HasSchema T>
  T& change_undoable() {
    is_undoable_changed_ = true;
    return change<T>(*undoable_);
  }
  /// Persistent state, for writing.
  template <HasSchema T>
  T& change_settings() {
    return change<T>(*settings_);
  }
  bool is_undoable_changed() const noexcept { return is_undoable_changed_; }
  template <HasSchema T>
  const T& result() const noexcept {
    return *result_->value->as<T>();
  }
  /// Newest result, for writing. The new result describes the current anatomy or, if a job computed it, the
  /// anatomy with which the job began.
  template <HasSchema T>
  T& change_result() {
    result_->edits = edits_;
    return change<T>(result_->value);
  }

 private:
  /// Replaces the value by a copy, since other states may share it.
  template <class T>
  static T& change(std::shared_ptr<const Value>& value) {
    auto copy = std::make_shared<Value>(*value);
    T& object = *copy->template as<T>();
    value = std::move(copy);
    return object;
  }
  std::shared_ptr<const Value>*undoable_, *settings_;
  ModuleResult* result_;
  std::uint64_t edits_;
  bool is_undoable_changed_ = false;
};

/// Reaction of a module to an event or a command: changes of its own state, and further events.
class ModuleReaction : public ModuleState {
 public:
  ModuleReaction(const ModuleState& state, std::vector<Event>& events, std::uint64_t tick, std::uint8_t hand)
      : ModuleState(state), events_(&events), tick_(tick), hand_(hand) {}
  /// Emits an event, which all modules receive after the current one. Ignored if the tick or command already
  /// has 1000 events.
  void raise_event(Value value, const glm::dvec3& position_world);

 private:
  std::vector<Event>* events_;
  std::uint64_t tick_;
  std::uint8_t hand_;
};

/// Changes that a command, or the adoption of a job's result, may make.
class ModuleWork : public Work, public ModuleState {
 public:
  ModuleWork(const Work& work, const ModuleState& state) : Work(work), ModuleState(state) {}
  /// Restores all matter that was removed since the start.
  void restore_all() noexcept { is_restored_ = true; }
  bool is_restored() const noexcept { return is_restored_; }
  /// Removes a body, such as an implant of the module. Unknown ids are ignored.
  void remove_body(Id body) { removed_bodies_.push_back(body); }
  std::span<const Id> removed_bodies() const noexcept { return removed_bodies_; }

 private:
  bool is_restored_ = false;
  std::vector<Id> removed_bodies_;
};

/// Result of a job. Immutable.
class JobResult {
 public:
  virtual ~JobResult() = default;
  virtual std::uint64_t hash() const = 0;  ///< must be fast, since the edit thread calls it
  /// Parts that the job detaches from the anatomy, adopted as bodies with the result. Null: no parts.
  virtual const Detachment* detachment() const noexcept { return nullptr; }
  /// Implants that the job adds, adopted with the result.
  virtual std::span<const NewBody> bodies() const noexcept { return {}; }
  /// Reason why the job failed and has no effect on anatomy and bodies; empty if it succeeded. adopt() is
  /// called in both cases, and emits the event that reports the failure or the success.
  virtual std::string_view failure() const noexcept { return {}; }
};

/// Input of a job; immutable.
struct JobInput {
  const OperationState& state;
  /// The uncut anatomy as the job's hand touches it.
  const haptics::TouchScene& anatomy;
  std::vector<volume::Field> solids;                                 ///< fields of all matter that can be cut
  std::span<const std::shared_ptr<const Forbidden>> forbidden = {};  ///< structures not to be entered
};

/// Work that takes longer than a command may (2 ms): a pure function of immutable data, with the same bits
/// for any number of threads.
struct JobType {
  const ValueType* parameters;  ///< a command of this value starts it
  std::shared_ptr<const JobResult> (*run)(const void* parameters, const JobInput& input);
  /// Returns true if the result may be adopted although the state has changed. Null: it may always be
  /// adopted.
  bool (*is_result_valid)(const void* parameters, const OperationState& input, const OperationState& current);
  void (*adopt)(const void* parameters, const JobResult& result, ModuleWork& work);
  /// Checks the parameters against the hand's anatomy. Null: all are valid.
  Status (*check)(const void* parameters, const haptics::TouchScene& anatomy) = nullptr;
  bool detaches_body = false;    ///< requires room for one more body before it starts
  bool depends_on_cuts = false;  ///< a result from before a cut or an undo is discarded
};

class Module {
 public:
  virtual ~Module() = default;
  virtual std::string_view name() const noexcept = 0;
  /// Increases with every change that gives other bits for the same input.
  virtual std::uint32_t version() const noexcept { return 1; }

  virtual std::span<const InstrumentType* const> instruments() const { return {}; }
  virtual std::span<const ValueType* const> commands() const { return {}; }
  virtual std::span<const JobType* const> jobs() const { return {}; }
  virtual std::span<const ValueType* const> events() const { return {}; }
  /// Initial undoable state; empty: the module has no such state.
  virtual Value undoable() const { return {}; }
  /// Initial persistent state; empty: the module has no such state.
  virtual Value settings() const { return {}; }
  /// Initial result, such as a judgement of the anatomy. Undo does not change
  /// it, but makes it stale. Empty: the module has no results.
  virtual Value result() const { return {}; }

  /// Guard: called before a command of any module or of the engine is carried out, except Resume and the
  /// adoptions of results. An Error refuses the command.
  virtual Status allows(const Command& command, const OperationState& state) const;
  /// Carries out a command of this module, in at most 2 ms. Cannot fail: allows() has refused invalid ones.
  virtual void apply(const Command& command, ModuleWork& work) const;
  /// Handles an event of any module. `state`: of the operation when the event was raised.
  virtual void react(const Event& event, const OperationState& state, ModuleReaction& reaction) const;
  /// Handles a command of any module or of the engine, such as undo, after it was carried out. Adoptions of
  /// derived data and of the results of jobs are left out.
  virtual void react_to_command(const Command& command, const OperationState& state,
                                ModuleReaction& reaction) const;
  virtual std::vector<Measure> measures(const OperationState& state) const;
  /// Judges the current operation for a score, from state, chronicle and plan alone; may take seconds. Order
  /// and names are constant for a plan. Called on a frozen state, on any thread.
  virtual std::vector<Finding> findings(const JobInput& input) const;
  /// Returns true if its overlays change with time; they are then fetched in every frame.
  virtual bool is_moving(const OperationState& state) const;
  /// Returns overlays of its state, world frame, in at most 0.2 ms. Called only while a display fetches them.
  virtual Overlays overlays(const OperationState& state) const;
};

}  // namespace trephine::sim
