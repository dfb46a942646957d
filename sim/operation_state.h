// All that an operation is at one moment. What is derived of it (fields, bits, meshes) is not in it.
#pragma once

#include <map>

#include "sim/body.h"
#include "sim/command.h"
#include "sim/event.h"
#include "sim/instrument.h"
#include "volume/version.h"

namespace trephine::sim {

/// Undoable state.
struct World {
  std::shared_ptr<const volume::Version> version;     ///< of the anatomy, that never moves
  std::vector<std::shared_ptr<const Value>> modules;  ///< one a module, in the session's order; may be null
  std::vector<Body> bodies;                           ///< in addition to the anatomy, by rising id
};

/// Persistent state: undo leaves it alone.
struct Settings {
  std::vector<Instrument> hands;
  /// The last command of each switch, place, effect and tool geometry, by name, hand and number: a state is
  /// restored by applying them again. Empty: as it began.
  std::map<std::string, Command> told;
  std::vector<std::shared_ptr<const Value>> modules;  ///< as the world's
};

struct OperationState {
  std::uint64_t next_tick = 0;  ///< one past the newest of any hand
  World world;
  Settings settings;
  Chronicle chronicle;
  std::vector<ForbiddenWatch> watches;  ///< each forbidden structure, hand by hand

  /// A module's own; null where it is not of this operation.
  template <HasSchema T>
  const T* world_of() const noexcept {
    return held_in<T>(world.modules);
  }
  template <HasSchema T>
  const T* settings_of() const noexcept {
    return held_in<T>(settings.modules);
  }

  /// Hash of the canonical bytes of all of it: the same for the same state. The version is frozen, or no edit
  /// runs meanwhile.
  std::uint64_t hash() const;

 private:
  template <class T>
  static const T* held_in(const std::vector<std::shared_ptr<const Value>>& values) noexcept {
    for (const auto& value : values)
      if (const T* held = value ? value->template as<T>() : nullptr) return held;
    return nullptr;
  }
};

}  // namespace trephine::sim
