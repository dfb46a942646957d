// Extension of an operation: commands, jobs, instruments, state, events, measures. A module is
// constant; its state is the operation's.
#pragma once

#include <span>

#include "sim/command.h"
#include "sim/forbidden.h"
#include "sim/operation_state.h"
#include "sim/overlay.h"

namespace trephine::sim {

/// A module's own state.
class ModuleState {
 public:
  ModuleState(std::shared_ptr<const Value>& world, std::shared_ptr<const Value>& settings)
      : world_(&world), settings_(&settings) {}

  template <HasSchema T>
  const T& world() const noexcept {
    return *(*world_)->as<T>();
  }
  template <HasSchema T>
  const T& settings() const noexcept {
    return *(*settings_)->as<T>();
  }
  /// To be written: what undo takes back ...
  template <HasSchema T>
  T& change_world() {
    is_world_changed_ = true;
    return change<T>(*world_);
  }
  /// ... and what it leaves alone.
  template <HasSchema T>
  T& change_settings() {
    return change<T>(*settings_);
  }
  bool is_world_changed() const noexcept { return is_world_changed_; }

 private:
  /// Others may hold the old one.
  template <class T>
  static T& change(std::shared_ptr<const Value>& held) {
    auto copy = std::make_shared<Value>(*held);
    T& inside = *copy->template as<T>();
    held = std::move(copy);
    return inside;
  }
  std::shared_ptr<const Value>*world_, *settings_;
  bool is_world_changed_ = false;
};

/// Changes that a command or the end of a job may make.
class ModuleWork : public Work, public ModuleState {
 public:
  ModuleWork(const Work& work, const ModuleState& state) : Work(work), ModuleState(state) {}
  /// Everything that was removed since the start is there again: matter grows.
  void put_all_back() noexcept { is_put_back_ = true; }
  bool is_put_back() const noexcept { return is_put_back_; }

 private:
  bool is_put_back_ = false;
};

/// Result of a job. Immutable.
class JobResult {
 public:
  virtual ~JobResult() = default;
  virtual std::uint64_t hash() const = 0;  ///< worked out when it is made: asked on the edit thread
  /// Parts that the job detaches from the anatomy: adopted with the result, as bodies. Null: nothing is cut.
  virtual const CameOff* came_off() const noexcept { return nullptr; }
};

/// Input of a job: immutable.
struct JobInput {
  const OperationState& state;
  /// As the job's hand feels the anatomy when nothing is cut.
  const haptics::TouchScene& anatomy;
  std::vector<volume::Field> solids;                                 ///< what counts as matter when it is cut
  std::span<const std::shared_ptr<const Forbidden>> forbidden = {};  ///< what must not be
};

/// Work that takes longer than a command may (2 ms): a pure function of immutable things, with the same bits
/// for any number of threads.
struct JobType {
  const ValueType* parameters;  ///< a command of this value begins it
  std::shared_ptr<const JobResult> (*run)(const void* parameters, const JobInput& input);
  /// The world changed since: may the result still be taken over? Null: whatever happened.
  bool (*still_fits)(const void* parameters, const OperationState& input, const OperationState& now);
  void (*adopt)(const void* parameters, const JobResult& result, ModuleWork& work);
  /// Checks its parameters against the hand's anatomy; null: they always fit.
  volume::Status (*check)(const void* parameters, const haptics::TouchScene& anatomy) = nullptr;
  bool frees_bodies = false;  ///< there must be room for one before it begins
  bool is_of_cuts = false;    ///< what was made before a cut, or an undo, is not taken over after it
};

class Module {
 public:
  virtual ~Module() = default;
  virtual std::string_view name() const noexcept = 0;
  /// Raised with every change that gives other bits for the same input.
  virtual std::uint32_t version() const noexcept { return 1; }

  virtual std::span<const InstrumentType* const> instruments() const { return {}; }
  virtual std::span<const ValueType* const> commands() const { return {}; }
  virtual std::span<const JobType* const> jobs() const { return {}; }
  virtual std::span<const ValueType* const> events() const { return {}; }
  /// As it begins; empty: it has none.
  virtual Value world() const { return {}; }
  virtual Value settings() const { return {}; }

  /// The guard: asked about every command, of whatever module, before anything is done. An Error refuses it.
  virtual volume::Status allows(const Command& command, const OperationState& now) const;
  /// Carries out a command of its own, in at most 2 ms. What could go wrong was refused by allows().
  virtual void apply(const Command& command, ModuleWork& work) const;
  /// Something happened, in whatever module. Changes its own state only.
  virtual void react(const Event& event, ModuleState& state) const;
  virtual std::vector<Measure> measures(const OperationState& now) const;
  /// Overlays of its state, in the world; at most 0.2 ms. Asked only while a display fetches them.
  virtual Overlays overlays(const OperationState& now) const;
};

}  // namespace trephine::sim
