// The servo: pose in, proxy and force out, at 250 Hz to 10 kHz on a thread of its own.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "haptics/device/device.h"
#include "haptics/servo/histogram.h"
#include "haptics/servo/ring.h"
#include "haptics/servo/servo_core.h"

namespace trephine::haptics {

struct ServoOptions {
  double rate_hz = 1000;  ///< 250 to 10000
  ForceOptions force;
  double watchdog_seconds = 0.1;  ///< a tick later than this fades the force
  double lag_seconds = 0.5;       ///< edits farther behind than this make the scene stale: the force fades
  /// Records of ticks on their way to the edits; 0: twice what `lag_seconds` fill at this rate. In a smaller
  /// one half of it makes the scene stale.
  std::size_t ring_capacity = 0;
  bool wants_realtime = true;  ///< SCHED_FIFO and locked memory, when allowed
};

/// Figures of a running or finished loop.
struct ServoReport {
  std::uint64_t ticks = 0, overruns = 0;  ///< overrun: a tick that began a whole period late
  std::uint64_t dropped = 0;              ///< ticks for whose records the ring had no room
  double step_p50_us = 0, step_p99_us = 0, step_p999_us = 0, step_max_us = 0;
  double late_p50_us = 0, late_p99_us = 0, late_p999_us = 0, late_max_us = 0;  ///< wake-up after its due time
  std::uint32_t faults = 0;
  std::string notice;  ///< what real-time help was refused, in words; empty when all was granted
};

/// One thread for all hands: every device is read, stepped and answered in each tick, on one version.
class ServoLoop {
 public:
  /// Borrows everything for its life. `first_tick`: where the count goes on (a resumed session).
  ServoLoop(std::span<Device* const> devices, ServoChannel& channel, const ServoOptions& options,
            std::uint64_t first_tick = 0);
  /// One hand.
  ServoLoop(Device& device, ServoChannel& channel, const ServoOptions& options);
  ~ServoLoop();
  ServoLoop(const ServoLoop&) = delete;
  ServoLoop& operator=(const ServoLoop&) = delete;

  /// Opens the devices and starts the thread. A device that does not open closes those before it. Error when
  /// the loop runs.
  volume::Status start();
  /// Stops the thread and closes the devices; a second call does nothing.
  void stop();

  /// Consumer's end of the records, a tick's hands in order; one thread. When the ring is full, whole ticks
  /// are dropped: the proxies stand still, the force fades out, and the fault is latched.
  Ring<ServoRecord>& records() noexcept { return ring_; }
  /// Asks the servo to put a hand's proxy on a free point (volume frame) at its next tick, with force from
  /// zero. These requests come from one thread, the edit thread.
  void request_restart(const glm::dvec3& free_point_volume, std::size_t hand = 0) noexcept;
  /// Clears latched faults of all hands at the next tick; their proxies start again at the HIP, the force
  /// from zero. A person asks for it, once the cause is gone.
  void request_reset() noexcept { wants_reset_ = true; }
  ServoReport report() const;

 private:
  struct Hand {
    Device* device;
    ServoCore core;
    Pose pose;
    std::uint32_t faults = 0;
    Ring<glm::dvec3> restarts{16};
  };
  void run() noexcept;
  void tick(std::uint64_t tick, std::uint32_t faults) noexcept;

  std::vector<Hand> hands_;
  ServoChannel* channel_;
  ServoOptions options_;
  Ring<ServoRecord> ring_;
  Histogram step_times_, lateness_;
  std::atomic<std::uint64_t> ticks_{0}, overruns_{0}, dropped_{0};
  std::atomic<std::uint32_t> faults_{0};
  std::atomic<bool> is_stopping_{false}, wants_reset_{false};
  std::atomic<int> refused_{0};  // 1 scheduling, 2 memory
  int reader_ = -1;
  std::thread thread_;
};

/// Asks the kernel to run the calling thread before ordinary ones; false when that is not allowed.
bool request_realtime(int priority) noexcept;

}  // namespace trephine::haptics
