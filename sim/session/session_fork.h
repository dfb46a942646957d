// fork_session(): a new session that begins with a part of a recorded one and can be continued.
#pragma once

#include <cstdint>
#include <string>

#include "volume/base/error.h"

namespace trephine::sim {

/// Copies the blocks of a session whose ticks are all before `tick` into a new file. The new file has no end
/// block and can be continued. Returns the number of ticks in the new file: `tick`, or less by at most one
/// block (8 kB of the log or 1000 ticks; 25 ms of a live session). Error, without a new file, if `path` is
/// not a session or is damaged, `tick` is after its end, no block ends before `tick`, or the new file exists.
Result<std::uint64_t> fork_session(const std::string& path, std::uint64_t tick,
                                   const std::string& destination);

}  // namespace trephine::sim
