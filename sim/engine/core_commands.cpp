#include "sim/engine/core_commands.h"

#include <algorithm>

namespace trephine::sim {

std::span<const CoreCommand> core_commands() noexcept {
  static const std::vector<CoreCommand> all = [] {
    std::vector<CoreCommand> rows;
    for (const auto group :
         {history_commands(), hand_commands(), body_commands(), derived_commands(), procedure_commands()})
      rows.insert(rows.end(), group.begin(), group.end());
    return rows;
  }();
  return all;
}

const CoreCommand* find_core_command(const ValueType& type) noexcept {
  const std::span<const CoreCommand> all = core_commands();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const CoreCommand& row) { return row.type == &type; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace trephine::sim
