// CoreCommand: a command that every engine has, whatever its modules. sim/engine defines the core commands.
#pragma once

#include <span>

#include "sim/api/command.h"

namespace trephine::sim {

class Engine;
struct Outcome;

/// Permission of a command in a step of a procedure.
enum class StepRule : std::uint8_t {
  every_step,  ///< allowed in every step
  listed,      ///< allowed if the step or the procedure lists its name or "*"
  named  ///< allowed only if the step or the procedure lists its name; "*" is not enough, since the command
         ///< bypasses instruments
};

/// Row of the table of commands: a command with its check and its effect.
struct CoreCommand {
  const ValueType* type = nullptr;
  /// Returns the reason to refuse the command in the current state. Null: it is never refused.
  Status (*check)(const Engine& engine, const Command& command) = nullptr;
  /// Applies a checked command. Null: it changes nothing.
  void (*apply)(Engine& engine, const Command& command, Outcome& outcome) = nullptr;
  /// Applies a setting of PersistentState::latest_commands again, without a new scene. Null: the
  /// command is not such a setting.
  Status (*restore)(Engine& engine, const Command& command) = nullptr;
  /// Releases data that were submitted for a refused command. Null: no data belong to it.
  void (*discard)(Engine& engine, const Command& command) = nullptr;
  bool is_for_users = true;          ///< users and scripts may send it; other commands are issued by drivers
  bool is_guarded = true;            ///< modules may refuse it
  bool is_passed_to_modules = true;  ///< modules receive it
  StepRule step_rule = StepRule::listed;
  bool causes_transitions = true;  ///< may cause a transition of the procedure
};

/// Returns the commands of every engine in constant order: history, hands, bodies, derived data, procedure.
std::span<const CoreCommand> core_commands() noexcept;
/// Finds a command by the type of its request; null if it belongs to a module.
const CoreCommand* find_core_command(const ValueType& type) noexcept;

}  // namespace trephine::sim
