// Exact number of instructions of a piece of work, on any machine: a child process is single-stepped.
#pragma once

#include <functional>
#include <optional>

namespace trephine::bench {

/// Instructions that this program's own code spends on `work`, without the kernel's. The work runs in a copy
/// of the process without other threads, and its effects are lost. Takes about 20 us per instruction. Empty
/// if processes may not be traced.
std::optional<long> count_instructions(const std::function<void()>& work);

}  // namespace trephine::bench
