// Core commands: the five groups of the table of commands, and a function that makes a row of the table.
#pragma once

#include <type_traits>

#include "sim/api/core_command.h"
#include "sim/engine/engine.h"

namespace trephine::sim {

// Each group is in the file of its part of the engine: engine_history, engine_settings, engine_bodies,
// engine_derived, engine_procedure.
std::span<const CoreCommand> history_commands() noexcept;
std::span<const CoreCommand> hand_commands() noexcept;
std::span<const CoreCommand> body_commands() noexcept;
std::span<const CoreCommand> derived_commands() noexcept;
std::span<const CoreCommand> procedure_commands() noexcept;

/// Returns the row of request T with `apply(engine, request, hand, outcome)` and `check(engine, request,
/// hand)`. A null pointer stands for a function that the command does not need. `row`: its other members.
template <class T, auto k_apply, auto k_check = nullptr>
CoreCommand core_command(CoreCommand row = {}) noexcept {
  row.type = &value_type<T>();
  if constexpr (!std::is_null_pointer_v<decltype(k_apply)>)
    row.apply = [](Engine& engine, const Command& command, Outcome& outcome) {
      k_apply(engine, *command.request.as<T>(), command.hand, outcome);
    };
  if constexpr (!std::is_null_pointer_v<decltype(k_check)>)
    row.check = [](const Engine& engine, const Command& command) -> Status {
      return k_check(engine, *command.request.as<T>(), command.hand);
    };
  return row;
}

}  // namespace trephine::sim
