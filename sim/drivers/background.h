// Background: threads for longer work during a live operation, by priority.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace trephine::sim {

/// Priorities of longer work, most urgent first.
enum class Priority : std::uint8_t {
  depths,      ///< depth images and pictures: a hand loses contact without them
  fields,      ///< offset fields: a tool hovers until they are adopted
  jobs,        ///< jobs that a person waits for, such as a bone flap
  search,      ///< results that nothing waits for, such as loose parts
  preparation  ///< data that may be needed later, such as fields of the next instruments
};

/// Queues of work, one per priority. Work of one priority runs in order, one at a time. A free thread starts
/// the most urgent work that can run. There are as many threads as priorities in use, so that work never
/// waits for work of another priority. The caller fetches results and applies them on its own thread.
class Background {
 public:
  using Result = std::function<void()>;
  using Work = std::function<Result()>;
  static constexpr std::size_t k_priorities = 5;

  Background() = default;
  ~Background() { stop(); }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  void submit(Priority priority, Work work);
  /// Results since the last call, in the order in which the work ended.
  std::vector<Result> fetch_results();
  /// True if no work of this priority is queued or running, and none of its results waits for
  /// fetch_results().
  bool is_idle(Priority priority) const;
  /// Waits for running work. Discards queued work, and results that were not fetched.
  void stop();

 private:
  struct Queue {
    std::deque<Work> waiting;
    bool is_running = false, has_thread = false;
  };
  void run();
  /// Returns the most urgent queue from which work can start, or null. Requires the lock.
  Queue* next() noexcept;

  mutable std::mutex lock_;
  std::condition_variable wake_;
  std::array<Queue, k_priorities> queues_;  ///< by priority
  std::vector<std::pair<Priority, Result>> done_;
  bool is_stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace trephine::sim
