// SharedDevice: a device whose pose another process provides through shared memory, such as the window of
// trephine virtual-device. docs/file-formats.md describes the memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "haptics/device/device.h"
#include "haptics/device/latest.h"

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
class SharedDeviceMemory {
 public:
  static constexpr int k_max_index = 9;

  /// Creates the memory of the device with this index. Error if another host has it.
  static Result<std::shared_ptr<SharedDeviceMemory>> create(int index);
  /// Opens the memory of a host. Error if there is no host with this index.
  static Result<std::shared_ptr<SharedDeviceMemory>> open(int index);
  /// Returns true if a host with this index is open.
  static bool exists(int index);
  ~SharedDeviceMemory();
  SharedDeviceMemory(const SharedDeviceMemory&) = delete;
  SharedDeviceMemory& operator=(const SharedDeviceMemory&) = delete;

  Latest<SharedPose>& pose() noexcept { return block_->pose; }
  Latest<SharedWrench>& wrench() noexcept { return block_->wrench; }

 private:
  static constexpr char k_magic[8] = {'T', 'R', 'E', 'P', 'H', 'D', 'E', 'V'};
  static constexpr std::uint32_t k_layout = 1;
  struct Block {
    char magic[8];
    std::uint32_t layout, reserved;
    alignas(64) Latest<SharedPose> pose;
    alignas(64) Latest<SharedWrench> wrench;
  };
  static_assert(offsetof(Block, pose) == 64 && offsetof(Block, wrench) == 192);
  SharedDeviceMemory() = default;

  std::string file_;  ///< of a host; empty: not the host
  int descriptor_ = -1;
  Block* block_ = nullptr;
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
