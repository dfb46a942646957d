// MappedDevice: a device in its own frame as a tool in the world: scale, axes, clutch.
#pragma once

#include <memory>

#include "haptics/device/device.h"
#include "haptics/device/latest.h"

namespace trephine::haptics {

struct WorkspaceMap {
  double scale = 1;               ///< motion of the tool per motion of the device, 0.1 to 10
  std::uint32_t clutch_mask = 2;  ///< buttons that hold the tool in place while pressed; 0: no clutch
  /// Duration in which the force returns after the clutch is released, or the device responds again.
  double resume_seconds = 0.1;
};

/// Error if a value is out of range.
Status check(const WorkspaceMap& map);

/// Maps poses of a device (origin in the centre of its workspace; x to the right, y up, z toward the user) to
/// the world, and forces back. The tool stays in place when the axes change. While the clutch is pressed the
/// hand moves without the tool, which turns with the hand: no force, and the first button counts as released.
/// A pose that is not finite counts as no pose. Sessions record poses after this map, so a replay does not
/// depend on it. set_view() may run on any one thread.
class MappedDevice final : public Device {
 public:
  MappedDevice(std::shared_ptr<Device> device, const WorkspaceMap& map);
  Status open() override;
  void close() noexcept override { device_->close(); }
  /// Capabilities in the world: a scale of s multiplies the workspace by s, and divides stiffness, damping
  /// and mass by s.
  DeviceCapabilities capabilities() const override;
  bool read(double t, Pose& pose) noexcept override;
  std::optional<glm::dvec3> fetch_jump() noexcept override;
  void write(const Wrench& wrench) noexcept override;
  void set_view(const DeviceView& view) noexcept override;
  std::optional<Workspace> workspace() const noexcept override;

 private:
  std::shared_ptr<Device> device_;
  WorkspaceMap map_;
  Latest<DeviceView> view_;
  Latest<Workspace> workspace_;  ///< radius 0: unknown, or not open
  // Servo thread: a position p of the device is at anchor_world_ + R s (p - anchor_device_).
  glm::dvec3 anchor_device_{0.0}, anchor_world_{0.0};
  glm::dquat world_from_device_{1, 0, 0, 0};
  glm::dvec3 position_world_{0.0};
  double radius_ = 0;  ///< mm, of the workspace in the world
  bool has_anchor_ = false, is_clutched_ = false;
  bool is_lost_ = false;  ///< the device did not respond to the last read()
  double time_ = 0, released_at_ = -1e9;
};

}  // namespace trephine::haptics
