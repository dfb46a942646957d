// Commands that steps of a procedure issue when they begin. Included by drivers only.
#pragma once

#include <utility>
#include <vector>

#include "sim/api/command.h"

namespace trephine::sim {

/// Applies commands in order, and then the commands that they cause. `apply(command)` returns the commands
/// that a command causes. The engine ends cycles of steps, see Engine::k_max_steps_per_tick.
template <class Apply>
void issue(std::vector<Command> commands, Apply&& apply) {
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const Command next = commands[i];
    for (Command& caused : apply(next)) commands.push_back(std::move(caused));
  }
}

}  // namespace trephine::sim
