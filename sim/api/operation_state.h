// OperationState: the state of an operation at one moment, without derived data (fields, bits, meshes).
#pragma once

#include <map>

#include "sim/api/body.h"
#include "sim/api/command.h"
#include "sim/api/event.h"
#include "sim/api/instrument.h"
#include "volume/cuts/version.h"

namespace trephine::sim {

/// Undoable state.
struct UndoableState {
  std::shared_ptr<const volume::Version> version;     ///< of the anatomy, which never moves
  std::vector<std::shared_ptr<const Value>> modules;  ///< one per module, in the session's order; may be null
  std::vector<Body> bodies;                           ///< detached from the anatomy, by ascending id
};

/// Persistent state: not changed by undo.
struct PersistentState {
  std::vector<Instrument> hands;
  /// The last command of each switch, moved model, effect and tool geometry, by name, hand and number:
  /// applying them again restores a state. Empty at the start of an operation.
  std::map<std::string, Command> latest_commands;
  std::vector<std::shared_ptr<const Value>> modules;  ///< as UndoableState::modules
};

struct OperationState {
  std::uint64_t next_tick = 0;  ///< one past the newest tick of any hand
  UndoableState world;
  PersistentState settings;
  Chronicle chronicle;
  std::vector<ForbiddenWatch> watches;  ///< hand by hand, one per forbidden structure

  /// Returns the state of a module; null if no module of this operation has such a state.
  template <HasSchema T>
  const T* undoable_of() const noexcept {
    return find_in<T>(world.modules);
  }
  template <HasSchema T>
  const T* persistent_of() const noexcept {
    return find_in<T>(settings.modules);
  }

  /// Returns the hash of the canonical bytes: equal for equal states. Requires a frozen version, or that no
  /// edit runs meanwhile.
  std::uint64_t hash() const;

 private:
  template <class T>
  static const T* find_in(const std::vector<std::shared_ptr<const Value>>& values) noexcept {
    for (const auto& value : values)
      if (const T* found = value ? value->template as<T>() : nullptr) return found;
    return nullptr;
  }
};

}  // namespace trephine::sim
