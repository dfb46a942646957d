#include "sim/drivers/background.h"

#include <utility>

namespace trephine::sim {

void Background::submit(Work work) {
  {
    const std::lock_guard guard(lock_);
    waiting_.push_back(std::move(work));
    if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  }
  wake_.notify_one();
}

std::vector<Background::Result> Background::take() {
  const std::lock_guard guard(lock_);
  return std::exchange(done_, {});
}

bool Background::is_idle() const {
  const std::lock_guard guard(lock_);
  return waiting_.empty() && done_.empty() && !is_busy_;
}

void Background::stop() {
  {
    const std::lock_guard guard(lock_);
    is_stopping_ = true;
    waiting_.clear();
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
  thread_ = {};
  is_stopping_ = false;
  done_.clear();
}

void Background::run() {
  std::unique_lock guard(lock_);
  for (;;) {
    wake_.wait(guard, [this] { return !waiting_.empty() || is_stopping_; });
    if (is_stopping_) return;
    Work work = std::move(waiting_.front());
    waiting_.pop_front();
    is_busy_ = true;
    guard.unlock();
    Result result = work();
    work = {};  // perhaps the last owner of a version: freed while no caller waits
    guard.lock();
    is_busy_ = false;
    if (result) done_.push_back(std::move(result));
  }
}

}  // namespace trephine::sim
