// Waiting for the threads of drivers.
#pragma once

#include <chrono>
#include <thread>

namespace trephine::haptics {

inline void wait_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

/// Waits until a condition is true, at most 5 s. Returns false if it never is.
template <class Condition>
bool eventually(const Condition& condition) {
  for (int i = 0; i < 5000; ++i, wait_ms(1))
    if (condition()) return true;
  return false;
}

}  // namespace trephine::haptics
