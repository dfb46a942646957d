// CompositeDevice: the pose of one device, with the buttons and axes of another, such as a pedal.
#pragma once

#include <memory>
#include <utility>

#include "haptics/device/device.h"

namespace trephine::haptics {

/// Adds the buttons of a second device to those of the first; if an axis of the first is zero, the axis of
/// the second replaces it. Both must respond: a lost pedal stops the tool as a lost stylus does.
class CompositeDevice final : public Device {
 public:
  CompositeDevice(std::shared_ptr<Device> pose, std::shared_ptr<Device> buttons)
      : pose_(std::move(pose)), buttons_(std::move(buttons)) {}
  Status open() override {
    if (Status error = pose_->open()) return error;
    Status error = buttons_->open();
    if (error) pose_->close();
    return error;
  }
  void close() noexcept override { buttons_->close(), pose_->close(); }
  DeviceCapabilities capabilities() const override { return pose_->capabilities(); }
  bool read(double t, Pose& pose) noexcept override {
    Pose buttons;
    buttons.buttons = 0;
    // Both are read in each tick, so that neither misses a time step.
    const bool responds = buttons_->read(t, buttons);
    Pose own = pose;
    if (!pose_->read(t, own) || !responds) return false;
    own.buttons |= buttons.buttons;
    for (std::size_t i = 0; i < own.axes.size(); ++i)
      if (own.axes[i] == 0) own.axes[i] = buttons.axes[i];
    pose = own;
    return true;
  }
  std::optional<glm::dvec3> fetch_jump() noexcept override { return pose_->fetch_jump(); }
  void write(const Wrench& wrench) noexcept override { pose_->write(wrench); }
  void set_view(const DeviceView& view) noexcept override { pose_->set_view(view); }
  std::optional<Workspace> workspace() const noexcept override { return pose_->workspace(); }

 private:
  std::shared_ptr<Device> pose_, buttons_;
};

}  // namespace trephine::haptics
