// VirtualDeviceHost: a device of shared memory with a simulated hand, for tests without hardware.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "haptics/device/shared_device.h"

namespace trephine::workbench {

/// Statistics of the rendered force or torque in one interval: mean of the magnitudes, and the mean plus
/// their standard deviation, which shows vibration (Kadlecek 2013, equation 3.20).
struct WrenchInterval {
  double mean_force = 0, noisy_force = 0;    ///< N
  double mean_torque = 0, noisy_torque = 0;  ///< N mm
};

struct VirtualDeviceOptions {
  int index = 0;                                 ///< other programs open the device as remote:INDEX
  haptics::HandModel hand;                       ///< follows the requested pose, and yields to forces
  std::optional<haptics::PosePath> motion = {};  ///< requested poses instead of those of the user
  std::shared_ptr<haptics::Device> attached =
      nullptr;                ///< open device whose pose is used instead; may be null
  double record_seconds = 0;  ///< longest recording; 0: no recording
};

/// Publishes poses and receives wrenches 1000 times per second, on a thread of its own, until it is
/// destroyed.
class VirtualDeviceHost {
 public:
  struct State {
    haptics::Pose request, pose;  ///< device frame, mm
    haptics::Wrench wrench;       ///< zero if no program has written for 50 ms
    bool is_connected = false;    ///< a program writes wrenches
    bool is_playing = false;      ///< the motion of the options has not ended
    double seconds = 0;
  };
  static constexpr double k_interval = 0.02;       ///< s, of WrenchInterval: 20 ticks
  static constexpr std::size_t k_intervals = 500;  ///< that are kept

  static Result<std::unique_ptr<VirtualDeviceHost>> open(const VirtualDeviceOptions& options);
  ~VirtualDeviceHost();
  VirtualDeviceHost(const VirtualDeviceHost&) = delete;
  VirtualDeviceHost& operator=(const VirtualDeviceHost&) = delete;

  /// Sets the pose that the user requests.
  void request(const haptics::Pose& pose);
  State state() const;
  /// Returns the newest intervals, oldest first.
  std::vector<WrenchInterval> intervals() const;
  /// Returns the recorded motion of the simulated hand as a path. Ends the recording.
  Result<haptics::PosePath> recording();

 private:
  explicit VirtualDeviceHost(const VirtualDeviceOptions& options);
  void run();
  void step(double t, double dt);

  const VirtualDeviceOptions options_;
  std::shared_ptr<haptics::SharedDeviceMemory> memory_;
  mutable std::mutex lock_;  ///< guards all below
  State state_;
  haptics::Pose user_;
  haptics::SimulatedHand hand_;
  std::deque<WrenchInterval> intervals_;
  std::vector<double> forces_, torques_;  ///< magnitudes in the current interval
  std::vector<haptics::PosePath::Sample> recording_;
  bool is_recording_ = false;
  std::uint64_t wrench_count_ = 0;
  double wrench_time_ = -1e9;
  bool is_stopping_ = false;
  std::uint64_t pose_count_ = 0;  ///< used by the thread
  std::thread thread_;
};

}  // namespace trephine::workbench
