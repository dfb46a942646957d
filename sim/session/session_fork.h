// fork_session(): a new session that begins with a part of a recorded one and can be continued.
#pragma once

#include <cstdint>
#include <string>

#include "volume/base/error.h"

namespace trephine::sim {

/// Copies the blocks of a session whose ticks are all before `tick` into a new file, which has no end and can
/// be continued. Returns the number of ticks in it: at most `tick`, and less by at most one block (8 kB of
/// the log or 1000 ticks; 25 ms of a live session). Error if the file is no session or is damaged, `tick` is
/// after its end, no block is before it, or the new file exists; then nothing is written.
Result<std::uint64_t> fork_session(const std::string& path, std::uint64_t tick,
                                   const std::string& destination);

}  // namespace trephine::sim
