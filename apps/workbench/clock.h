// Monotonic clock, with which windows and commands measure durations.
#pragma once

#include <chrono>

namespace trephine::workbench {

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace trephine::workbench
