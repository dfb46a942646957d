// Commands that steps of a procedure issue when they begin. Included by drivers only.
#pragma once

#include <utility>
#include <vector>

#include "sim/api/command.h"

namespace trephine::sim {

/// Largest number of commands that steps may issue in a row; ends a cycle of steps that issue commands.
inline constexpr std::size_t k_max_issued = 256;

/// Applies commands in order, and then those that they cause. `apply(command)` returns these.
template <class Apply>
void issue(std::vector<Command> commands, Apply&& apply) {
  for (std::size_t i = 0; i < commands.size() && i < k_max_issued; ++i) {
    const Command next = commands[i];
    for (Command& caused : apply(next)) commands.push_back(std::move(caused));
  }
}

}  // namespace trephine::sim
