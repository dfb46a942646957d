// SharedDevice: a device whose pose another process provides through shared memory, such as the window of
// trephine virtual-device. docs/file-formats.md describes the memory.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "haptics/device/device.h"

namespace trephine::haptics {

/// Pose in the device frame: x to the right, y up, z toward the user.
struct SharedPose {
  std::uint64_t count = 0;               ///< of poses so far; a device that does not count is lost
  double position[3] = {};               ///< mm
  double orientation[4] = {1, 0, 0, 0};  ///< unit quaternion, w first
  std::uint64_t buttons = 0;
};
/// Wrench that the device renders, in the device frame.
struct SharedWrench {
  std::uint64_t count = 0;  ///< of wrenches so far
  double force[3] = {};     ///< N
  double torque[3] = {};    ///< N mm
};

/// Memory of one device. One process, the host, owns it and writes poses; one other process writes wrenches.
/// The file is accessed by system calls that do not wait: a file that another program truncates gives no
/// values, where mapped memory would end the program.
class SharedDeviceMemory {
 public:
  static constexpr int k_max_index = 9;

  /// Creates the memory of the device with this index. Error if another host has it, or if another file has
  /// its name.
  static Result<std::shared_ptr<SharedDeviceMemory>> create(int index);
  /// Opens the memory of a host. Error if there is no host with this index, or if another program uses it.
  static Result<std::shared_ptr<SharedDeviceMemory>> open(int index);
  /// Returns true if a host with this index is open.
  static bool exists(int index);
  ~SharedDeviceMemory();
  SharedDeviceMemory(const SharedDeviceMemory&) = delete;
  SharedDeviceMemory& operator=(const SharedDeviceMemory&) = delete;

  void set_pose(const SharedPose& pose) noexcept { set(k_pose, &pose, sizeof pose); }
  void set_wrench(const SharedWrench& wrench) noexcept { set(k_wrench, &wrench, sizeof wrench); }
  /// Nothing if no value was written, or if the writer was active during each of four attempts.
  std::optional<SharedPose> pose() const noexcept { return get<SharedPose>(k_pose); }
  std::optional<SharedWrench> wrench() const noexcept { return get<SharedWrench>(k_wrench); }

 private:
  static constexpr long k_pose = 64, k_wrench = 192;  ///< bytes from the start of the file
  SharedDeviceMemory() = default;
  void set(long at, const void* value, std::size_t bytes) noexcept;
  bool get(long at, void* value, std::size_t bytes) const noexcept;
  template <class T>
  std::optional<T> get(long at) const noexcept {
    T value;
    return get(at, &value, sizeof value) ? std::optional(value) : std::nullopt;
  }

  std::string file_;  ///< of a host; empty: not the host
  int descriptor_ = -1;
  std::uint64_t sequence_ = 0;  ///< of the slot that this process writes
};

/// The pose that a host provides. read() fails if the host stops to count for 0.1 s.
class SharedDevice final : public Device {
 public:
  explicit SharedDevice(int index) : index_(index) {}
  ~SharedDevice() override { close(); }
  Status open() override;
  void close() noexcept override;
  DeviceCapabilities capabilities() const override {
    return {.name = "virtual device",
            .degrees_of_freedom = 6,
            .max_force = 8,
            .max_stiffness = 1,
            .workspace_radius = k_workspace_radius,
            .max_torque = 500};
  }
  bool read(double t, Pose& pose) noexcept override;
  void write(const Wrench& wrench) noexcept override;

  static constexpr double k_workspace_radius = 80;  ///< mm

 private:
  int index_;
  std::shared_ptr<SharedDeviceMemory> memory_;
  SharedPose last_;
  std::uint64_t wrenches_ = 0;
  double counted_at_ = 0;  ///< time of the newest pose, s
  bool has_pose_ = false;
};

}  // namespace trephine::haptics
