// PedalButton: the first button of a foot pedal, which acts as the left button of the mouse.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "haptics/device/device.h"

namespace trephine::view {

/// The first button of a pedal, read once in each frame. Drawing thread only.
class PedalButton {
 public:
  /// `pedal` may be null.
  explicit PedalButton(std::shared_ptr<haptics::Device> pedal) : pedal_(std::move(pedal)) {}
  ~PedalButton() { close(); }
  Status open() { return pedal_ ? pedal_->open() : std::nullopt; }
  void close() noexcept {
    if (pedal_) pedal_->close();
    pedal_.reset();
  }
  /// Returns the state of the button if it changed since the last call. `t`: time, s. A pedal that does not
  /// respond is closed, and its button counts as released.
  std::optional<bool> change(double t) {
    if (!pedal_) return std::nullopt;
    haptics::Pose pose;
    pose.buttons = 0;
    is_lost_ = !pedal_->read(t, pose);
    if (is_lost_) close();
    const bool is_pressed = !is_lost_ && pose.is_pressed();
    if (std::exchange(is_pressed_, is_pressed) == is_pressed) return std::nullopt;
    return is_pressed;
  }
  /// Returns true once after the pedal stopped responding.
  bool take_loss() noexcept { return std::exchange(is_lost_, false); }

 private:
  std::shared_ptr<haptics::Device> pedal_;
  bool is_pressed_ = false, is_lost_ = false;
};

}  // namespace trephine::view
