// The servo: pose in, proxy and force out, at 250 Hz to 10 kHz on a thread of its own.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "haptics/device.h"
#include "haptics/force.h"
#include "haptics/histogram.h"
#include "haptics/ring.h"

namespace trephine::haptics {

/// What one tick did, for the edit thread, recordings and displays.
struct ServoRecord {
  std::uint64_t tick = 0;
  double t = 0;               ///< s since the start
  std::uint64_t version = 0;  ///< serial of the version the tick saw
  Pose pose;
  glm::dvec3 proxy_world{0.0}, normal_world{0.0}, force_world{0.0};
  bool has_contact = false, is_buried = false;
  int shape = -1, side = 0;
  std::uint32_t faults = 0;
};

/// The work of one tick, shared by the live loop and the lockstep of sim. Holds all state of the feel.
class ServoCore {
 public:
  /// Borrows scene and method, which was prepared for it.
  ServoCore(const TouchScene& scene, const ProxyMethod& method, const ForceOptions& options, double dt);
  /// Servo thread. `faults` were seen outside this tick. A pose that is no place gives no force and a latched
  /// fault.
  ServoRecord step(const volume::Version& version, const Pose& pose, double t, std::uint32_t faults) noexcept;
  /// The proxy starts anew at a free point and the force from zero.
  void restart_at(const glm::dvec3& free_point_volume) noexcept;
  void reset() noexcept;
  const ProxyStep& last_step() const noexcept { return step_; }
  const ProxyState& proxy_state() const noexcept { return state_; }

 private:
  const TouchScene* scene_;
  const ProxyMethod* method_;
  ForceModel force_;
  ForceGuard guard_;
  ProxyState state_;
  ProxyStep step_;
  std::uint64_t tick_ = 0;
};

struct ServoOptions {
  double rate_hz = 1000;  ///< 250 to 10000
  ForceOptions force;
  double watchdog_seconds = 0.1;  ///< a tick later than this fades the force
  std::size_t ring_capacity = 4096;
  bool wants_realtime = true;  ///< SCHED_FIFO and locked memory, when allowed
};

/// Figures of a running or finished loop.
struct ServoReport {
  std::uint64_t ticks = 0, overruns = 0;  ///< overrun: a tick that began a whole period late
  double step_p50_us = 0, step_p99_us = 0, step_p999_us = 0, step_max_us = 0;
  double late_p50_us = 0, late_p99_us = 0, late_p999_us = 0, late_max_us = 0;  ///< wake-up after its due time
  std::uint32_t faults = 0;
  std::string notice;  ///< what real-time help was refused, in words; empty when all was granted
};

class ServoLoop {
 public:
  /// Borrows everything for its life.
  ServoLoop(Device& device, volume::VersionChannel& channel, const TouchScene& scene,
            const ProxyMethod& method, const ServoOptions& options);
  ~ServoLoop();
  ServoLoop(const ServoLoop&) = delete;
  ServoLoop& operator=(const ServoLoop&) = delete;

  /// Opens the device and starts the thread.
  volume::Status start();
  /// Stops the thread and closes the device; a second call does nothing.
  void stop();

  /// Consumer's end of the records; one thread.
  Ring<ServoRecord>& records() noexcept { return ring_; }
  /// Asks the servo to put the proxy on a free point (volume frame) at its next tick, with force from zero.
  void request_restart(const glm::dvec3& free_point_volume) noexcept;
  /// Clears latched faults at the next tick; the proxy starts anew at the HIP, the force from zero. A person
  /// asks for it, once the cause is gone.
  void request_reset() noexcept { wants_reset_ = true; }
  ServoReport report() const;

 private:
  void run() noexcept;

  Device* device_;
  volume::VersionChannel* channel_;
  ServoOptions options_;
  ServoCore core_;
  Ring<ServoRecord> ring_;
  Ring<glm::dvec3> restarts_{16};
  Histogram step_times_, lateness_;
  std::atomic<std::uint64_t> ticks_{0}, overruns_{0};
  std::atomic<std::uint32_t> faults_{0};
  std::atomic<bool> is_stopping_{false}, wants_reset_{false};
  std::atomic<int> refused_{0};  // 1 scheduling, 2 memory
  int reader_ = -1;
  std::thread thread_;
};

}  // namespace trephine::haptics
