#include "sim/drivers/background.h"

#include <algorithm>

namespace trephine::sim {

void Background::submit(Priority priority, Work work) {
  {
    const std::lock_guard guard(lock_);
    Queue& queue = queues_[static_cast<std::size_t>(priority)];
    queue.waiting.push_back(std::move(work));
    if (!std::exchange(queue.has_thread, true)) threads_.emplace_back([this] { run(); });
  }
  wake_.notify_one();
}

std::vector<Background::Result> Background::fetch_results() {
  const std::lock_guard guard(lock_);
  std::vector<Result> results;
  for (auto& [priority, result] : done_) results.push_back(std::move(result));
  done_.clear();
  return results;
}

bool Background::is_idle(Priority priority) const {
  const std::lock_guard guard(lock_);
  const Queue& queue = queues_[static_cast<std::size_t>(priority)];
  return queue.waiting.empty() && !queue.is_running &&
         std::none_of(done_.begin(), done_.end(), [&](const auto& one) { return one.first == priority; });
}

void Background::stop() {
  {
    const std::lock_guard guard(lock_);
    is_stopping_ = true;
    for (Queue& queue : queues_) queue.waiting.clear();
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  for (Queue& queue : queues_) queue.has_thread = false;
  is_stopping_ = false;
  done_.clear();
}

Background::Queue* Background::next() noexcept {
  for (Queue& queue : queues_)
    if (!queue.waiting.empty() && !queue.is_running) return &queue;
  return nullptr;
}

void Background::run() {
  std::unique_lock guard(lock_);
  for (;;) {
    Queue* queue = nullptr;
    wake_.wait(guard, [&] { return is_stopping_ || (queue = next()) != nullptr; });
    if (is_stopping_) return;
    Work work = std::move(queue->waiting.front());
    queue->waiting.pop_front();
    queue->is_running = true;
    guard.unlock();
    Result result = work();
    work = {};  // may own the last reference to a version, which is freed here without the lock
    guard.lock();
    queue->is_running = false;
    if (result) done_.emplace_back(static_cast<Priority>(queue - queues_.data()), std::move(result));
  }
}

}  // namespace trephine::sim
