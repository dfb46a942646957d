// Parallel loops on std::jthread. All parallel loops of the libraries use this file. Results do not depend on
// the number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

#include "volume/base/cpu.h"

namespace trephine {

/// Calls body(i) once for each i in [0, count), and returns when all calls have returned. Each thread takes
/// the next i after each call. body must write only data that belong to i. If body throws, calls that have
/// not started are skipped, and the first exception is rethrown.
template <class Body>
void parallel_for(int count, int threads, const Body& body) {
  threads = std::min(thread_count(threads), count);
  if (threads <= 1) {
    for (int i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<int> next{0};
  std::atomic<bool> has_failed{false};
  std::exception_ptr failure;
  const auto work = [&]() noexcept {
    try {
      for (int i = next.fetch_add(1); i < count && !has_failed; i = next.fetch_add(1)) body(i);
    } catch (...) {
      if (!has_failed.exchange(true)) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> helpers;
    try {
      for (int t = 1; t < threads; ++t) helpers.emplace_back(work);
    } catch (const std::system_error&) {
      // The threads that have started do all the work.
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace trephine
