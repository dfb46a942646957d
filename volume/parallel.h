// Parallel loops on std::thread, the only ones below apps. Results never depend on the number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace trephine::volume {

/// Threads a call may use; 0 asks for all cores.
inline int thread_count(int wanted) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return wanted > 0 ? wanted : cores;
}

/// Calls body(i) once for each i in [0, count), handed out one by one; returns when all are done.
/// body must not throw and must write only what belongs to i.
template <class Body>
void parallel_for(int count, int threads, const Body& body) {
  threads = std::min(thread_count(threads), count);
  if (threads <= 1) {
    for (int i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next.fetch_add(1); i < count; i = next.fetch_add(1)) body(i);
  };
  std::vector<std::jthread> helpers;
  for (int t = 1; t < threads; ++t) helpers.emplace_back(work);
  work();
}

}  // namespace trephine::volume
