// How many instructions a piece of work takes, exactly, on any machine: a child process is stepped through it
// one by one.
#pragma once

#include <functional>
#include <optional>

namespace trephine::bench {

/// Instructions that this program's own code spends on `work`, without the kernel's. The work is done in a
/// copy of the process: nothing of it is seen here, and other threads do not exist there. Some 20 us an
/// instruction. Nothing where processes may not be traced.
std::optional<long> count_instructions(const std::function<void()>& work);

}  // namespace trephine::bench
