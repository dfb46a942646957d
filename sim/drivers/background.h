// Background: a thread for longer work during a live operation, started with the first work.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace trephine::sim {

/// Queue of work. The caller fetches results and applies them on its own thread.
class Background {
 public:
  using Result = std::function<void()>;
  using Work = std::function<Result()>;

  Background() = default;
  ~Background() { stop(); }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  void submit(Work work);
  /// Results since the last call, in order.
  std::vector<Result> take();
  /// True if no work is queued or running, and no result is to be taken.
  bool is_idle() const;
  /// Waits for the running work; discards queued work, and results that were not taken.
  void stop();

 private:
  void run();

  mutable std::mutex lock_;
  std::condition_variable wake_;
  std::deque<Work> waiting_;
  std::vector<Result> done_;
  bool is_busy_ = false, is_stopping_ = false;
  std::thread thread_;
};

}  // namespace trephine::sim
