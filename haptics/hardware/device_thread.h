// DeviceThread: the thread of a driver, which waits for hardware so that the servo does not.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "haptics/servo/servo_loop.h"

namespace trephine::haptics {

/// Returns the time of the monotonic clock, s.
inline double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Runs a function until it returns false or stop() is called, with real-time priority if it is permitted.
class DeviceThread {
 public:
  ~DeviceThread() { stop(); }
  template <class Step>
  void start(Step step) {
    stop();
    is_stopping_ = false;
    thread_ = std::thread([this, step]() mutable {
      constexpr int k_priority = 70;  // below the servo's
      request_realtime(k_priority);
      while (!is_stopping_ && step()) {}
    });
  }
  void stop() noexcept {
    is_stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  std::atomic<bool> is_stopping_{false};
  std::thread thread_;
};

/// Decides by the time of the servo whether a device still sends reports.
class ReportTimeout {
 public:
  explicit ReportTimeout(double limit_seconds) : limit_(limit_seconds) {}
  /// Returns true if no new report arrived for longer than the limit. `count`: number of reports so far.
  bool has_expired(double t, std::uint64_t count) noexcept {
    if (!has_time_ || count != count_ || t < since_) since_ = t, count_ = count, has_time_ = true;
    return t - since_ > limit_;
  }
  void restart() noexcept { has_time_ = false; }

 private:
  double limit_, since_ = 0;
  std::uint64_t count_ = 0;
  bool has_time_ = false;
};

}  // namespace trephine::haptics
