// OperationState: the state of an operation at one moment, without derived data (fields, bits, meshes).
#pragma once

#include <map>

#include "sim/api/body.h"
#include "sim/api/command.h"
#include "sim/api/event.h"
#include "sim/api/instrument.h"
#include "volume/cuts/version.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::sim {

/// Position in the procedure of the plan.
struct ProcedurePosition {
  std::int32_t step = -1;          ///< index; -1: no procedure
  std::uint64_t entered_tick = 0;  ///< when the step began
  /// Number of events in the chronicle when the step began, or at the last undo, redo or change of branch
  /// since then. Conditions count later events only.
  std::uint64_t first_event = 0;
  std::vector<std::uint32_t> visits;  ///< per step, number of times that it began
  friend bool operator==(const ProcedurePosition&, const ProcedurePosition&) = default;
};

/// Undoable state.
struct UndoableState {
  std::shared_ptr<const volume::Version> version;     ///< of the anatomy, which never moves
  std::vector<std::shared_ptr<const Value>> modules;  ///< one per module, in the session's order; may be null
  std::vector<Body> bodies;                           ///< detached parts and implants, by ascending id
  ProcedurePosition procedure;
};

/// Result that a module computed about the anatomy, such as a judgement or a preview.
struct ModuleResult {
  std::shared_ptr<const Value> value;  ///< null: the module has no results
  std::uint64_t edits = 0;             ///< OperationState::edits of the anatomy that it describes
};

/// Persistent state: not changed by undo.
struct PersistentState {
  std::vector<Instrument> hands;
  /// The last command of each switch, moved model, effect and tool geometry, by name, hand and number:
  /// applying them again restores a state. Empty at the start of an operation.
  std::map<std::string, Command> latest_commands;
  std::vector<std::shared_ptr<const Value>> modules;  ///< as UndoableState::modules
  std::vector<ModuleResult> results;                  ///< one per module
};

struct OperationState {
  std::uint64_t next_tick = 0;  ///< one past the newest tick of any hand
  double dt = 0;                ///< s, period of the servo; constant
  /// Number of changes of the anatomy so far: cuts, detachments, restorations, undo, redo, and the
  /// beginning or the choice of a branch.
  std::uint64_t edits = 0;
  /// Plan of the operation, constant; null: nothing is planned. Part of a session's header, not of hash().
  std::shared_ptr<const volume::SurgicalPlan> plan;
  UndoableState undoable;
  PersistentState settings;
  Chronicle chronicle;
  std::vector<ForbiddenWatch> watches;  ///< hand by hand, one per forbidden structure

  /// Time of the next tick, s.
  double seconds() const noexcept { return static_cast<double>(next_tick) * dt; }

  /// Returns the state of a module; null if no module of this operation has such a state.
  template <HasSchema T>
  const T* undoable_of() const noexcept {
    return find_in<T>(undoable.modules);
  }
  template <HasSchema T>
  const T* persistent_of() const noexcept {
    return find_in<T>(settings.modules);
  }

  /// Returns the newest result of a module; null if no module of this operation has such results.
  template <HasSchema T>
  const T* result_of() const noexcept {
    const ModuleResult* found = find_result<T>();
    return found ? found->value->template as<T>() : nullptr;
  }
  /// Returns true if the anatomy has changed since the state that the newest result of this type describes.
  template <HasSchema T>
  bool is_result_stale() const noexcept {
    const ModuleResult* found = find_result<T>();
    return found != nullptr && found->edits != edits;
  }

  /// Returns the hash of the canonical bytes: equal for equal states. Requires a frozen version, or that no
  /// edit runs at the same time.
  std::uint64_t hash() const;

 private:
  template <class T>
  const ModuleResult* find_result() const noexcept {
    for (const ModuleResult& result : settings.results)
      if (result.value && result.value->template as<T>()) return &result;
    return nullptr;
  }
  template <class T>
  static const T* find_in(const std::vector<std::shared_ptr<const Value>>& values) noexcept {
    for (const auto& value : values)
      if (const T* found = value ? value->template as<T>() : nullptr) return found;
    return nullptr;
  }
};

}  // namespace trephine::sim
