// ServoLoop: thread that reads devices, steps their hands and writes forces, at 250 Hz to 10 kHz.
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
  double watchdog_seconds = 0.1;  ///< if a tick begins later than this after its due time, the force fades
  double lag_seconds = 0.5;       ///< if unread records span more time, the scene is stale: the force fades
  /// Number of records that may wait for the edit thread; 0: twice the number of records of `lag_seconds`,
  /// at least 4096 and at most 2^20. The scene is also stale if the ring is more than half full.
  std::size_t ring_capacity = 0;
  bool wants_realtime = true;  ///< SCHED_FIFO and locked memory, if permitted
};

/// Figures of a running or finished loop.
struct ServoReport {
  std::uint64_t ticks = 0, overruns = 0;  ///< overrun: a tick that began more than a period late
  std::uint64_t dropped = 0;              ///< ticks without room in the ring for their records
  double step_p50_us = 0, step_p99_us = 0, step_p999_us = 0, step_max_us = 0;  ///< duration of a tick
  double late_p50_us = 0, late_p99_us = 0, late_p999_us = 0, late_max_us = 0;  ///< delay of a tick's begin
  std::uint32_t faults = 0;
  std::string notice;  ///< refused real-time privileges, as text; empty when all were granted
};

/// One thread for all hands. For each hand, a tick reads the device, steps the core and writes the wrench.
/// All hands of a tick use the same ServoScene.
class ServoLoop {
 public:
  /// Borrows devices and channel for the lifetime of the loop. `first_tick`: number of the first tick, for a
  /// resumed session.
  ServoLoop(std::span<Device* const> devices, ServoChannel& channel, const ServoOptions& options,
            std::uint64_t first_tick = 0);
  /// For one hand.
  ServoLoop(Device& device, ServoChannel& channel, const ServoOptions& options);
  ~ServoLoop();
  ServoLoop(const ServoLoop&) = delete;
  ServoLoop& operator=(const ServoLoop&) = delete;

  /// Opens the devices and starts the thread. Error if the loop is running. Also an error, with all devices
  /// closed, if the rate is out of range, a force limit exceeds that of a device (use within_limits()), a
  /// device fails to open, too many loops read the channel, or the scene has fewer hands than there are
  /// devices.
  Status start();
  /// Stops the thread and closes the devices; a second call does nothing.
  void stop();

  /// Returns the ring from which one thread reads the records. Each tick adds a record per hand, in the order
  /// of the hands. When the ring is full, whole ticks are dropped: the proxies stop, the force fades out, and
  /// fault_full_ring is latched.
  Ring<ServoRecord>& records() noexcept { return ring_; }
  /// Requests that the servo set a hand's proxy on a free point (volume frame) at its next tick, with force
  /// from zero. Requests beyond 16 between two ticks are dropped. Call on one thread, the edit thread.
  void request_restart(const glm::dvec3& free_point_volume, std::size_t hand = 0) noexcept;
  /// Clears latched faults of all hands at the next tick. Their proxies stay, and the force rises from zero.
  /// The tool of a person at a force device does not work until its button was released; a mouse or a
  /// simulated hand continues. Call on the user's request, after the cause is removed.
  void request_reset() noexcept { wants_reset_ = true; }
  /// Returns the present faults of all hands. Cost: one read.
  std::uint32_t faults() const noexcept { return faults_.load(std::memory_order_relaxed); }
  ServoReport report() const;

 private:
  struct Hand {
    Device* device;
    ServoCore core;
    Pose pose;
    std::uint32_t faults = 0;
    /// After a fault, buttons and axes count as released until they are released.
    bool is_locked = false;
    bool has_motors = false;  ///< of the device
    Ring<glm::dvec3> restarts{16};
  };
  void run() noexcept;
  static void lock_buttons(Hand& hand) noexcept;
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

/// Requests real-time scheduling of the calling thread; false if that is not permitted.
bool request_realtime(int priority) noexcept;

}  // namespace trephine::haptics
